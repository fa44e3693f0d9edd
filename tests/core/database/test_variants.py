"""Crouched and tip-toe walks against what is known of bodies: standing feet, bones, balance, reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from footwork.core.body.edit import cut, mirror
from footwork.core.body.motion import Motion
from footwork.core.body.retarget import retarget
from footwork.core.body.skeleton import SIDES, Skeleton
from footwork.core.body.standing import standing_head_height
from footwork.core.body.toes import toe_positions
from footwork.core.database.contacts import find_contacts
from footwork.core.database.variants import at_body_height, step_share, usual_height_range
from footwork.core.errors import InputError
from footwork.core.maths import quat
from footwork.core.mocap.demo import demo_motion, demo_skeleton
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

SHARES = (0.6, 0.7, 0.85, 0.95, 1.02, 1.04)
CROUCHED = (0.6, 0.7, 0.85)
TALL = 1.6 - 0.015 * 0.95
"""The demo's head joint while it stands: its hips, 0.95 m in T-pose, are at 0.985 of that."""


@pytest.fixture(scope="module")
def walk() -> Motion:
    return cut(demo_motion("walk"), 0, 600)


def contacts_of(motion: Motion) -> np.ndarray:
    return find_contacts(toe_positions(motion), motion.fps)


def at(motion: Motion, share: float) -> Motion:
    return at_body_height(motion, contacts_of(motion), share, TALL)


def places(motion: Motion, *roles: str) -> np.ndarray:
    """World positions `(T, n, 3)` of the roles' joints, by scipy."""
    skeleton = motion.skeleton
    turns, points = [], []
    for j, parent in enumerate(skeleton.parents):
        local = Rotation.from_quat(np.roll(motion.rotations[:, j], -1, axis=-1))
        turns.append(local if parent < 0 else turns[parent] * local)
        points.append(
            motion.positions if parent < 0 else points[parent] + turns[parent].apply(skeleton.offsets[j])
        )
    return np.stack([points[skeleton.joint(role)] for role in roles], axis=1)


def world(motion: Motion, role: str) -> Rotation:
    return Rotation.from_quat(np.roll(motion.forward()[1][:, motion.skeleton.joint(role)], -1, axis=-1))


def both(part: str) -> tuple[str, str]:
    return f"{part}.L", f"{part}.R"


def stands(skeleton: Skeleton, frames: int = 30) -> Motion:
    """A body that stands still in T-pose."""
    rotations = np.tile(quat.IDENTITY, (frames, len(skeleton), 1))
    return Motion(skeleton, 60.0, np.tile(skeleton.offsets[0], (frames, 1)), rotations)


def test_at_its_own_height_a_motion_is_left_as_it_is(walk) -> None:
    assert at(walk, 1.0) is walk


@pytest.mark.parametrize("share", SHARES)
def test_the_head_comes_to_the_height(walk, share) -> None:
    before, after = (places(motion, "head")[:, 0, 2] for motion in (walk, at(walk, share)))
    assert after.mean() / before.mean() == pytest.approx(share, abs=0.01)


@pytest.mark.parametrize("share", SHARES)
def test_standing_toes_stand(walk, share) -> None:
    variant, contacts = at(walk, share), contacts_of(walk)
    before, after = (places(motion, *both("toe")) for motion in (walk, variant))
    np.testing.assert_allclose(after[..., 2], before[..., 2], atol=1e-6)
    for side in range(2):
        moved = (after - before)[:, side]
        edges = np.flatnonzero(np.diff(contacts[:, side], prepend=False, append=False)).reshape(-1, 2)
        assert len(edges) > 5
        for first, stop in edges:
            assert np.ptp(moved[first:stop], axis=0).max() < 1e-4
    assert (contacts_of(variant) | ~contacts).mean() > 0.995
    for role in both("toe"):
        assert (world(variant, role) * world(walk, role).inv()).magnitude().max() < 1e-6


@pytest.mark.parametrize("share", SHARES)
def test_nothing_sinks_into_the_floor(walk, share) -> None:
    variant = at(walk, share)
    assert variant.skeleton is walk.skeleton
    np.testing.assert_allclose(np.linalg.norm(variant.rotations, axis=-1), 1.0, atol=1e-9)
    for side in SIDES:
        tip = walk.skeleton.tips[walk.skeleton.joint(f"toe.{side}")]
        ends = (
            places(motion, f"toe.{side}")[:, 0] + world(motion, f"toe.{side}").apply(tip)
            for motion in (walk, variant)
        )
        lowest = [end[:, 2].min() for end in ends]
        assert lowest[1] >= lowest[0] - 1e-6
    assert places(variant, *both("shin"), *both("hand"))[..., 2].min() > 0.02


@pytest.mark.parametrize("share", CROUCHED)
def test_feet_that_stand_flat_keep_their_turns(walk, share) -> None:
    contacts, variant = contacts_of(walk), at(walk, share)
    for side, role in enumerate(both("foot")):
        turned = (world(variant, role) * world(walk, role).inv()).magnitude()
        flat = world(walk, role).apply([0.0, 0.0, 1.0])[:, 2] > np.cos(np.radians(5.0))
        assert (contacts[:, side] & flat).sum() > 100
        assert np.degrees(turned[contacts[:, side] & flat]).max() < 1.0


@pytest.mark.parametrize("share", CROUCHED)
def test_knees_go_forward_over_the_toes(walk, share) -> None:
    variant, contacts = at(walk, share), contacts_of(walk)
    for side, letter in enumerate(SIDES):
        hip, knee, ankle = np.moveaxis(
            places(variant, *(f"{part}.{letter}" for part in ("thigh", "shin", "foot"))), 1, 0
        )
        ahead = world(variant, f"foot.{letter}").apply([0.0, 1.0, 0.0])
        ahead[:, 2] = 0.0
        ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
        line = (ankle - hip) / np.linalg.norm(ankle - hip, axis=-1, keepdims=True)
        bend = knee - hip - np.sum((knee - hip) * line, axis=-1, keepdims=True) * line
        assert np.sum(bend * ahead, axis=-1).min() > 0.05
        aside = np.abs(np.sum(np.cross(bend, ahead) * line, axis=-1))[contacts[:, side]]
        assert aside.max() < 0.06


@pytest.mark.parametrize("share", (0.7, 0.85, 1.04))
def test_joints_turn_no_faster_than_walking_asks_for(walk, share) -> None:
    def fastest(motion: Motion) -> float:
        cosine = np.abs(np.sum(motion.rotations[1:] * motion.rotations[:-1], axis=-1))
        return float(2.0 * np.arccos(np.clip(cosine, -1.0, 1.0)).max() * motion.fps)

    assert fastest(at(walk, share)) < 1.5 * fastest(walk)


@pytest.mark.parametrize("share", SHARES)
def test_gaze_and_hands_keep_their_directions(walk, share) -> None:
    variant = at(walk, share)
    for role in ("head", *both("forearm"), *both("hand")):
        assert (world(variant, role) * world(walk, role).inv()).magnitude().max() < 1e-6


@pytest.mark.parametrize("share", SHARES)
def test_steps_are_shorter(walk, share) -> None:
    variant, steps = at(walk, share), step_share(walk.skeleton, share, TALL)
    assert steps < 1.0
    lengths = [
        np.linalg.norm(np.diff(motion.positions[:, :2], axis=0), axis=-1).sum() for motion in (walk, variant)
    ]
    assert lengths[1] / lengths[0] == pytest.approx(steps, abs=0.03)
    # the distance between places where one foot stands follows the body's way
    contacts = contacts_of(walk)[:, 0]
    middles = np.flatnonzero(np.diff(contacts, prepend=False, append=False)).reshape(-1, 2).mean(axis=1)
    holds = [places(motion, "toe.L")[middles[1:-1].astype(int), 0, :2] for motion in (walk, variant)]
    strides = [np.linalg.norm(np.diff(hold, axis=0), axis=-1).sum() for hold in holds]
    assert strides[1] / strides[0] == pytest.approx(steps, abs=0.04)


@pytest.mark.parametrize("share", (0.6, 0.7, 0.8, 0.95))
def test_a_crouching_body_is_balanced(share) -> None:
    """By Winter's segments; on level thighs a quarter of the 0.14 m from ankle to ball farther forward."""
    body = stands(demo_skeleton())
    variant = at_body_height(body, np.ones((30, 2), bool), share, 1.6)

    def centre(motion: Motion) -> np.ndarray:
        def ends(upper: str, lower: str) -> np.ndarray:
            return places(motion, *both(upper), *both(lower)).reshape(-1, 2, 2, 3)[0].mean(axis=1)

        shoulder, hip = ends("upper_arm", "thigh")
        hip, knee = ends("thigh", "shin")
        knee, ankle = ends("shin", "foot")
        trunk = hip + 0.626 * (shoulder - hip)
        return 0.678 * trunk + 0.2 * (hip + 0.433 * (knee - hip)) + 0.093 * (knee + 0.433 * (ankle - knee))

    shoulder, hip, knee, ankle = (
        places(variant, *both(part))[0].mean(axis=0) for part in ("upper_arm", "thigh", "shin", "foot")
    )
    forward = 0.25 * 0.14 * (knee - hip)[1] / 0.43
    assert centre(variant)[1] - centre(body)[1] == pytest.approx(forward, abs=0.002)
    trunk, shin = (np.degrees(np.arctan2(v[1], v[2])) for v in (shoulder - hip, knee - ankle))
    assert trunk == pytest.approx(shin, abs=4.0)
    assert hip[1] < ankle[1]


@pytest.mark.parametrize("share", (1.02, 1.04))
def test_heels_rise_on_tiptoe(share) -> None:
    body = stands(demo_skeleton())
    variant = at_body_height(body, np.ones((30, 2), bool), share, 1.6)
    before, after = (places(motion, *both("foot"))[0] for motion in (body, variant))
    np.testing.assert_allclose(after[:, 2] - before[:, 2], 1.6 * (share - 1.0), atol=0.002)
    # the legs go with the ankles, as straight as they were
    hips = (places(motion, *both("thigh"))[0] for motion in (body, variant))
    legs = [np.linalg.norm(hip - ankle, axis=-1) for hip, ankle in zip(hips, (before, after), strict=True)]
    np.testing.assert_allclose(legs[1], legs[0], rtol=0.005)


def test_feet_are_only_so_long(walk) -> None:
    # ankle 0.157 m from the toe, 27 degrees over the ground: 0.083 m more at 80 degrees
    with pytest.raises(InputError, match=r"body height 1\.06: .* comes to 1\.053 .* give 1\.05 or less"):
        at(walk, 1.06)
    at(walk, 1.05)


def test_who_is_low_already_comes_down_less() -> None:
    crouch = demo_motion("crouch")
    before, after = (places(motion, "head")[:, 0, 2] / TALL for motion in (crouch, at(crouch, 0.7)))
    assert before.mean() < 0.8
    assert 0.4 < after.min() < after.mean() < before.mean()
    assert (before - after).max() < 0.3 * 0.75


def test_who_lies_stays() -> None:
    lying = stands(demo_skeleton())
    lying.rotations[:, 0] = quat.from_axis("X", np.pi / 2)
    lying = replace(lying, positions=np.tile([0.0, 0.0, 0.2], (30, 1)))
    np.testing.assert_allclose(
        places(at(lying, 0.7), "head", "hips"), places(lying, "head", "hips"), atol=1e-6
    )


@pytest.mark.parametrize("share", (0.7, 1.04))
def test_the_mirror_image_of_a_variant_is_the_variant_of_the_mirror_image(walk, share) -> None:
    contacts = contacts_of(walk)
    a = mirror(at_body_height(walk, contacts, share, TALL))
    b = at_body_height(mirror(walk), contacts[:, ::-1], share, TALL)
    np.testing.assert_allclose(a.positions, b.positions, atol=1e-9)
    np.testing.assert_allclose(np.abs(np.sum(a.rotations * b.rotations, axis=-1)), 1.0, atol=1e-9)


@settings(max_examples=15, deadline=None)
@given(
    st.floats(-np.pi, np.pi),
    st.floats(-20.0, 20.0),
    st.floats(-20.0, 20.0),
    st.sampled_from([0.65, 0.8, 1.03]),
)
def test_where_a_walk_starts_and_faces_does_not_matter(yaw, x, y, share) -> None:
    walk = cut(demo_motion("walk"), 100, 220)
    turn, way = Rotation.from_euler("z", yaw), np.array([x, y, 0.0])
    rotations = walk.rotations.copy()
    rotations[:, 0] = quat.multiply(np.array(np.roll(turn.as_quat(), 1)), rotations[:, 0])
    other = replace(walk, positions=turn.apply(walk.positions) + way, rotations=rotations)
    contacts = contacts_of(walk)
    a, b = (at_body_height(motion, contacts, share, TALL) for motion in (walk, other))
    roles = ("hips", "head", *both("shin"), *both("toe"), *both("hand"))
    wanted = turn.apply(places(a, *roles).reshape(-1, 3)).reshape(len(walk), -1, 3)
    wanted += step_share(walk.skeleton, share, TALL) * way
    np.testing.assert_allclose(places(b, *roles), wanted, atol=1e-7)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.6, 1.04), st.integers(0, 400), st.integers(1, 90), st.integers(0, 2**32 - 1))
def test_any_height_and_any_contacts_give_a_body(share, start, frames, seed) -> None:
    walk = cut(demo_motion("visit"), start, start + frames)
    contacts = np.random.default_rng(seed).random((len(walk), 2)) < 0.5
    variant = at_body_height(walk, contacts, share, TALL)
    assert np.isfinite(variant.positions).all()
    np.testing.assert_allclose(np.linalg.norm(variant.rotations, axis=-1), 1.0, atol=1e-9)
    moved = places(variant, *both("toe")) - places(walk, *both("toe"))
    assert np.abs(moved[..., 2]).max() < (1e-6 if share <= 1.0 else 0.02)
    for side in range(2):
        for first, stop in np.flatnonzero(np.diff(contacts[:, side], prepend=False, append=False)).reshape(
            -1, 2
        ):
            assert share > 1.0 or np.ptp(moved[first:stop, side], axis=0).max() < 1e-6


@pytest.mark.parametrize("parts", [("neck", "clavicle"), ("toe",), ("spine", "chest", "neck"), ("shin",)])
def test_joints_may_be_missing_or_without_a_role(parts) -> None:
    """Where a role is needed, its joint is split in two instead."""
    walk = cut(demo_motion("walk"), 0, 200)
    motion = retarget(walk, _split(walk.skeleton) if parts == ("shin",) else _without(walk.skeleton, parts))
    for share in (0.7, 1.03):
        variant = at_body_height(motion, contacts_of(motion), share, standing_head_height(motion))
        heads = [places(body, "head")[:, 0, 2].mean() for body in (motion, variant)]
        assert heads[1] / heads[0] == pytest.approx(share, abs=0.015)
        np.testing.assert_allclose(toe_positions(variant)[..., 2], toe_positions(motion)[..., 2], atol=0.003)


def _without(skeleton: Skeleton, parts: tuple[str, ...]) -> Skeleton:
    """The body without some joints, their children hung from what is above them."""
    keep = [j for j, role in enumerate(skeleton.roles) if not role.startswith(parts)]
    places, parents, offsets = skeleton.tpose_positions(), [], []
    for joint in keep:
        above = int(skeleton.parents[joint])
        while above not in keep and above >= 0:
            above = int(skeleton.parents[above])
        parents.append(keep.index(above) if above >= 0 else -1)
        offsets.append(places[joint] - (places[above] if above >= 0 else 0.0))
    names, roles = ([values[j] for j in keep] for values in (skeleton.names, skeleton.roles))
    return Skeleton(tuple(names), np.array(parents), np.array(offsets), tuple(roles), skeleton.tips[keep])


def _split(skeleton: Skeleton) -> Skeleton:
    """The body with a joint more, without a role, in the middle of each thigh."""
    for side in SIDES:
        shin = skeleton.joint(f"shin.{side}")
        half = 0.5 * skeleton.offsets[shin]
        offsets = np.insert(skeleton.offsets, shin, half, axis=0)
        offsets[shin + 1] = half
        parents = np.insert(skeleton.parents + (skeleton.parents >= shin), shin, skeleton.parents[shin])
        parents[shin + 1] = shin
        names, roles = ([*values[:shin], added, *values[shin:]] for values, added in
                        ((skeleton.names, f"Twist{side}"), (skeleton.roles, "")))  # fmt: skip
        skeleton = Skeleton(
            tuple(names), parents, offsets, tuple(roles), np.insert(skeleton.tips, shin, 0.0, axis=0)
        )
    return skeleton


def test_usual_height_ranges() -> None:
    assert usual_height_range(0.7) == (0.0, 0.85)
    assert usual_height_range(1.04) == (1.02, 2.0)
    assert usual_height_range(1.0) == (0.0, 2.0)
