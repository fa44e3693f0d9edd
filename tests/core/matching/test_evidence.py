"""Evidence of the feet: costs beside brute force, searches that step with the user, the paper's left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.body.motion import Motion
from footwork.core.body.standing import standing_head_height
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.evaluation.true_estimate import true_estimate
from footwork.core.jobs import run
from footwork.core.matching import evidence as ev
from footwork.core.matching.body_target import elbows_of, with_estimate
from footwork.core.matching.posture_model import Posture
from footwork.core.matching.trajectory import make_trajectory
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.pipeline import BakeResult, bake
from footwork.core.recording.body_estimate import BodyEstimate, Part
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig.fit import rig_from_skeleton
from footwork.core.settings import PAPER, BakeSettings, DatabaseSettings
from scipy.spatial.transform import Rotation

FPS = 30.0


@pytest.fixture(scope="module")
def database() -> MotionDatabase:
    takes = [
        Take(name, f"{name}.bvh", name.encode().hex().ljust(64, "0"), demo_motion(name, 3, FPS), {}, ())
        for name in ("walk", "turn", "sidestep")
    ]
    return run(build_database(takes, DatabaseSettings(fps=FPS), name="walking"))


@pytest.fixture(scope="module")
def user() -> Motion:
    return cut(demo_motion("walk", 11, FPS, height=1.66), 40, 400)


@pytest.fixture(scope="module")
def known(user) -> BodyEstimate:
    return true_estimate(user, standing_head_height(user))


def baked(user: Motion, database: MotionDatabase, estimate: BodyEstimate, **settings) -> BakeResult:
    options = BakeSettings(**settings)
    rig = rig_from_skeleton(user.skeleton, "rig")
    return run(bake(simulate_recording(user, "u"), [database], lambda _: estimate, rig, options, truth=user))


def scalar_first(rotations: Rotation) -> np.ndarray:
    return np.roll(rotations.as_quat(), 1, axis=-1)


def some_evidence(frames: int, seed: int) -> ev.FeetEvidence:
    rng = np.random.default_rng(seed)
    ankles = rng.normal([0.0, 0.0, -0.8], 0.2, (frames, 2, 3))
    return ev.FeetEvidence(ankles, rng.uniform(5.0, 40.0, (frames, 2)), rng.uniform(0.0, 1.0, (frames, 2)))


def test_costs_are_those_of_each_foot_by_hand(database) -> None:
    """Ankles by forward kinematics of the database's poses, turned as the root is turned."""
    rng = np.random.default_rng(4)
    frames, yaws = rng.integers(0, len(database), 12), rng.uniform(-3.0, 3.0, 12)
    evidence = some_evidence(5, 9)
    found = ev.FeetTable(database).costs(evidence, 3, frames, yaws)
    poses, skeleton = database.poses, database.skeleton
    motion = Motion(skeleton, FPS, np.array(poses.hips_positions[frames]), np.array(poses.rotations[frames]))
    places = motion.forward()[0]
    ankles = places[:, [skeleton.joint(f"foot.{side}") for side in "LR"]] - places[:, :1]
    for n, yaw in enumerate(yaws):
        turned = Rotation.from_euler("z", yaw).apply(ankles[n])
        weights, wanted = evidence.weights[3], evidence.ankles[3]
        cost = sum(weights[i] * np.sum((turned[i, :2] - wanted[i, :2]) ** 2) for i in range(2))
        higher = (turned[0] - turned[1] - wanted[0] + wanted[1])[2]
        cost += weights.mean() * higher**2
        stands = poses.contacts[frames[n]]
        cost += sum(ev.STANDING_WEIGHT * ev.FEET_M**2 * weights * (stands - evidence.standing[3]) ** 2)
        assert found[n] == pytest.approx(cost, rel=1e-3)


def test_likely_frames_are_the_best_of_their_blocks(database) -> None:
    rng = np.random.default_rng(8)
    frames = 90
    path = np.cumsum(rng.normal(0.0, 0.02, (frames, 2)), axis=0)
    trajectory = make_trajectory(path, np.cumsum(rng.normal(0, 0.03, frames)), FPS, BakeSettings())
    evidence, times = some_evidence(frames, 2), np.array([0, 33, 71])
    known = np.flatnonzero(database.features.trajectory_valid)
    table = ev.FeetTable(database)
    found = ev.likely_frames(database, table, known, evidence, trajectory, times)
    assert found.shape == (3, ev.LIKELY)
    looks = [0, 5, 10]
    for row, t in zip(found, times.tolist(), strict=True):
        costs = np.zeros(len(database))
        for ahead in looks:
            then = min(t + ahead, frames - 1)
            silent = replace(evidence, standing=None, ankles=evidence.ankles * [1, 1, 0])
            later = np.minimum(known + ahead, table._last[known])
            here = ev.FeetTable(database)
            here._feet = here._feet * [1, 1, 0]
            costs[known] += here.costs(silent, then, later, np.full(len(known), trajectory.yaws[then]))
        features = database.features
        turn = Rotation.from_euler("z", -trajectory.yaws[t]).as_matrix()[:2, :2]
        ahead = (trajectory.future_positions[t] - trajectory.targets[t]) @ turn.T
        facing = trajectory.future_yaws[t] - trajectory.yaws[t]
        wanted = np.concatenate([ahead.ravel(), np.column_stack([-np.sin(facing), np.cos(facing)]).ravel()])
        wanted = (wanted - features.mean[:12]) / features.deviation[:12]
        costs[known] += np.sum((features.values[known, :12] - wanted) ** 2, axis=1)
        blocks = np.pad(known, (0, -len(known) % 16), mode="edge").reshape(-1, 16)
        least = np.sort(costs[blocks].min(axis=1))[: ev.LIKELY]
        np.testing.assert_allclose(np.sort(costs[row]), least, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("search", ["path", "greedy"])
def test_who_knows_the_feet_steps_with_the_user(user, database, known, search: str) -> None:
    blind = baked(user, database, BodyEstimate(known.yaws), search=search).report["metrics"]
    seeing = baked(user, database, replace(known, hips=None), search=search).report["metrics"]
    assert seeing["phase_agreement"] >= max(0.8, blind["phase_agreement"])
    assert seeing["lower_body_mpjpe_cm"]["mean"] < blind["lower_body_mpjpe_cm"]["mean"]
    assert seeing["invented_steps_per_min"] <= blind["invented_steps_per_min"]
    assert seeing["hand_position_error_cm"]["max"] < 0.01


def test_who_is_unsure_of_them_says_nothing(user, database, known) -> None:
    """Wherever the feet are said to be: the bake is that of far away feet in which nobody believes."""
    vague = replace(known, hips=None, standing=None)
    shape = known.feet.spread.shape
    bakes = [
        baked(user, database, replace(vague, feet=Part(known.feet.mean + shift, np.full(shape, 1e4))))
        for shift in (0.0, 0.7)
    ]
    np.testing.assert_array_equal(bakes[0].playback.frame, bakes[1].playback.frame)


def test_as_in_the_paper_nothing_of_it_counts(user, database, known) -> None:
    blind, seeing = (baked(user, database, e, **PAPER) for e in (BodyEstimate(known.yaws), known))
    for name in ("rotations", "locations"):
        np.testing.assert_array_equal(getattr(seeing.tracks, name), getattr(blind.tracks, name))
    zero = baked(user, database, replace(known, hips=None, chest=None, elbows=None), step_weight=0.0)
    plain = baked(user, database, BodyEstimate(known.yaws))
    np.testing.assert_array_equal(zero.tracks.rotations, plain.tracks.rotations)


def test_contacts_are_the_users_where_the_estimate_is_sure() -> None:
    played = np.array([[True, False]] * 3)
    standing = np.array([[0.05, 0.9], [0.5, 0.5], [0.95, 0.01]])
    estimate = BodyEstimate(np.zeros(3), standing=standing)
    found = ev.surer_contacts(played, estimate, 1.0)
    assert found.tolist() == [[False, True], [True, False], [True, False]]
    assert ev.surer_contacts(played, estimate, 0.0) is played
    assert ev.surer_contacts(played, BodyEstimate(np.zeros(3)), 1.0) is played


def test_hips_of_the_estimate_draw_the_target_by_how_sure_they_are(user, database, known) -> None:
    rng = np.random.default_rng(1)
    usual = Posture(
        rng.normal(0.0, 0.1, (len(user), 2)), scalar_first(Rotation.random(len(user), random_state=4))
    )
    height = 1.6
    sure = replace(known, hips=Part(known.hips.mean, np.zeros(len(user))))
    drawn = with_estimate(usual, sure, height)
    rotate = Rotation.from_euler("z", known.yaws[:, None])
    hips = rotate.apply(known.hips.mean * [height, height, 0.0])[:, :2]
    # a little surer of an estimate without spread than of the databases' lean
    np.testing.assert_allclose(drawn.hips, usual.hips + (25 / 41) * (hips - usual.hips), atol=1e-9)
    vague = replace(known, hips=Part(known.hips.mean, np.full(len(user), 1e3)))
    np.testing.assert_allclose(with_estimate(usual, vague, height).hips, usual.hips, atol=1e-5)
    nothing = with_estimate(usual, BodyEstimate(known.yaws), height)
    assert nothing.hips is usual.hips
    assert nothing.chest is usual.chest


def test_chest_and_elbows_of_the_estimate_are_told_in_the_world() -> None:
    rng = np.random.default_rng(3)
    yaws, turns = rng.uniform(-3.0, 3.0, 50), Rotation.from_rotvec(rng.normal(0.0, 0.4, (50, 3)))
    own = Rotation.from_euler("z", yaws[:, None]) * Rotation.from_rotvec(rng.normal(0.0, 0.3, (50, 3)))
    away = rng.normal(0.0, 1.0, (50, 2, 3))
    sure = np.zeros(50)
    told = BodyEstimate(yaws, chest=Part(turns.as_rotvec(), sure), elbows=Part(away, sure))
    drawn = with_estimate(Posture(np.zeros((50, 2)), scalar_first(own)), told, 1.6).chest
    goal = Rotation.from_euler("z", yaws[:, None]) * turns
    mixed = own * Rotation.from_rotvec(0.4 * (own.inv() * goal).as_rotvec())
    apart = Rotation.from_quat(np.roll(drawn, -1, axis=-1)).inv() * mixed
    np.testing.assert_allclose(apart.magnitude(), 0.0, atol=1e-7)
    expected = [Rotation.from_euler("z", yaw).apply(row) for yaw, row in zip(yaws, away, strict=True)]
    expected = np.array(expected) / np.linalg.norm(away, axis=-1, keepdims=True)
    np.testing.assert_allclose(elbows_of(told), expected, atol=1e-9)
    assert elbows_of(BodyEstimate(yaws)) is None
