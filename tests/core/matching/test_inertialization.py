from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.motion import Motion
from footwork.core.database.motion_database import MotionDatabase
from footwork.core.jobs import run
from footwork.core.matching.inertialization import assemble
from footwork.core.matching.playback import Playback, match
from footwork.core.matching.trajectory import make_trajectory
from footwork.core.settings import BakeSettings
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

RATE = 2.0 * np.log(2.0) / 0.1


def rotation(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def scripted(databases: list[MotionDatabase], plays: list[tuple[int, int, int]]) -> Playback:
    """A playback of (database, first frame, count) runs that carries the root by the clips' own movement."""
    fps = databases[0].fps
    database = np.concatenate([np.full(count, d) for d, _, count in plays])
    frame = np.concatenate([np.arange(first, first + count) for _, first, count in plays])
    root, yaw = np.zeros((len(frame), 2)), np.zeros(len(frame))
    # as the player does, the step to a frame is the one of the frame that played before it
    for t in range(1, len(frame)):
        poses, before = databases[database[t - 1]].poses, frame[t - 1]
        c, s = np.cos(yaw[t - 1]), np.sin(yaw[t - 1])
        root[t] = root[t - 1] + np.array([[c, -s], [s, c]]) @ poses.root_velocities[before] / fps
        yaw[t] = yaw[t - 1] + poses.root_yaw_velocities[before] / fps
    starts = np.cumsum([count for _, _, count in plays])[:-1]
    still = np.zeros(len(frame), dtype=bool)
    return Playback(database, frame, root, yaw, starts, still, root, yaw, 0)


def joint_places(motion: Motion) -> np.ndarray:
    """World positions `(T, J, 3)` by scipy, not by the code under test."""
    places, turns = [motion.positions], [rotation(motion.rotations[:, 0])]
    for j in range(1, len(motion.skeleton)):
        parent = motion.skeleton.parents[j]
        places.append(places[parent] + turns[parent].apply(motion.skeleton.offsets[j]))
        turns.append(turns[parent] * rotation(motion.rotations[:, j]))
    return np.stack(places, axis=1)


def test_without_transitions_the_clip_is_placed_at_the_root(make_database):
    db = make_database(1)
    playback = scripted([db], [(0, 20, 100)])
    motion, contacts = assemble(playback, [db], BakeSettings())
    poses, frames = db.poses, np.arange(20, 120)
    # the clip in its own world, moved rigidly so that its first root is at the origin
    back = Rotation.from_rotvec([0, 0, -poses.root_yaws[20]])
    ground = np.column_stack([poses.root_positions[frames] - poses.root_positions[20], np.zeros(100)])
    turns = Rotation.from_rotvec(np.outer(poses.root_yaws[frames], [0, 0, 1]))
    places = back.apply(ground + turns.apply(poses.hips_positions[frames]))
    np.testing.assert_allclose(motion.positions, places, atol=1e-9)
    hips = back * turns * rotation(poses.rotations[frames, 0])
    assert (hips.inv() * rotation(motion.rotations[:, 0])).magnitude().max() < 1e-9
    for j in range(1, 5):
        own = rotation(poses.rotations[frames, j])
        assert (own.inv() * rotation(motion.rotations[:, j])).magnitude().max() < 1e-9
    np.testing.assert_array_equal(contacts, poses.contacts[frames])
    assert (np.sum(motion.rotations[1:] * motion.rotations[:-1], axis=-1) > 0).all()


def frozen(db: MotionDatabase, speed: float = 0.0) -> MotionDatabase:
    """Clips that stand still, each in its own first pose; the root glides at `speed` in the first clip."""
    poses, first = db.poses, np.concatenate([np.full(c.stop - c.start, c.start) for c in db.clips])
    glide = np.zeros((len(db), 2))
    glide[: db.clips[0].stop, 1] = speed
    return replace(
        db,
        poses=replace(
            poses,
            hips_positions=poses.hips_positions[first],
            rotations=poses.rotations[first],
            root_velocities=glide,
            root_yaw_velocities=np.zeros(len(db)),
            hips_velocities=np.zeros((len(db), 3)),
            angular_velocities=np.zeros_like(poses.angular_velocities),
        ),
    )


def test_offsets_decay_as_a_critically_damped_spring(make_database):
    speed = 1.5
    db = frozen(make_database(2), speed)
    motion, _ = assemble(scripted([db], [(0, 0, 10), (0, 300, 60)]), [db], BakeSettings())
    old, new = db.poses.hips_positions[0], db.poses.hips_positions[300]

    def fall(_: float, state: np.ndarray) -> list[float]:
        return [state[1], -2 * RATE * state[1] - RATE**2 * state[0]]

    times = np.arange(60) / 60.0
    for axis, rate in ((0, 0.0), (1, speed), (2, 0.0)):
        start = [old[axis] - new[axis], rate]
        spring = solve_ivp(fall, (0, 1), start, t_eval=times, rtol=1e-9, atol=1e-12).y[0]
        ground = speed * 10 / 60 if axis == 1 else 0.0
        np.testing.assert_allclose(motion.positions[10:, axis], new[axis] + ground + spring, atol=1e-8)
    for j in range(5):
        left = rotation(motion.rotations[10:, j]) * rotation(db.poses.rotations[300, j]).inv()
        jump = (rotation(db.poses.rotations[0, j]) * rotation(db.poses.rotations[300, j]).inv()).as_rotvec()
        shape = solve_ivp(fall, (0, 1), [1.0, 0.0], t_eval=times, rtol=1e-9, atol=1e-12).y[0]
        np.testing.assert_allclose(left.as_rotvec(), shape[:, None] * jump, atol=1e-8)


def test_halflife_is_what_it_says(make_database):
    db = frozen(make_database(3))
    options = replace(BakeSettings(), halflife=0.25)
    motion, _ = assemble(scripted([db], [(0, 0, 5), (0, 300, 100)]), [db], options)
    left = np.linalg.norm(motion.positions[5:] - db.poses.hips_positions[300], axis=-1)
    rate = 2 * np.log(2) / 0.25
    np.testing.assert_allclose(left[30] / left[0], np.exp(-rate * 0.5) * (1 + rate * 0.5), rtol=1e-6)


@pytest.mark.parametrize("gap", [3, 40])
def test_pose_and_velocity_go_on_through_transitions(make_database, gap):
    # a fine time step, so that differences of positions are velocities
    fps = 960.0
    dbs = [
        make_database(4, (3000, 2500), fps, height_range=(0.9, 2.0)),
        make_database(5, (3000,), fps, height_range=(0.0, 0.9)),
    ]
    plays = [(0, 100, 400), (0, 3500, gap * 16), (1, 700, gap * 16), (0, 1500, 500)]
    playback = scripted(dbs, plays)
    motion, _ = assemble(playback, dbs, BakeSettings())
    places = joint_places(motion)
    velocities = np.diff(places, axis=0) * fps
    change = np.linalg.norm(np.diff(velocities, axis=0), axis=-1)
    # what a jump of the pose would look like: without a blend the first pose of each run stands for itself
    for t in playback.transitions.tolist():
        assert change[t - 2 : t].max() < 0.1, "m/s from one frame of 1/960 s to the next"
    raw = replace(playback, transitions=np.zeros(0, dtype=np.intp))
    unblended = np.linalg.norm(np.diff(joint_places(assemble(raw, dbs, BakeSettings())[0]), axis=0), axis=-1)
    jumps = unblended[playback.transitions - 1].max(axis=-1)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=-1)[playback.transitions - 1].max(axis=-1)
    assert (jumps > 0.1).all()
    assert (steps < 0.01).all()


def test_blocks_and_chains_do_not_show(make_database):
    """Several blocks long, dense in transitions."""
    db = make_database(6)
    rng = np.random.default_rng(0)
    path = np.cumsum(rng.normal(0, 0.02, (2600, 2)), axis=0)
    options = BakeSettings()
    playback = run(match(make_trajectory(path, np.zeros(2600), 60.0, options), np.ones(2600), [db], options))
    motion, _ = assemble(playback, [db], options)
    assert len(playback.transitions) > 50
    np.testing.assert_allclose(np.linalg.norm(motion.rotations, axis=-1), 1.0, atol=1e-9)
    assert (np.sum(motion.rotations[1:] * motion.rotations[:-1], axis=-1) > 0).all()
    # the tail alone is the tail of the whole, once the offsets at its start have died away
    cut = 1500
    tail = Playback(
        *(getattr(playback, name)[cut:] for name in ("database", "frame", "root_positions", "root_yaws")),
        playback.transitions[playback.transitions > cut] - cut,
        *(getattr(playback, name)[cut:] for name in ("clamped", "target_positions", "target_yaws")),
        0,
    )
    later, _ = assemble(tail, [db], options)
    np.testing.assert_allclose(later.positions[200:], motion.positions[cut + 200 :], atol=1e-6)


def test_same_input_gives_the_same_bytes(make_database):
    db = make_database(7)
    playback = scripted([db], [(0, 0, 50), (0, 350, 60), (0, 100, 30)])
    first, second = (assemble(playback, [db], BakeSettings())[0] for _ in range(2))
    assert first.positions.tobytes() == second.positions.tobytes()
    assert first.rotations.tobytes() == second.rotations.tobytes()
