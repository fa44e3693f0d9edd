"""Databases cut down by rule."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from footwork.core import jobs
from footwork.core.database.build import build_database
from footwork.core.database.motion_database import FEATURE_GROUPS, MotionDatabase, PoseDatabase
from footwork.core.errors import InputError
from footwork.core.evaluation.subset import reduce_database, van_der_corput
from footwork.core.mocap.demo import demo_motion
from footwork.core.mocap.take import Take
from footwork.core.settings import DatabaseSettings


@pytest.fixture(scope="module")
def whole() -> MotionDatabase:
    takes = [
        Take(n, f"{n}.bvh", "", demo_motion(n, i), {}, ()) for i, n in enumerate(("walk", "turn", "sidestep"))
    ]
    return jobs.run(build_database(takes, DatabaseSettings(mirror=True), name="demo"))


def rows_of(whole: MotionDatabase, share: float) -> list[int]:
    """Which rows are kept, told by numbers put in the place of the yaws."""
    numbered = replace(whole, poses=replace(whole.poses, root_yaws=np.arange(len(whole))))
    return reduce_database(numbered, share).poses.root_yaws.tolist()


def test_the_order_mirrors_binary_digits() -> None:
    assert van_der_corput(8) == [0, 4, 2, 6, 1, 5, 3, 7]
    assert van_der_corput(5) == [0, 4, 2, 1, 3]
    assert [sorted(van_der_corput(n)) for n in range(1, 40)] == [list(range(n)) for n in range(1, 40)]


@pytest.mark.parametrize("share", [0.5, 0.25, 0.1])
def test_a_share_has_its_size_and_whole_clips(whole: MotionDatabase, share: float) -> None:
    part = reduce_database(whole, share)
    assert len(part) == round(share * len(whole))
    assert [clip.start for clip in part.clips] == [0, *[clip.stop for clip in part.clips[:-1]]]
    assert part.clips[-1].stop == len(part)
    for item in fields(PoseDatabase):
        assert len(getattr(part.poses, item.name)) == len(part)
    for clip in part.clips:
        # nothing is found within a second of a clip's end, and steps between rows are the motion's own
        assert not part.features.trajectory_valid[max(clip.start, clip.stop - 60) : clip.stop].any()
        assert part.features.trajectory_valid[clip.start : max(clip.start, clip.stop - 60)].all()
        places = part.poses.root_positions[clip.start : clip.stop]
        ways = np.linalg.norm(np.diff(places, axis=0), axis=-1) * part.fps
        speeds = np.linalg.norm(part.poses.root_velocities[clip.start : clip.stop - 1], axis=-1)
        np.testing.assert_allclose(ways, speeds, atol=1e-3)


def test_features_are_normalised_anew(whole: MotionDatabase) -> None:
    part = reduce_database(whole, 0.25)
    found = part.features.values[part.features.trajectory_valid].astype(np.float64)
    np.testing.assert_allclose(found.mean(axis=0), 0.0, atol=1e-4)
    for columns in FEATURE_GROUPS.values():
        assert found[:, columns].std(axis=0).mean() == pytest.approx(1.0, abs=1e-3)


def test_a_smaller_share_is_part_of_a_larger_one(whole: MotionDatabase) -> None:
    half, quarter, tenth = (set(rows_of(whole, share)) for share in (0.5, 0.25, 0.1))
    assert tenth < quarter < half
    assert rows_of(whole, 0.5) == sorted(half), "in their own order, each once"
    everywhere = reduce_database(whole, 0.5)
    assert {clip.name for clip in everywhere.clips} == {clip.name for clip in whole.clips}, (
        "spread over all takes"
    )


def test_all_of_it_is_itself_and_too_little_is_an_error(whole: MotionDatabase) -> None:
    assert reduce_database(whole, 1.0) is whole
    with pytest.raises(InputError, match="larger"):
        reduce_database(whole, 0.001)
