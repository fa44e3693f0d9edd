"""What a window network is shown: windows of one take each, in the body's or the headset's axes, and their mirror
images."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import fields

import numpy as np
import pytest
from footwork.core.maths import quat
from footwork.core.recording.windows import (
    CAUSAL,
    LOOK_AHEAD,
    WindowLayout,
    mirror_inputs,
    stream,
    take_windows,
    window_inputs,
)
from footwork.nn.parts import EVERYTHING
from footwork.nn.train.augment import Augmentation
from footwork.nn.train.samples import Sample

pytestmark = pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="torch is not installed")

RATE = 60.0
PLAIN = Augmentation(**{item.name: 0.0 for item in fields(Augmentation)})
"""Windows as they are."""


@pytest.fixture(scope="module")
def samples(tumble) -> list[Sample]:
    """Takes of which no two are alike in place, size or length; all but one are shorter than a window."""
    rng = np.random.default_rng(4)
    out: list[Sample] = []
    for k, frames in enumerate((70, 45, 230, 55)):
        times = np.arange(frames)[:, None, None] / RATE
        rate, phase, place = (
            rng.uniform(0.5, 3.0, (3, 3)),
            rng.uniform(0.0, 6.0, (3, 3)),
            rng.normal(0.0, 3.0, 3),
        )
        positions = place + [0.0, 0.0, 1.5] + 0.5 * np.sin(rate * times + phase)
        rotations = tumble(frames, RATE, count=3, seed=20 + k)
        yaws = rng.uniform(-3.0, 3.0) + np.cumsum(rng.normal(0.0, 0.05, frames))
        truth = rng.normal(size=(frames, EVERYTHING.size)).astype(np.float32)
        out.append(Sample(f"take {k}", positions, rotations, yaws, 1.4 + 0.13 * k, truth))
    return out


def truths(samples: Sequence[Sample], layout: WindowLayout) -> tuple[np.ndarray, np.ndarray]:
    """Every window of every take by itself, in either axes, with its answer."""
    inputs: list[np.ndarray] = []
    answers: list[np.ndarray] = []
    for sample in samples:
        valid = np.ones((len(sample), 3), np.bool_)
        rows = stream(sample.positions, sample.rotations, valid, sample.head_height)
        windows = take_windows(rows, np.arange(len(sample)) / RATE, RATE, layout)
        for axes in (sample.yaws, quat.heading(sample.rotations[:, 0])):
            inputs.append(window_inputs(windows, axes, layout))
            answers.append(EVERYTHING.turned(sample.truth, sample.yaws - axes))
    return np.concatenate(inputs), np.concatenate(answers)


@pytest.mark.parametrize("layout", [LOOK_AHEAD, CAUSAL], ids=["look-ahead", "causal"])
def test_every_window_is_one_of_a_single_take(samples: list[Sample], layout: WindowLayout) -> None:
    from footwork.nn.train.window import WindowLearner

    learner = WindowLearner(
        samples,
        layout,
        batch=64,
        learning_rate=1e-3,
        decay=0.0,
        steps=10,
        seed=3,
        hidden=(4,),
        augmentation=PLAIN,
    )
    drawn, answers = learner._draw(1500)
    known, right = truths(samples, layout)
    lengths = [len(sample) for sample in samples]
    owners = np.concatenate([np.full(2 * length, k) for k, length in enumerate(lengths)])
    seen: list[int] = []
    for half, image in ((slice(0, 1500), False), (slice(1500, 3000), True)):
        given = mirror_inputs(drawn[half], layout) if image else drawn[half]
        wanted = EVERYTHING.mirrored(answers[half]) if image else answers[half]
        near = np.array([np.argmin(np.abs(known - row).max(axis=-1)) for row in given])
        assert np.abs(known[near] - given).max() < 1e-4
        np.testing.assert_allclose(right[near], wanted, atol=1e-3)
        seen += owners[near].tolist()
    # a take is seen as often as it is long
    share = np.array(lengths)
    np.testing.assert_allclose(np.bincount(seen, minlength=4) / 3000.0, share / share.sum(), atol=0.06)


def test_windows_that_run_quicker_or_slower_stay_in_their_take(tumble) -> None:
    """Each take stands still at a place of its own, a hundred metres from the next: no window shows any way."""
    from footwork.nn.train.window import WindowLearner

    still = [
        Sample(
            f"take {k}",
            np.tile(
                [[100.0 * k, 7.0, 1.6], [100.0 * k - 0.3, 7.2, 1.1], [100.0 * k + 0.4, 7.3, 1.0]], (40, 1, 1)
            ),
            np.repeat(tumble(1, count=3, seed=k), 40, axis=0),
            np.full(40, 0.3 * k),
            1.6,
            np.zeros((40, EVERYTHING.size), np.float32),
        )
        for k in range(5)
    ]
    quick = Augmentation(**{item.name: 0.0 for item in fields(Augmentation)} | {"stretch": 1.5})
    learner = WindowLearner(
        still,
        LOOK_AHEAD,
        batch=64,
        learning_rate=1e-3,
        decay=0.0,
        steps=10,
        seed=1,
        hidden=(4,),
        augmentation=quick,
    )
    heads, hands = (learner._draw(800)[0][:, group] for group in LOOK_AHEAD.groups[:2])
    assert np.abs(heads.reshape(1600, -1, 3)[..., :2]).max() < 1e-3
    assert np.abs(hands).max() < 1.0
