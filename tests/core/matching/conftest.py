"""Small motion databases with smooth random movement, made without the code that builds real ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest
from footwork.core.body.skeleton import Skeleton
from footwork.core.database.motion_database import (
    FEATURE_GROUPS,
    HORIZONS_S,
    Clip,
    FeatureDatabase,
    MotionDatabase,
    PoseDatabase,
)
from scipy.spatial.transform import Rotation

ROLES = ("hips", "spine1", "head", "thigh.L", "shin.L")
PARENTS = np.array([-1, 0, 1, 0, 3])
OFFSETS = np.array([[0, 0, 0.9], [0, 0, 0.3], [0, 0, 0.4], [-0.1, 0, -0.05], [0, 0, -0.4]], dtype=np.float64)

Maker = Callable[..., MotionDatabase]


def waves(rng: np.random.Generator, times: np.ndarray, count: int, size: float) -> np.ndarray:
    """`(T, count)` sums of a few sines up to 1.5 Hz."""
    out = np.zeros((len(times), count))
    for _ in range(3):
        rate, phase = rng.uniform(0.2, 1.5, count), rng.uniform(0, 2 * np.pi, count)
        out += rng.normal(0, size, count) * np.sin(2 * np.pi * rate * times[:, None] + phase)
    return out


def quaternions(vectors: np.ndarray) -> np.ndarray:
    """`[w, x, y, z]` of rotation vectors `(..., 3)`, by scipy."""
    xyzw = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_quat()
    return np.roll(xyzw, 1, axis=-1).reshape(*vectors.shape[:-1], 4)


def spin(rotations: np.ndarray, fps: float) -> np.ndarray:
    """Angular velocity `(T, J, 3)` in the parent's axes by central differences, by scipy."""
    turns = Rotation.from_quat(np.roll(rotations, -1, axis=-1).reshape(-1, 4))
    count, joints = rotations.shape[:2]
    index = np.arange(count * joints).reshape(count, joints)
    ahead, behind = index[np.r_[1:count, count - 1]].ravel(), index[np.r_[0, : count - 1]].ravel()
    steps = (turns[ahead] * turns[behind].inv()).as_rotvec().reshape(count, joints, 3)
    steps[1:-1] *= 0.5
    return steps * fps


def clip(rng: np.random.Generator, count: int, fps: float) -> tuple[PoseDatabase, np.ndarray, np.ndarray]:
    """Poses, raw features `(T, 27)` and whether the future is known, of one clip."""
    times = np.arange(count) / fps
    yaws = rng.uniform(-3, 3) + np.cumsum(waves(rng, times, 1, 0.8)[:, 0]) / fps
    speed = np.abs(1.0 + waves(rng, times, 1, 0.5)[:, 0])
    heading = yaws + waves(rng, times, 1, 0.2)[:, 0]
    root = np.cumsum(np.stack([-np.sin(heading), np.cos(heading)], -1) * speed[:, None], axis=0) / fps
    hips = np.array([0, 0, 0.9]) + waves(rng, times, 3, 0.02)
    rotations = quaternions(waves(rng, times, 15, 0.3).reshape(count, 5, 3))

    world = np.diff(root, axis=0, append=root[-1:] * 2 - root[-2:-1]) * fps
    c, s = np.cos(yaws), np.sin(yaws)
    velocities = np.stack([c * world[:, 0] + s * world[:, 1], c * world[:, 1] - s * world[:, 0]], -1)
    poses = PoseDatabase(
        root_positions=root,
        root_yaws=yaws,
        hips_positions=hips,
        rotations=rotations,
        root_velocities=velocities,
        root_yaw_velocities=np.diff(yaws, append=yaws[-1] * 2 - yaws[-2]) * fps,
        hips_velocities=np.gradient(hips, axis=0) * fps,
        angular_velocities=spin(rotations, fps),
        contacts=waves(rng, times, 2, 1.0) > 0,
    )
    features = np.concatenate([np.zeros((count, 12)), waves(rng, times, 15, 0.3)], axis=-1)
    for k, horizon in enumerate(HORIZONS_S):
        later = np.minimum(np.arange(count) + round(horizon * fps), count - 1)
        away, turn = root[later] - root, yaws[later] - yaws
        features[:, 2 * k] = c * away[:, 0] + s * away[:, 1]
        features[:, 2 * k + 1] = c * away[:, 1] - s * away[:, 0]
        features[:, 6 + 2 * k], features[:, 7 + 2 * k] = -np.sin(turn), np.cos(turn)
    return poses, features, np.arange(count) < count - round(HORIZONS_S[-1] * fps)


def database(
    seed: int = 0,
    lengths: Sequence[int] = (300, 200),
    fps: float = 60.0,
    height_range: tuple[float, float] = (0.0, 2.0),
    name: str = "synthetic",
) -> MotionDatabase:
    rng = np.random.default_rng(seed)
    clips = [clip(rng, length, fps) for length in lengths]
    stops = np.cumsum(lengths).tolist()
    values = np.concatenate([raw for _, raw, _ in clips])
    valid = np.concatenate([future for _, _, future in clips])
    known = values[valid] if valid.any() else values
    mean, deviation = known.mean(axis=0), np.empty(27)
    for columns in FEATURE_GROUPS.values():
        deviation[columns] = known[:, columns].std(axis=0).mean()
    fields = PoseDatabase.__slots__
    return MotionDatabase(
        name=name,
        skeleton=Skeleton(ROLES, PARENTS, OFFSETS, ROLES, np.zeros((5, 3))),
        fps=fps,
        clips=tuple(
            Clip(f"clip{i}", stop - length, stop, "", "", False)
            for i, (length, stop) in enumerate(zip(lengths, stops, strict=True))
        ),
        poses=PoseDatabase(*(np.concatenate([getattr(p, f) for p, _, _ in clips]) for f in fields)),
        features=FeatureDatabase(((values - mean) / deviation).astype(np.float32), mean, deviation, valid),
        head_height=1.6,
        height_range=height_range,
    )


@pytest.fixture(scope="session")
def make_database() -> Maker:
    return database
