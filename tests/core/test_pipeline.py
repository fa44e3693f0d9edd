"""Whole bakes in which the user, the people of the databases and the rig are of three different sizes.

Truths are worked out from the user's own motion: what the avatar should reach is where the user's joints are, times the
rig's size over the user's.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest
from footwork.core.body.edit import cut
from footwork.core.body.motion import Motion
from footwork.core.body.retarget import retarget
from footwork.core.body.skeleton import SIDES, Skeleton
from footwork.core.body.standing import standing_head_height
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import FEATURE_GROUPS, MotionDatabase
from footwork.core.jobs import run
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.pipeline import BakeResult, bake, scale_motion, scale_skeleton
from footwork.core.recording.body_estimate import BodyEstimate
from footwork.core.recording.mounts import DEVICE_MOUNTS
from footwork.core.recording.recording import Recording
from footwork.core.recording.simulate import simulate_recording
from footwork.core.rig.fit import fit_rig, rig_from_skeleton
from footwork.core.rig.rig import BoneTracks, Rig
from footwork.core.settings import BakeSettings, DatabaseSettings
from scipy.spatial.transform import Rotation

FPS = 30.0
USER, PEOPLE, RIG = 1.52, 1.05, 2.9
"""Body heights in metres of the user, of the databases' people and of the rig."""
SETTINGS = BakeSettings()
PAPER = replace(SETTINGS, search="greedy", trajectory="causal", target="head", search_every=1.0 / FPS)


def take(script: str, height: float = 1.75) -> Take:
    motion = scale_motion(demo_motion(script, 3, FPS), height / 1.75)
    return Take(script, f"{script}.bvh", script.encode().hex().ljust(64, "0"), motion, {}, ())


def database(name: str, scripts: Sequence[str], low: float, high: float) -> MotionDatabase:
    settings = DatabaseSettings(fps=FPS, height_low=low, height_high=high)
    return run(build_database([take(script, PEOPLE) for script in scripts], settings, name=name))


@pytest.fixture(scope="module")
def walking() -> MotionDatabase:
    return database("walking", ("walk", "turn", "sidestep"), 0.8, 2.0)


@pytest.fixture(scope="module")
def crouching() -> MotionDatabase:
    return database("crouching", ("crouch",), 0.0, 0.8)


@pytest.fixture(scope="module")
def user(unequal) -> Motion:
    """Walks some metres from a place that is not the origin, looks elsewhere than it goes, and crouches."""
    motion = retarget(demo_motion("visit", 6, FPS), unequal(1.75))
    turn = quat.from_yaw(0.9)
    rotations = motion.rotations.copy()
    rotations[:, 0] = quat.multiply(turn, rotations[:, 0])
    positions = quat.rotate(turn, motion.positions) + np.array([1.7, -1.1, 0.0])
    moved = replace(motion, positions=positions, rotations=quat.continuous(rotations))
    return cut(scale_motion(moved, USER / 1.75), 0, 330)


@pytest.fixture(scope="module")
def rig_body(unequal) -> Skeleton:
    return unequal(RIG)


def head_height(skeleton: Skeleton) -> float:
    return float(skeleton.tpose_positions()[skeleton.joint("head"), 2])


def world(motion: Motion, role: str) -> np.ndarray:
    return motion.forward()[0][:, motion.skeleton.joint(role)]


def yaws_of(motion: Motion) -> np.ndarray:
    return np.unwrap(quat.heading(motion.rotations[:, 0]))


def record(user: Motion, eye_height: float | None = None, size: float = 1.0) -> Recording:
    """With devices that sit above, before and beside the joints, tilted; `size` is that of the devices' places."""
    mounts = replace(DEVICE_MOUNTS, offsets=size * (DEVICE_MOUNTS.offsets + np.array([0.01, 0.0, 0.02])))
    return simulate_recording(user, "user", mounts, eye_height)


def baked(
    user: Motion,
    databases: Sequence[MotionDatabase],
    body: Skeleton | None,
    settings: BakeSettings,
    *,
    recording: Recording | None = None,
    **options: object,
) -> BakeResult:
    """With body orientation as it truly is."""
    yaws = yaws_of(user)
    return run(
        bake(
            recording or record(user),
            databases,
            lambda _: BodyEstimate(yaws, None),
            None if body is None else rig_from_skeleton(body, "rig"),
            settings,
            **options,
        )
    )


@dataclass(frozen=True)
class Sizes:
    """What the bodies measure, by standing at ease: metres of their head joints."""

    user: float
    people: float
    rig: float

    @property
    def to_rig(self) -> float:
        return self.rig / self.user

    @property
    def from_people(self) -> float:
        """The rig's metres over the databases'."""
        return self.rig / self.people


@pytest.fixture(scope="module")
def sizes(user: Motion, walking: MotionDatabase, rig_body: Skeleton) -> Sizes:
    """A rig stands at ease as those people do who stand at all."""
    ease = walking.head_height / head_height(walking.skeleton)
    fitted = fit_rig(rig_from_skeleton(rig_body, "rig")).skeleton
    people = ease * head_height(walking.skeleton)
    return Sizes(standing_head_height(user), people, ease * head_height(fitted))


@pytest.fixture(scope="module")
def result(user, walking, crouching, rig_body) -> BakeResult:
    return baked(user, [walking, crouching], rig_body, SETTINGS, truth=user)


def distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.linalg.norm(a - b, axis=-1)


def test_scales_are_the_ratios_of_the_bodies_sizes() -> None:
    """All move alike here, so that nothing else can tell them apart."""
    people = database("walk", ["walk"], 0.0, 2.0)
    user = take("walk", USER).motion
    # the user's height at ease is that of the whole take
    whole = record(cut(user, 0, 120), record(user).eye_height)
    made = baked(
        cut(user, 0, 120), [people], scale_motion(user, RIG / USER).skeleton, SETTINGS, recording=whole
    )
    assert made.report["scale"]["user_to_rig"] == pytest.approx(RIG / USER, rel=1e-6)
    assert made.report["scale"]["user_to_database"] == pytest.approx(PEOPLE / USER, rel=1e-6)


def test_head_and_hands_are_at_the_trackers_in_the_rigs_metres(user, result, sizes) -> None:
    for role in ("head", *(f"hand.{side}" for side in SIDES)):
        assert distances(world(result.motion, role), sizes.to_rig * world(user, role)).max() < 1e-5
    assert np.ptp(world(user, "head")[:, :2], axis=0).max() > 1.0


def test_the_hips_are_under_the_head_as_the_users_are(user, result, sizes) -> None:
    away = distances(world(result.motion, "hips")[:, :2], sizes.to_rig * world(user, "hips")[:, :2])
    assert away.mean() < 0.06 and away.max() < 0.13
    targets = result.playback.target_positions * sizes.from_people
    assert distances(targets, sizes.to_rig * world(user, "hips")[:, :2]).mean() < 0.06


def test_the_hips_follow_the_user_where_the_match_strays(user, walking, crouching, rig_body, sizes) -> None:
    settings = replace(SETTINGS, search="greedy", alpha=2.0, adjustment=0.0, search_every=2.0)
    found = baked(user, [walking, crouching], rig_body, settings)
    true = sizes.to_rig * world(user, "hips")[:, :2]
    strays = distances(found.playback.root_positions * sizes.from_people, true).mean()
    away = distances(world(found.motion, "hips")[:, :2], true).mean()
    assert strays > 0.25 and away < 0.2 * strays


def test_with_the_papers_target_it_is_the_head_to_the_millimetre(
    user, walking, crouching, rig_body, sizes
) -> None:
    found = baked(user, [walking, crouching], rig_body, PAPER)
    targets = found.playback.target_positions * sizes.from_people
    assert distances(targets, sizes.to_rig * world(user, "head")[:, :2]).max() < 1e-6


@pytest.mark.parametrize("settings", [SETTINGS, PAPER], ids=["path", "paper"])
@pytest.mark.parametrize("alpha", [0.03, 0.07])
@pytest.mark.parametrize("size", [0.5, 1.0, 1.6])
def test_alpha_is_metres_of_the_rig_and_less_on_small_ones(
    user, walking, crouching, rig_body, sizes, settings, alpha: float, size: float
) -> None:
    body = scale_skeleton(rig_body, size)
    found = baked(user, [walking, crouching], body, replace(settings, alpha=alpha))
    playback = found.playback
    away = distances(playback.root_positions, playback.target_positions) * size * sizes.from_people
    most = alpha * min(size * sizes.rig / 1.54, 1.0)
    assert away.max() <= most + 1e-9
    assert playback.clamped.mean() > 0.02
    np.testing.assert_allclose(away[playback.clamped], most, atol=1e-9)
    most *= 100.0
    assert found.report["metrics"]["matched_root_error_cm"]["max"] == pytest.approx(most)
    assert found.report["settings"]["alpha"] == alpha


def test_figures_are_centimetres_of_the_rig(user, result, sizes) -> None:
    """Every figure that is a distance, worked out from the user's own motion."""
    figures, motion, playback = result.report["metrics"], result.motion, result.playback
    mine, true = motion.forward()[0], sizes.to_rig * user.forward()[0]
    roles = motion.skeleton.roles
    legs = [
        i for i, role in enumerate(roles) if role.split(".")[0] in ("hips", "thigh", "shin", "foot", "toe")
    ]
    order = [user.skeleton.joint(role) for role in roles]
    apart = distances(mine, true[:, order])
    targets = playback.target_positions * sizes.from_people
    head = roles.index("head")
    expected = {
        "root_error_cm": distances(mine[:, 0, :2], targets),
        "root_to_head_cm": distances(mine[:, 0, :2], true[:, order][:, head, :2]),
        "matched_root_error_cm": distances(playback.root_positions * sizes.from_people, targets),
        "hips_error_cm": distances(mine[:, 0], true[:, 0]),
        "hips_on_ground_error_cm": distances(mine[:, 0, :2], true[:, 0, :2]),
        "hips_height_error_cm": np.abs(mine[:, 0, 2] - true[:, 0, 2]),
        "lower_body_mpjpe_cm": apart[:, legs],
        "upper_body_mpjpe_cm": np.delete(apart, legs, axis=1),
        "mpjpe_cm": apart,
        "mpjve_cm_s": distances(np.diff(mine, axis=0), np.diff(true[:, order], axis=0)) * FPS,
    }
    for name, values in expected.items():
        assert figures[name]["mean"] == pytest.approx(100.0 * values.mean(), rel=1e-6), name
        assert figures[name]["max"] == pytest.approx(100.0 * values.max(), rel=1e-6), name
    floors = {
        "root_error_cm": distances(true[:, 0, :2], targets),
        "root_to_head_cm": distances(true[:, 0, :2], true[:, order][:, head, :2]),
    }
    for name, values in floors.items():
        assert figures[name]["floor"]["mean"] == pytest.approx(100.0 * values.mean(), rel=1e-6), name
    for name in ("head_position_error_cm", "hand_position_error_cm", "head_rotation_error_deg"):
        assert figures[name]["max"] < 1e-2
    # the target is the truth's own, so that what is wrong with the body is wrong with the yaw
    assert figures["orientation_error_deg"]["max"] < 1e-6
    assert figures["body_yaw_error_deg"]["mean"] == pytest.approx(figures["yaw_error_deg"]["mean"])


def assert_same_bake(a: BakeResult, b: BakeResult, atol: float) -> None:
    np.testing.assert_array_equal(a.playback.frame, b.playback.frame)
    np.testing.assert_array_equal(a.contacts, b.contacts)
    for x, y in (
        (a.motion.positions, b.motion.positions),
        (a.motion.rotations, b.motion.rotations),
        (a.tracks.locations, b.tracks.locations),
        (a.tracks.rotations, b.tracks.rotations),
    ):
        np.testing.assert_allclose(x, y, atol=atol)
    for name, figure in a.report["metrics"].items():
        other = b.report["metrics"][name]
        if isinstance(figure, dict):
            # the mean pose is that of databases in single precision
            nearly = 5e-3 if name.startswith("frozen") else 1e-4
            assert other["mean"] == pytest.approx(figure["mean"], abs=nearly), name
            if "floor" in figure:
                assert other["floor"]["mean"] == pytest.approx(figure["floor"]["mean"], abs=1e-4), name
        else:
            assert other == pytest.approx(figure, abs=1e-4), name


@pytest.mark.parametrize("settings", [SETTINGS, PAPER], ids=["path", "paper"])
def test_a_user_of_half_the_size_gives_the_same_bake(user, walking, crouching, rig_body, settings) -> None:
    """Half, so that not even the last bit is another."""
    settings = replace(settings, alpha=0.08)
    plain, small = record(user), scale_motion(user, 0.5)
    half = record(small, 0.5 * plain.eye_height, 0.5)
    databases = [walking, crouching]
    whole = baked(user, databases, rig_body, settings, recording=plain, truth=user)
    assert_same_bake(whole, baked(small, databases, rig_body, settings, recording=half, truth=small), 1e-9)


def larger(base: MotionDatabase, factor: float) -> MotionDatabase:
    """The database of people `factor` times as large who do the same in the same time."""
    scales = np.full(27, factor)
    scales[FEATURE_GROUPS["trajectory_directions"]] = 1.0
    poses, features = base.poses, base.features
    lengths = ("root_positions", "hips_positions", "root_velocities", "hips_velocities")
    return replace(
        base,
        skeleton=replace(
            base.skeleton, offsets=factor * base.skeleton.offsets, tips=factor * base.skeleton.tips
        ),
        poses=replace(poses, **{name: factor * getattr(poses, name) for name in lengths}),
        features=replace(features, mean=features.mean * scales, deviation=features.deviation * scales),
        head_height=factor * base.head_height,
    )


def test_people_of_twice_the_size_give_the_same_bake(user, walking, crouching, rig_body) -> None:
    """With the paper's search, which knows no metres but alpha's."""
    settings = replace(PAPER, alpha=0.08)
    plain = baked(user, [walking, crouching], rig_body, settings, truth=user)
    twice = [larger(walking, 2.0), larger(crouching, 2.0)]
    assert_same_bake(plain, baked(user, twice, rig_body, settings, truth=user), 1e-9)


def test_each_database_plays_while_the_user_is_as_low_as_its_range(
    user, walking, crouching, rig_body, result
) -> None:
    recording = record(user)
    ratio = recording.positions[:, 0, 2] / recording.eye_height
    assert 0.1 < (ratio < 0.78).mean() < 0.6
    other = baked(user, [crouching, walking], rig_body, SETTINGS)
    for found, low in ((result, 1), (other, 0)):
        assert (found.playback.database[ratio < 0.78] == low).all()
        assert (found.playback.database[ratio > 0.82] == 1 - low).all()
    # who only crouches does not say how tall people stand, be it the first or the last
    assert other.report["scale"] == result.report["scale"]
    assert crouching.head_height < 0.97 * walking.head_height
    assert [row["name"] for row in other.report["inputs"]][1:] == ["crouching", "walking"]


def test_a_recording_that_is_not_scaled_stays_where_it_is(user, walking, crouching, unequal) -> None:
    settings = replace(SETTINGS, scale_to_rig=False, alpha=0.05)
    found = baked(user, [walking, crouching], unequal(1.6), settings, truth=user)
    assert found.report["scale"]["user_to_rig"] == 1.0
    assert distances(world(found.motion, "head"), world(user, "head")).max() < 1e-5
    away = distances(found.playback.root_positions, found.playback.target_positions)
    away *= standing_head_height(user) / walking.head_height
    assert away.max() == pytest.approx(0.05, abs=1e-6)
    assert distances(world(found.motion, "hips")[:, :2], world(user, "hips")[:, :2]).mean() < 0.06
    hips = distances(world(found.motion, "hips")[:, :2], world(user, "hips")[:, :2])
    assert found.report["metrics"]["hips_on_ground_error_cm"]["mean"] == pytest.approx(
        100.0 * hips.mean(), rel=1e-6
    )


def test_on_a_plateau_all_is_higher_by_its_height(user, walking, crouching, rig_body, sizes) -> None:
    height = 0.37

    def plateau(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.full(len(points), height), np.tile([0.0, 0.0, 1.0], (len(points), 1))

    found = baked(user, [walking, crouching], rig_body, SETTINGS, ground=plateau)
    flat = baked(user, [walking, crouching], rig_body, SETTINGS)
    up = np.array([0.0, 0.0, height])
    for role in ("head", "hand.L", "hand.R"):
        assert distances(world(found.motion, role), sizes.to_rig * world(user, role) + up).max() < 1e-4
    for name in ("head_position_error_cm", "hand_position_error_cm", "penetration_cm", "floating_cm"):
        low, high = (made.report["metrics"][name]["mean"] for made in (flat, found))
        assert high == pytest.approx(low, abs=0.05), name


def in_units(rig: Rig, metres: float, yaw: float, place: tuple[float, float, float]) -> Rig:
    """The same rig in a file of other units, its object turned and moved."""
    rest, matrix = rig.rest.copy(), np.eye(4)
    rest[:, :3, 3] /= metres
    matrix[:3, :3] = metres * Rotation.from_euler("z", yaw).as_matrix()
    matrix[:3, 3] = place
    return replace(rig, rest=rest, tails=rig.tails / metres, world=matrix)


def shown(rig: Rig, tracks: BoneTracks) -> np.ndarray:
    """World heads `(T, B, 3)` of a rig's bones with these keys, by 4 x 4 matrices as Blender does it."""
    frames = len(tracks.rotations)
    poses: list[np.ndarray] = []
    for bone, parent in enumerate(rig.parents.tolist()):
        basis = np.tile(np.eye(4), (frames, 1, 1))
        if rig.bones[bone] in tracks.bones:
            column = tracks.bones.index(rig.bones[bone])
            turns = Rotation.from_quat(np.roll(tracks.rotations[:, column], -1, axis=-1))
            basis[:, :3, :3] = turns.as_matrix()
            if column == 0:
                basis[:, :3, 3] = tracks.locations
        hang = rig.rest[bone] if parent < 0 else np.linalg.inv(rig.rest[parent]) @ rig.rest[bone]
        poses.append((np.eye(4) if parent < 0 else poses[parent]) @ hang @ basis)
    return np.stack([(rig.world @ pose)[:, :3, 3] for pose in poses], axis=1)


def test_keys_of_a_rig_in_other_units_show_the_body_at_the_trackers(
    user, walking, crouching, rig_body, sizes
) -> None:
    rig = in_units(rig_from_skeleton(rig_body, "rig"), 0.0254, 0.7, (3.0, -2.0, 0.0))
    yaws = yaws_of(user)
    job = bake(
        record(user),
        [walking, crouching],
        lambda _: BodyEstimate(yaws, None),
        rig,
        SETTINGS,
        output_fps=24.0,
    )
    found = run(job)
    assert found.tracks.fps == 24.0 and len(found.tracks.rotations) == int((len(user) - 1) / FPS * 24.0) + 1
    heads = shown(rig, found.tracks)
    times, known = np.arange(len(heads)) / 24.0, np.arange(len(user)) / FPS
    for role in ("head", "hand.R"):
        track = sizes.to_rig * world(user, role)
        wanted = np.stack([np.interp(times, known, track[:, axis]) for axis in range(3)], axis=-1)
        # between frames rotations go on the shortest arc, points on chords
        assert distances(heads[:, rig.roles.index(role)], wanted).max() < 0.01
    playback = found.playback
    jumps = (np.diff(playback.database) != 0) | (np.diff(playback.frame) != 1)
    np.testing.assert_allclose(found.transition_times, (np.flatnonzero(jumps) + 1) / FPS)


def test_memory_for_each_frame_is_bounded(walking: MotionDatabase) -> None:
    """An hour at 60 frames a second stays below 1.5 GiB, with 0.25 GiB for all that does not grow."""
    visit = simulate_recording(demo_motion("visit", 5, FPS), "user")
    count = 8 * len(visit)
    frames = np.arange(count) % (2 * len(visit))
    frames = np.minimum(frames, 2 * len(visit) - 1 - frames)
    user = replace(
        visit,
        times=np.arange(count) / FPS,
        positions=visit.positions[frames],
        rotations=visit.rotations[frames],
        valid=visit.valid[frames],
    )
    tracemalloc.start()
    try:
        run(bake(user, [walking], lambda _: BodyEstimate(np.zeros(count), None), None, PAPER))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak / count < 1.25 * 2**30 / (3600 * 60)
