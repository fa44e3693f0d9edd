"""A foot that turns about its toe: against scipy's rotations and searches over all angles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body import heel
from scipy import ndimage
from scipy.spatial.transform import Rotation

TO_TOE = np.array([0.02, 0.14, -0.06])
"""From ankle to toe joint in T-pose, metres: a little outwards."""
REST = 0.025
LENGTH = 0.86
UP = np.array([0.0, 0.0, 1.0])


def wxyz(rotation: Rotation) -> np.ndarray:
    return np.roll(rotation.as_quat(), 1, axis=-1)


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def feet(count: int, seed: int = 0, roll: float = 0.3) -> Rotation:
    """Feet that look anywhere, heel a little up or down, rolled a little to the side."""
    rng = np.random.default_rng(seed)
    bounds = np.array([3.0, 0.5, roll])
    return Rotation.from_euler("ZXY", rng.uniform(-bounds, bounds, (count, 3)))


def upright(count: int, pitch: float | np.ndarray = 0.0) -> Rotation:
    """Feet that look anywhere, with the heel up by `pitch` radians."""
    yaw = np.random.default_rng(1).uniform(-3.0, 3.0, count)
    return Rotation.from_euler("ZX", np.stack([yaw, np.broadcast_to(-np.asarray(pitch), count)], axis=-1))


def ankles(pitch: heel.Pitch, angle: np.ndarray) -> np.ndarray:
    """Ankles `(..., T, 3)` seen from the toes at other angles `(..., T)`."""
    return (
        (pitch.radius * np.cos(angle))[..., None] * pitch.back
        + (pitch.radius * np.sin(angle))[..., None] * UP
        + pitch.aside[:, None] * pitch.right
    )


def test_the_pitch_of_a_foot_is_where_its_ankle_is() -> None:
    turns = feet(50)
    pitch = heel.pitch_of(wxyz(turns), TO_TOE)
    np.testing.assert_allclose(ankles(pitch, pitch.angle), -turns.apply(TO_TOE), atol=1e-12)
    for vectors in (pitch.back, pitch.right):
        np.testing.assert_allclose(np.linalg.norm(vectors, axis=-1), 1.0, atol=1e-12)
        np.testing.assert_array_equal(vectors[:, 2], np.zeros(50))
    side = turns.apply([1.0, 0.0, 0.0])
    assert (np.sum(side * pitch.right, axis=-1) > 0.0).all()
    np.testing.assert_allclose(np.cross(side * [1, 1, 0], pitch.right), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.cross(pitch.right, -pitch.back)[:, 2], 1.0, atol=1e-12)
    # a flat foot: 14 cm back, 6 cm up, 2 cm to the left
    flat = heel.pitch_of(wxyz(upright(5)), TO_TOE)
    np.testing.assert_allclose(flat.angle, np.arctan2(0.06, 0.14))
    np.testing.assert_allclose(flat.radius, np.hypot(0.06, 0.14))
    np.testing.assert_allclose(flat.aside, -0.02, atol=1e-15)


def test_a_pitch_cut_to_some_frames_is_theirs() -> None:
    turns = feet(20)
    span = np.array([3, 4, 5, 11])
    part = heel.pitch_of(wxyz(turns), TO_TOE).cut(span)
    alone = heel.pitch_of(wxyz(turns[span]), TO_TOE)
    for name in ("back", "right", "angle", "radius", "aside"):
        np.testing.assert_allclose(getattr(part, name), getattr(alone, name), atol=1e-15)


def above_feet(pitch: heel.Pitch, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Thigh joints `(T, 3)` and toes `(T, 3)`: thighs ahead of the toes or behind, high or low."""
    rng = np.random.default_rng(seed)
    count = len(pitch.angle)
    toes = rng.normal(size=(count, 3))
    along, up, side = (
        rng.uniform(-0.2, 0.8, count),
        rng.uniform(0.05, 0.9, count),
        rng.uniform(-0.2, 0.2, count),
    )
    return toes + along[:, None] * pitch.back + up[:, None] * UP + side[:, None] * pitch.right, toes


def test_distances_from_the_thigh() -> None:
    turns = feet(400, 2)
    pitch = heel.pitch_of(wxyz(turns), TO_TOE)
    hips, toes = above_feet(pitch, 3)
    now = np.linalg.norm(hips - (toes - turns.apply(TO_TOE)), axis=-1)
    np.testing.assert_allclose(pitch.distance(hips, toes), now, atol=1e-12)
    # the least distance over all pitches from the foot's own up to ten degrees more
    more = np.radians(np.linspace(0.0, 10.0, 1001))[:, None]
    tried = np.linalg.norm(hips - toes - ankles(pitch, pitch.angle + more), axis=-1)
    np.testing.assert_allclose(pitch.nearest(hips, toes), tried.min(axis=0), atol=1e-6)
    best = tried.argmin(axis=0)
    # as it is, somewhere in between, and as far as it goes: all three are among them
    assert (best == 0).any() and (best == 1000).any() and ((best > 5) & (best < 995)).sum() > 10
    # one place for all frames
    np.testing.assert_allclose(
        pitch.distance(hips, toes[0]),
        np.linalg.norm(hips - toes[0] + turns.apply(TO_TOE), axis=-1),
        atol=1e-12,
    )


def test_a_thigh_on_the_ankle_has_no_distance_to_it() -> None:
    pitch = heel.pitch_of(wxyz(feet(30, 4)), TO_TOE)
    np.testing.assert_allclose(pitch.nearest(ankles(pitch, pitch.angle + 0.1), np.zeros(3)), 0.0, atol=1e-7)


def test_the_angle_that_reaches_is_the_least_of_all() -> None:
    pitch = heel.pitch_of(wxyz(feet(300, 5)), TO_TOE)
    hips, toes = above_feet(pitch, 6)
    length = np.random.default_rng(7).uniform(0.1, 1.0, 300)
    found = pitch.reaching(hips, toes, length)
    at = np.linalg.norm(hips - toes - ankles(pitch, found), axis=-1)
    turns = np.linspace(-np.pi, np.pi, 2001)[:, None]
    tried = np.linalg.norm(hips - toes - ankles(pitch, found + turns), axis=-1)
    nearest, farthest = tried.min(axis=0), tried.max(axis=0)
    short, long = length < nearest - 1e-4, length > farthest + 1e-4
    between = (length > nearest + 1e-3) & (length < farthest - 1e-3)
    assert min(short.sum(), long.sum(), between.sum()) > 5
    np.testing.assert_allclose(at[short], nearest[short], atol=1e-9)
    np.testing.assert_allclose(at[long], farthest[long], atol=1e-9)
    np.testing.assert_allclose(at[between], length[between], atol=1e-9)
    # from there on the ankle comes nearer
    assert (np.linalg.norm(hips - toes - ankles(pitch, found + 1e-4), axis=-1) < at)[between].all()


def test_shares_of_a_leg() -> None:
    assert heel.longest(2.0) == pytest.approx(2.0 * 0.999)
    assert heel.relaxed(2.0) == pytest.approx(2.0 * 0.998)
    assert heel.heel_behind(TO_TOE) == pytest.approx(1.35 * 0.14)


HEEL = np.array([0.0, -1.35 * 0.14, -REST])
"""From the toe to the heel in T-pose, on the floor."""


def hips_over(
    turns: Rotation, toes: np.ndarray, distance: float | np.ndarray, ahead: float = 0.1
) -> np.ndarray:
    """Thigh joints at a distance from the ankles, upwards and a little ahead of them."""
    way = turns.apply([0.0, 1.0, 0.0]) * [1, 1, 0]
    way = ahead * way / np.linalg.norm(way, axis=-1, keepdims=True) + np.sqrt(1.0 - ahead**2) * UP
    return toes - turns.apply(TO_TOE) + way * np.reshape(distance, (-1, 1))


def raised(
    turns: Rotation, toes: np.ndarray, hips: np.ndarray, own: float = 0.5, fps: float = 60.0
) -> Rotation:
    count = len(toes)
    return scipy_of(heel.raise_heel(wxyz(turns), TO_TOE, REST, toes, hips, LENGTH, np.full(count, own), fps))


def lift_of(before: Rotation, after: Rotation) -> np.ndarray:
    """Radians by which heels were raised, about the level axis to the right of each foot."""
    turn = (after * before.inv()).as_rotvec()
    right = before.apply([1.0, 0.0, 0.0]) * [1, 1, 0]
    lift = -np.sum(turn * right, axis=-1) / np.linalg.norm(right, axis=-1)
    np.testing.assert_allclose(np.linalg.norm(turn, axis=-1), np.abs(lift), atol=1e-9)
    return lift


def test_a_foot_in_reach_with_its_heel_off_the_floor_stays_as_it_is() -> None:
    turns = upright(40, 0.15)
    toes = np.random.default_rng(8).normal(size=(40, 3)) * [1, 1, 0] + REST * UP
    result = raised(turns, toes, hips_over(turns, toes, 0.8))
    np.testing.assert_allclose(lift_of(turns, result), 0.0, atol=1e-12)


@pytest.mark.parametrize("height", [REST - 0.02, REST, REST + 0.04])
@pytest.mark.parametrize("pitch", [-0.6, -0.05, 0.05, 0.4])
def test_a_heel_is_never_below_the_floor(height: float, pitch: float) -> None:
    yaw = upright(1)
    turns = Rotation.concatenate([yaw * Rotation.from_euler("x", -pitch)] * 30)
    toes = np.tile([0.3, -0.4, height], (30, 1))
    result = raised(turns, toes, hips_over(turns, toes, 0.6))
    before, after = ((toes + turn.apply(HEEL))[:, 2] for turn in (turns, result))
    if before[0] < 0.0:
        np.testing.assert_allclose(after, 0.0, atol=1e-9)
    else:
        np.testing.assert_allclose(after, before, atol=1e-12)


def test_a_foot_high_in_the_air_stays_as_it_is() -> None:
    turns = upright(12, 0.1)
    toes = np.linspace(0.2, 1.4, 12)[:, None] * UP
    result = raised(turns, toes, hips_over(turns, toes, 0.7))
    np.testing.assert_allclose(lift_of(turns, result), 0.0, atol=1e-12)


def distance_after(distance: float, own: float) -> tuple[float, float]:
    """Metres from thigh to ankle once the heel of a steady foot was raised, and by how much it was, radians."""
    turns = Rotation.concatenate([upright(1, 0.3)] * 40)
    toes = np.tile([0.3, -0.4, REST], (40, 1))
    hips = hips_over(turns, toes, distance)
    result = raised(turns, toes, hips, own)
    after = np.linalg.norm(hips - (toes - result.apply(TO_TOE)), axis=-1)
    lift = lift_of(turns, result)
    np.testing.assert_allclose(after, after[0], atol=1e-9)
    return float(after[0]), float(lift[0])


@pytest.mark.parametrize("share", [0.9, 0.987, 0.99, 0.995, 1.0, 1.006, 1.01, 1.04])
def test_a_leg_grows_ever_less_and_no_longer_than_relaxed(share: float) -> None:
    after, lift = distance_after(share * LENGTH, own=0.9 * LENGTH)
    free, most = 0.988 * LENGTH, 0.998 * LENGTH
    past = np.clip(share * LENGTH - free, 0.0, 2.0 * (most - free))
    expected = min(share * LENGTH - past**2 / (4.0 * (most - free)), most)
    assert after == pytest.approx(expected, abs=1e-9)
    assert (lift > 1e-6) == (share > 0.988)


@pytest.mark.parametrize(("own", "most"), [(0.99, 0.998), (0.9985, 0.9985), (1.0, 0.999), (1.2, 0.999)])
def test_a_leg_as_straight_as_in_the_motion_is_left_so(own: float, most: float) -> None:
    """Up to its own length in the motion nothing changes; what is too straight for that is bent."""
    free = min(own, most) * LENGTH
    after, lift = distance_after(free - 1e-4, own * LENGTH)
    assert after == pytest.approx(free - 1e-4, abs=1e-9) and lift == pytest.approx(0.0, abs=1e-9)
    after, _ = distance_after(1.03 * LENGTH, own * LENGTH)
    assert after == pytest.approx(most * LENGTH, abs=1e-7)


def test_a_foot_stands_no_steeper_than_on_tip_toe() -> None:
    turns = Rotation.concatenate([upright(1, 0.2)] * 30)
    toes = np.tile([0.3, -0.4, REST], (30, 1))
    result = raised(turns, toes, hips_over(turns, toes, 1.5 * LENGTH, 0.5))
    angle = heel.pitch_of(wxyz(result), TO_TOE).angle
    np.testing.assert_allclose(angle, np.radians(95.0), atol=1e-9)
    # one that is steeper already stays
    steep = Rotation.concatenate([upright(1, 1.5)] * 30)
    stays = raised(steep, toes, hips_over(steep, toes, 1.5 * LENGTH, -0.3))
    np.testing.assert_allclose(lift_of(steep, stays), 0.0, atol=1e-9)


@pytest.mark.parametrize("fps", [30.0, 100.0])
def test_a_short_rise_begins_before_and_ends_after(fps: float) -> None:
    """The least smooth curve above it: the maximum over four standard deviations of 30 ms, smoothed by them."""
    turns = Rotation.concatenate([upright(1, 0.1)] * 90)
    toes = np.tile([0.3, -0.4, REST], (90, 1))
    distance = np.full(90, 0.8)
    distance[40:43] = 0.9
    hips = hips_over(turns, toes, distance)
    lift = lift_of(turns, raised(turns, toes, hips, 0.7, fps))
    steady = lift_of(turns[:1], raised(turns[41:42], toes[41:42], hips[41:42], 0.7, fps))[0]
    sigma = 0.03 * fps
    half = int(np.ceil(4.0 * sigma))
    needed = np.zeros(90)
    needed[40:43] = steady
    expected = ndimage.gaussian_filter1d(
        ndimage.maximum_filter1d(needed, 2 * half + 1, mode="nearest"), sigma, radius=half
    )
    np.testing.assert_allclose(lift, expected, atol=1e-9)


@pytest.mark.parametrize("sigma", [0.3, 1.0, 2.6])
def test_smooth_peaks_lie_on_or_above_what_is_given(sigma: float) -> None:
    values = np.maximum(np.random.default_rng(9).normal(-0.5, 1.0, 80), 0.0)
    found = heel.smooth_peaks(values, sigma)
    half = int(np.ceil(4.0 * sigma))
    widest = ndimage.maximum_filter1d(values, 2 * half + 1, mode="nearest")
    padded = np.pad(widest, half, mode="reflect", reflect_type="odd")
    expected = ndimage.gaussian_filter1d(padded, sigma, radius=half)[half:-half]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert (found >= values - 1e-12).all()
    np.testing.assert_array_equal(heel.smooth_peaks(np.zeros(7), sigma), np.zeros(7))


@pytest.mark.parametrize("tip", [(0.01, 0.06, -0.01), (0.0, 0.05, 0.02), (0.0, 0.04, -0.04)])
def test_the_end_of_a_toe_is_no_lower_than_in_t_pose(tip: tuple[float, float, float]) -> None:
    rng = np.random.default_rng(10)
    turns = Rotation.from_euler("ZXY", rng.uniform([-3, -0.7, -0.4], [3, 0.8, 0.4], (300, 3)))
    heights = rng.uniform(0.0, 0.15, 300)
    result = scipy_of(heel.raise_tip(wxyz(turns), np.array(tip), heights, REST))
    floor = max(REST + tip[2], 0.0)
    before, after = (heights + turn.apply(tip)[:, 2] for turn in (turns, result))
    fine = before >= floor
    assert 20 < fine.sum() < 280
    np.testing.assert_allclose((result * turns.inv()).magnitude()[fine], 0.0, atol=1e-7)
    np.testing.assert_allclose(after[~fine], floor, atol=1e-9)
    # up, not round the other way, about the level axis to the right
    assert (lift_of(turns, result)[~fine] < 0.0).all()
    assert (result * turns.inv()).magnitude().max() < np.pi / 2 + 0.4


def test_a_toe_too_deep_for_its_end_points_straight_up() -> None:
    turns = upright(6, np.linspace(-0.5, 0.9, 6))
    result = scipy_of(heel.raise_tip(wxyz(turns), np.array([0.0, 0.06, -0.01]), np.full(6, -0.2), REST))
    np.testing.assert_allclose(result.apply([0.0, 0.06, -0.01])[:, 2], np.hypot(0.06, 0.01), atol=1e-9)


def test_a_toe_without_an_end_stays_finite() -> None:
    turns = feet(5)
    assert np.isfinite(heel.raise_tip(wxyz(turns), np.zeros(3), np.full(5, 0.01), REST)).all()
    assert np.isfinite(heel.raise_heel(
        wxyz(turns), np.zeros(3), 0.0, np.zeros((5, 3)), np.ones((5, 3)), LENGTH, np.ones(5), 60.0
    )).all()  # fmt: skip


def test_a_pitch_of_another_kind_can_be_made() -> None:
    pitch = heel.pitch_of(wxyz(feet(4)), TO_TOE)
    hips = np.array([0.1, 0.2, 0.8])
    higher = replace(pitch, aside=pitch.aside + 0.05)
    moved = np.linalg.norm(hips - ankles(higher, pitch.angle), axis=-1)
    np.testing.assert_allclose(higher.distance(hips, np.zeros(3)), moved, atol=1e-12)
