"""The last look before keys are made: what is wrong is told with its place."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.errors import InputError
from footwork.core.mocap.demo import demo_skeleton
from footwork.core.rig.fit import rig_from_skeleton
from footwork.core.rig.gate import check_finite, check_rig, check_tracks
from footwork.core.rig.rig import BoneTracks, Rig


@pytest.fixture
def rig() -> Rig:
    return rig_from_skeleton(demo_skeleton(1.62), "puppet")


def tracks(rig: Rig, tumble) -> BoneTracks:
    locations = np.random.default_rng(3).normal(size=(90, 3))
    return BoneTracks(rig.bones, 30.0, locations, tumble(90, 30.0, len(rig.bones), seed=2))


def test_what_a_body_does_passes(rig: Rig, tumble) -> None:
    check_rig(rig)
    check_tracks(tracks(rig, tumble), rig)
    check_finite(np.random.default_rng(1).normal(size=(7, 3, 4)), "it")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e5])
def test_where_the_hips_would_be_nowhere(rig: Rig, tumble, value: float) -> None:
    made = tracks(rig, tumble)
    made.locations[60, 1] = value
    with pytest.raises(InputError, match=rf"puppet: the bone {rig.bones[0]} would get keys at 2.00 s"):
        check_tracks(made, rig)


def test_places_are_judged_in_metres(rig: Rig, tumble) -> None:
    made = tracks(rig, tumble)
    made.locations[:] *= 1e4
    with pytest.raises(InputError):
        check_tracks(made, rig)
    check_tracks(made, replace(rig, world=np.diag([0.01, 0.01, 0.01, 1.0])))


@pytest.mark.parametrize("value", [[0.0, 0, 0, 0], [2.0, 0, 0, 0], [np.nan, 0, 0, 1], [np.inf, 0, 0, 0]])
def test_what_is_no_rotation(rig: Rig, tumble, value: list[float]) -> None:
    made = tracks(rig, tumble)
    made.rotations[15, 4] = value
    with pytest.raises(InputError, match=rf"the bone {rig.bones[4]} would get keys at 0.50 s"):
        check_tracks(made, rig)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e9])
def test_an_armature_at_no_place(rig: Rig, value: float) -> None:
    world = rig.world.copy()
    world[1, 3] = value
    with pytest.raises(InputError, match="puppet: the object is at no place"):
        check_rig(replace(rig, world=world))
    rest = rig.rest.copy()
    rest[3, 0, 3] = np.nan
    with pytest.raises(InputError, match=f"puppet: the bone {rig.bones[3]} has no place"):
        check_rig(replace(rig, rest=rest))


def test_values_that_no_body_has_name_who_gave_them() -> None:
    values = np.random.default_rng(1).normal(size=(7, 3))
    values[5, 1] = np.nan
    with pytest.raises(InputError, match="the predictor gives values at frame 5"):
        check_finite(values, "the predictor")
