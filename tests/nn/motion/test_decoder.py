"""The motion model's file and its inference; torch is the truth of a freshly trained one."""

from __future__ import annotations

import importlib.util
import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from footwork.core.body.retarget import retarget
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.npz import write_npz
from footwork.nn.motion.body import starter_skeleton
from footwork.nn.motion.conditions import SIZE, conditions, poses_of, root_of, soft_contacts
from footwork.nn.motion.decoder import ANSWERS, LATENT, MotionModel, read_model, save_model


@pytest.fixture
def model() -> MotionModel:
    """Random weights of a small network."""
    rng = np.random.RandomState(3)
    widths = [SIZE + 2, 12, 9, ANSWERS]
    return MotionModel(
        people=("one", "two"),
        scale=(rng.normal(size=SIZE), rng.uniform(0.5, 2.0, SIZE)),
        answer_scale=(rng.normal(size=ANSWERS), rng.uniform(0.5, 2.0, ANSWERS)),
        weights=tuple(rng.normal(size=(a + LATENT, b)) * 0.3 for a, b in itertools.pairwise(widths)),
        biases=tuple(rng.normal(size=b) for b in widths[1:]),
        manners=(rng.normal(size=(2, LATENT)), rng.uniform(0.5, 2.0, (2, LATENT))),
        provenance={"takes": []},
    )


def test_poses_are_those_of_the_formula(model: MotionModel) -> None:
    rng = np.random.RandomState(4)
    told, manner = rng.normal(size=(50, SIZE)), rng.normal(size=(50, LATENT))
    got = model.poses(told, 1, manner)
    for t in (0, 49):
        x = [*((told[t] - model.scale[0]) / model.scale[1]), 0.0, 1.0]
        for n, (weight, bias) in enumerate(zip(model.weights, model.biases, strict=True)):
            sums = [
                float(np.dot([*x, *manner[t]], column)) + b for column, b in zip(weight.T, bias, strict=True)
            ]
            x = sums if n == 2 else [s if s > 0 else float(np.exp(s)) - 1.0 for s in sums]
        assert np.allclose(got[t], np.array(x) * model.answer_scale[1] + model.answer_scale[0])


def test_a_saved_model_answers_the_same(model: MotionModel, tmp_path: Path) -> None:
    save_model(tmp_path / "m.npz", model)
    back = read_model(tmp_path / "m.npz")
    rng = np.random.RandomState(5)
    told, manner = rng.normal(size=(20, SIZE)), rng.normal(size=(20, LATENT))
    assert np.allclose(back.poses(told, 0, manner), model.poses(told, 0, manner), atol=0.1)
    assert back.people == model.people
    save_model(tmp_path / "n.npz", back)
    assert (tmp_path / "m.npz").read_bytes() == (tmp_path / "n.npz").read_bytes()


def test_a_damaged_model_is_told_in_one_line(model: MotionModel, tmp_path: Path) -> None:
    path = tmp_path / "m.npz"
    with pytest.raises(InputError, match="no such file"):
        read_model(path)
    save_model(path, model)
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="is damaged"):
        read_model(path)
    with path.open("wb") as file:
        write_npz(file, {"a": np.zeros(3)})
    with pytest.raises(InputError, match="no motion model"):
        read_model(path)
    save_model(path, replace(model, biases=(*model.biases[:-1], np.full(ANSWERS, np.nan))))
    with pytest.raises(InputError, match="not finite"):
        read_model(path)
    save_model(path, replace(model, weights=(model.weights[0][1:], *model.weights[1:])))
    with pytest.raises(InputError, match="weight_0"):
        read_model(path)


@pytest.mark.skipif(importlib.util.find_spec("torch") is None, reason="torch is not installed")
def test_training_learns_a_walk_and_numpy_answers_it() -> None:
    import torch
    from footwork.nn.train.motion import Body, train_motion

    motion = retarget(demo_motion("walk", fps=30.0), starter_skeleton(), scale_travel=True)
    root = root_of(motion)
    toes = motion.forward()[0][:, [motion.skeleton.joint(f"toe.{side}") for side in "LR"], 2]
    steps = (toes < toes.min(axis=0) + 0.005).astype(np.float64)
    shown = np.ones(len(root))
    shown[:30] = shown[-30:] = 0.0
    arrays = {
        "x": conditions(root, soft_contacts(steps, 30.0)),
        "y": poses_of(motion, root),
        "w": shown,
        "person": np.zeros(len(root)),
        "place": np.column_stack([root.places, root.heights]),
        "yaw": root.yaws,
        "contact": steps,
    }
    model = train_motion(arrays, ("one",), {}, steps=500, batch=32)
    manner = np.tile(model.manners[0], (len(root), 1))
    got = model.poses(arrays["x"], 0, manner)[30:-30]
    start = np.abs(arrays["y"][30:-30] - model.answer_scale[0]).mean()
    assert np.abs(got - arrays["y"][30:-30]).mean() < 0.75 * start

    # the body in torch stands as the one in numpy
    body = Body(starter_skeleton())
    turned = body.rotations(torch.from_numpy(arrays["y"][:, 3:].astype(np.float32)))
    places = body.positions(torch.from_numpy(arrays["y"][:, :3].astype(np.float32)), turned).numpy()
    world, _ = motion.forward()
    ahead = quat.rotate(quat.from_yaw(root.yaws)[:, None], places.astype(np.float64))
    ahead += np.column_stack([root.places, root.heights])[:, None]
    assert np.allclose(ahead, world, atol=1e-4)
