"""Rows of all parts of a body: there and back, turned with the body, mirrored as a mirror does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import mirror
from footwork.core.evaluation.true_estimate import true_estimate
from footwork.core.mocap.demo import demo_motion
from footwork.core.recording.body_estimate import BodyEstimate, Part
from footwork.nn.parts import ALL, EVERYTHING, are_parts, outputs_of, read_rows, true_rows
from scipy.spatial.transform import Rotation

HEAD_HEIGHT = 1.57


@pytest.fixture(scope="module")
def body() -> BodyEstimate:
    return true_estimate(demo_motion("visit", 4), HEAD_HEIGHT)


def parts(estimate: BodyEstimate) -> dict[str, Part]:
    known = {name: getattr(estimate, name) for name in ("hips", "feet", "chest", "elbows")}
    return {name: part for name, part in known.items() if part is not None}


def test_rows_of_a_known_body_read_back_are_that_body(body: BodyEstimate) -> None:
    rows = true_rows(body)
    rows[:, EVERYTHING.values["standing"]] = 40.0 * rows[:, EVERYTHING.values["standing"]] - 20.0
    found = read_rows(EVERYTHING, rows, body.yaws, np.zeros(len(rows)))
    for name, part in parts(body).items():
        np.testing.assert_allclose(getattr(found, name).mean, part.mean, atol=1e-6)
        np.testing.assert_allclose(getattr(found, name).spread, 1.0)
        assert getattr(found, name).spread.shape == part.mean.shape[:-1]
    np.testing.assert_allclose(found.standing, body.standing, atol=1e-6)


def test_a_body_with_a_part_unknown_has_no_rows(body: BodyEstimate) -> None:
    with pytest.raises(ValueError, match="missing"):
        true_rows(replace(body, chest=None))


def test_rows_turn_as_the_body_does() -> None:
    rng = np.random.default_rng(3)
    rows, yaw = rng.normal(size=(7, EVERYTHING.size)), rng.uniform(-3.0, 3.0, 7)
    found, turn = EVERYTHING.turned(rows, yaw), Rotation.from_euler("z", yaw[:, None])
    for name in ("hips", "feet", "chest", "elbows"):
        place = EVERYTHING.values[name]
        for vector in range(place.start, place.stop, 3):
            np.testing.assert_allclose(
                found[:, vector : vector + 3], turn.apply(rows[:, vector : vector + 3]), atol=1e-12
            )
        np.testing.assert_array_equal(found[:, EVERYTHING.spreads[name]], rows[:, EVERYTHING.spreads[name]])
    ground = turn.apply(np.concatenate([rows[:, :2], np.zeros((7, 1))], axis=1))
    np.testing.assert_allclose(found[:, :2], ground[:, :2], atol=1e-12)
    standing = EVERYTHING.values["standing"]
    np.testing.assert_array_equal(found[:, standing], rows[:, standing])


def test_mirrored_rows_are_those_of_the_mirrored_motion() -> None:
    motion = demo_motion("visit", 4)
    image = true_rows(true_estimate(mirror(motion), HEAD_HEIGHT))
    rows = true_rows(true_estimate(motion, HEAD_HEIGHT))
    np.testing.assert_allclose(EVERYTHING.mirrored(rows), image, atol=1e-6)
    marked = np.arange(EVERYTHING.size, dtype=np.float64)[None]
    np.testing.assert_array_equal(EVERYTHING.mirrored(EVERYTHING.mirrored(marked)), marked)
    for name in ("feet", "elbows"):
        place = EVERYTHING.spreads[name]
        half = (place.stop - place.start) // 2
        np.testing.assert_array_equal(EVERYTHING.mirrored(marked)[0, place], np.roll(marked[0, place], half))


def test_what_a_predictor_does_not_know_is_left_out() -> None:
    some = outputs_of(("yaw", "feet"))
    found = read_rows(some, np.zeros((3, some.size)), np.zeros(3), np.zeros(3))
    assert found.feet is not None
    assert found.feet.mean.shape == (3, 2, 2, 3)
    assert (found.hips, found.standing, found.chest, found.elbows) == (None,) * 4


def test_numbers_that_run_away_stay_a_body() -> None:
    wild = np.random.default_rng(0).normal(size=(50, EVERYTHING.size)) * 1e6
    wild[0] = 0.0
    found = read_rows(EVERYTHING, wild, np.zeros(50), np.zeros(50))
    for part in parts(found).values():
        assert np.isfinite(part.mean).all()
        assert np.all((part.spread > 0.0) & (part.spread <= 10.0))
    assert found.standing is not None
    assert np.all((found.standing >= 0.0) & (found.standing <= 1.0))


def test_every_number_of_a_row_belongs_to_one_part() -> None:
    taken = np.zeros(EVERYTHING.size, dtype=np.intp)
    for name in ALL:
        taken[EVERYTHING.values[name]] += 1
        taken[EVERYTHING.spreads[name]] += 1
    np.testing.assert_array_equal(taken, 1)


@pytest.mark.parametrize(
    ("names", "fine"),
    [
        (ALL, True),
        (("yaw",), True),
        (("yaw", "elbows", "hips"), True),
        (("hips",), False),
        (("yaw", "hips", "hips"), False),
        (("yaw", "tail"), False),
        ((), False),
    ],
)
def test_lists_of_parts(names: tuple[str, ...], fine: bool) -> None:
    assert are_parts(names) is fine
