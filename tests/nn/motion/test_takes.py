"""The starter takes: what they do, how exactly their feet stand, and that every machine makes the same."""

from __future__ import annotations

import os
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.jobs import run
from footwork.core.maths import kinematics, quat
from footwork.nn.motion import ways
from footwork.nn.motion.body import TOE_HEIGHT, starter_skeleton
from footwork.nn.motion.conditions import Root, root_of
from footwork.nn.motion.decoder import read_model
from footwork.nn.motion.steps import plan_steps
from footwork.nn.motion.takes import FPS, WEIGHTS, starter_takes


@pytest.fixture(scope="module")
def takes() -> dict[str, Motion]:
    return dict(run(starter_takes(read_model(WEIGHTS))))


def feet(motion: Motion) -> np.ndarray:
    places, _ = motion.forward()
    return places[:, [motion.skeleton.joint(f"toe.{side}") for side in "LR"]]


def straight(speed: float, seconds: float = 12.0, yaw_rate: float = 0.0) -> Root:
    t = np.arange(round(seconds * 60)) / 60.0
    return Root(60.0, np.column_stack([0 * t, speed * t]), yaw_rate * t, np.full(len(t), 0.91))


def test_the_weights_that_ship_are_small_and_say_whom_they_learnt_from() -> None:
    assert WEIGHTS.stat().st_size < 1_000_000
    told = read_model(WEIGHTS).provenance
    assert told["limits"]
    for take in told["takes"]:
        assert len(take["sha256"]) == 64
        assert any(licence in take["licence"] for licence in ("MIT", "CC BY 4.0"))
        assert not any(word in take["licence"].replace("RSAIT", "") for word in ("NC", "SA", "ND"))


def test_takes_last_ten_to_fifteen_minutes_with_their_mirror_images(takes: dict[str, Motion]) -> None:
    assert 600.0 < 2.0 * sum(len(motion) for motion in takes.values()) / FPS < 930.0


def test_feet_that_stand_do_not_slide_and_never_sink(takes: dict[str, Motion]) -> None:
    for name, motion in takes.items():
        toes = feet(motion)
        speed = np.linalg.norm(kinematics.velocity(toes, FPS), axis=-1)
        # half of the time at least one foot stands still, to a tenth of a millimetre per frame
        assert np.mean(speed.min(axis=1) < 0.006) > (0.1 if name.startswith("jog") else 0.5), name
        assert toes[..., 2].min() > TOE_HEIGHT - 1e-3, name


def test_feet_keep_apart(takes: dict[str, Motion]) -> None:
    for name, motion in takes.items():
        toes = feet(motion)[..., :2]
        assert np.linalg.norm(toes[:, 1] - toes[:, 0], axis=-1).min() > 0.09, name


def test_legs_reach_and_nothing_jumps(takes: dict[str, Motion]) -> None:
    for name, motion in takes.items():
        assert np.abs(np.linalg.norm(motion.rotations, axis=-1) - 1.0).max() < 1e-9
        places, _ = motion.forward()
        assert np.linalg.norm(np.diff(places, axis=0), axis=-1).max() * FPS < 10.0, name


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [("walk", 0.3, 1.9), ("jog", 1.8, 3.6), ("back", -1.3, -0.3), ("crab", -1.3, 1.3)],
)
def test_speeds_are_those_of_the_script(
    takes: dict[str, Motion], name: str, least: float, most: float
) -> None:
    root = root_of(takes[name])
    back = quat.from_yaw(-root.yaws)
    steps = np.pad(kinematics.velocity(root.places, FPS), ((0, 0), (0, 1)))
    ahead = quat.rotate(back, steps)[:, 1]
    end = ahead.min() if most < 0.0 else ahead.max()
    assert least <= end <= most


def test_crouches_are_low_and_turns_turn(takes: dict[str, Motion]) -> None:
    low = takes["crouch"].positions[:, 2] / starter_skeleton().offsets[0, 2]
    assert 0.68 < low.min() < 0.8
    yaws = root_of(takes["turn"]).yaws
    assert np.abs(np.diff(yaws)).sum() > 8 * np.pi


@pytest.mark.parametrize(("speed", "apart"), [(0.8, 0.60), (1.2, 0.54), (2.5, 0.33)])
def test_walkers_step_with_one_foot_and_the_other_as_often_as_people_do(speed: float, apart: float) -> None:
    contacts = plan_steps(straight(speed), np.random.RandomState(0), 0.94)
    lifts = sorted(
        (t, side) for side in (0, 1) for t in np.flatnonzero(np.diff(contacts[:, side].astype(int)) < 0)
    )
    assert all(a[1] != b[1] for a, b in pairwise(lifts))
    assert np.mean(np.diff([t for t, _ in lifts])) / 60.0 == pytest.approx(apart, rel=0.06)


def test_who_stands_does_not_step_and_who_turns_does() -> None:
    assert plan_steps(straight(0.0), np.random.RandomState(0), 0.94).all()
    turns = plan_steps(straight(0.0, yaw_rate=1.0), np.random.RandomState(0), 0.94)
    assert not turns.all()
    assert turns.any(axis=1).all()


def test_wandering_has_unit_deviation_and_is_smooth() -> None:
    noise = ways.wander(np.random.RandomState(1), 60 * 600, 60.0, 2.0)
    assert noise.std() == pytest.approx(1.0, abs=0.15)
    assert np.abs(np.diff(noise, n=2)).max() * 3600 < 6.0


_MADE = """
import hashlib
from footwork.core.jobs import run
from footwork.nn.motion.decoder import read_model
from footwork.nn.motion.takes import WEIGHTS, starter_takes
digest = hashlib.sha256()
for _, motion in run(starter_takes(read_model(WEIGHTS), fps=30.0)):
    digest.update(motion.positions.tobytes("C") + motion.rotations.tobytes("C"))
print(digest.hexdigest())
"""


def test_threads_change_nothing() -> None:
    made = {
        subprocess.run(
            [sys.executable, "-c", _MADE],
            env={**os.environ, "OMP_NUM_THREADS": threads, "OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for threads in ("1", "3")
    }
    assert len(made) == 1
