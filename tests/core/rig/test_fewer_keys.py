"""Fewer keys: what is left, interpolated by other code, stays within the limit; what is straight needs no keys."""

from __future__ import annotations

import numpy as np
import pytest
from footwork.core.maths import quat
from footwork.core.rig.fewer_keys import Chain, Track, fewer_keys

FRAMES = 400


def chain(bones: int = 4, loose: int = -1) -> Chain:
    """Bones of length 0.3 one above the other."""
    rest = np.tile(np.eye(4), (bones, 1, 1))
    rest[:, 2, 3] = 0.3 * np.arange(bones)
    tails = rest[:, :3, 3] + (0.0, 0.0, 0.3)
    return Chain(np.arange(bones) - 1, rest, tails, np.arange(bones) == loose)


def tracks(bones: int = 4, seed: int = 1) -> list[Track]:
    random = np.random.default_rng(seed)
    time = np.linspace(0.0, 6.0, FRAMES)[:, None]
    out = [Track(0, np.sin(time * random.uniform(0.5, 2.0, 3)), None)]
    for bone in range(bones):
        turns = quat.from_rotation_vector(np.sin(time * random.uniform(0.5, 3.0, 3) + bone))
        out.append(Track(bone, quat.continuous(turns), quat.normalize))
    return out


def ends(values: list[np.ndarray]) -> np.ndarray:
    """Heads and tails `(2, T, B, 3)` of the straight chain, with matrices, each frame for itself."""
    found = np.empty((2, FRAMES, 4, 3))
    for t in range(FRAMES):
        turn, at = np.eye(3), values[0][t]
        for bone in range(4):
            found[0, t, bone] = at
            turn = turn @ quat.to_matrix(values[1 + bone][t] / np.linalg.norm(values[1 + bone][t]))
            at = at + turn @ (0.0, 0.0, 0.3)
            found[1, t, bone] = at
    return found


@pytest.mark.parametrize("limit", [0.0005, 0.002, 0.02])
def test_every_end_of_every_bone_stays_within_the_limit(limit: float) -> None:
    full = tracks()
    fewer = fewer_keys(chain(), full, limit)
    frames = np.arange(FRAMES)
    between = []
    for n, track in enumerate(full):
        at = np.flatnonzero(fewer.kept[:, n])
        between.append(np.stack([np.interp(frames, at, column[at]) for column in track.values.T], axis=1))
    away = np.linalg.norm(ends(between) - ends([track.values for track in full]), axis=-1).max()
    assert away <= limit
    assert away == pytest.approx(fewer.worst, abs=1e-9)
    assert fewer.kept[[0, -1]].all()


def test_a_looser_limit_keeps_fewer_keys() -> None:
    counts = [fewer_keys(chain(), tracks(), limit).kept.sum() for limit in (1e-4, 1e-3, 1e-2)]
    assert counts[0] > 1.5 * counts[1] > 2.0 * counts[2]


def test_what_goes_in_a_straight_line_has_two_keys_and_a_corner_one_more() -> None:
    way = np.linspace(0.0, 1.0, FRAMES)[:, None] * (1.0, 2.0, 0.0)
    corner = way.copy()
    corner[250:] = way[250]
    still = Track(1, np.tile(quat.IDENTITY, (FRAMES, 1)), quat.normalize)
    fewer = fewer_keys(chain(), [Track(0, way, None), Track(2, corner, None), still], 1e-6)
    assert [np.flatnonzero(column).tolist() for column in fewer.kept.T] == [[0, 399], [0, 250, 399], [0, 399]]


def test_a_loose_bone_keeps_its_own_rotation() -> None:
    quarter = quat.from_axis("X", np.array([np.pi / 2]))
    rotations = np.tile(quat.IDENTITY, (1, 4, 1))
    rotations[:, 0] = quarter
    heads, tails = chain(loose=1).points(rotations, np.zeros((1, 4, 3)))
    np.testing.assert_allclose(heads[0, 1], (0.0, -0.3, 0.0), atol=1e-12)
    np.testing.assert_allclose(tails[0, 1] - heads[0, 1], (0.0, 0.0, 0.3), atol=1e-12)
