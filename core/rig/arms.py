"""Hands at the controllers: clavicle, elbow plane and forearm twist (paper, section 6.1).

Arms are posed anew in anatomical terms: in T-pose with palms down the elbow is a hinge about the vertical
whose elbow side looks back. The hinge gives the upper arm's and the forearm's own rotation, so that neither
is twisted by what the matched motion's arms did.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import two_bone
from ..body.motion import Motion
from ..body.pose import with_world_rotations, world_poses
from ..body.skeleton import SIDES
from ..body.trunk import spine
from ..maths import angles, filters, quat
from ..maths.easing import smoothstep
from ..maths.vectors import across, cross, dot, norm, plane, unit
from . import validity

Array = NDArray[np.floating[Any]]

_HELP_MOST = np.radians(30.0)
"""Greatest turn of a clavicle."""
_SLACK = 0.9e-3
"""Metres by which an arm stays short of straight: an elbow that locks snaps."""
_EASY = np.array([0.2, 0.75, -0.63])
"""From shoulder to wrist where an arm is at ease: outward, ahead and down."""
_ELBOW = np.array([0.4, -0.4, -0.85])
"""Where an elbow likes to be, seen from there: outward, back and down."""
_FROM_HAND, _FROM_MOTION = 0.3, 0.3
"""Say of the hand's own axis and of the matched motion's elbow, beside 1 for where an elbow likes to be."""
_OWN_SAY = 0.5
"""Say of all these together beside 1 for where the trackers tell the elbow to be."""
_AIM_S = 0.08
"""Standard deviation in seconds of the smoothing of the elbow's plane."""
_TWIST_SHARE = 0.6
"""Share of the hand's twist that the forearm takes."""
_BENT, _BENT_BACK = np.cos(np.radians(45.0)), np.cos(np.radians(80.0))
"""Cosines of half the angle between forearm and hand from which on, and at which, the forearm takes none of it."""
_BACK = np.array([0.0, -1.0, 0.0])


def reach_hands(
    motion: Motion, positions: Array, rotations: Array, valid: NDArray[np.bool_], elbows: Array | None = None
) -> tuple[Motion, NDArray[np.bool_]]:
    """`motion` with its hands at targets.

    Near full reach the clavicle follows. A target out of reach leaves the arm straight towards it. The arm
    of a lost controller goes over to the motion's within 0.2 s.

    Args:
        motion: metres.
        positions: `(T, 2, 3)` where the left and right hand joints, the wrists, shall be, metres.
        rotations: `(T, 2, 4)` their world rotations since T-pose.
        valid: `(T, 2)` whether the controller was tracked.
        elbows: `(T, 2, 3)` which way the elbows are from the hands, unit vectors; None where that is not known.

    Returns:
        The motion, and `(T, 2)` whether a tracked hand is out of reach.
    """
    unreachable = np.zeros((len(motion), 2), np.bool_)
    ends = [motion.skeleton.joint(f"hand.{side}") for side in SIDES]
    world = world_poses(motion, [*ends, spine(motion.skeleton)[-1]])
    for i in range(2):
        if valid[:, i].any():
            told = None if elbows is None else elbows[:, i]
            motion, missed = _reach(motion, world, i, positions[:, i], rotations[:, i], valid[:, i], told)
            unreachable[:, i] = missed & valid[:, i]
    return motion, unreachable


def _reach(
    motion: Motion,
    world: tuple[dict[int, Array], dict[int, Array]],
    side: int,
    target: Array,
    hand: Array,
    valid: NDArray[np.bool_],
    told: Array | None,
) -> tuple[Motion, NDArray[np.bool_]]:
    """One arm of `reach_hands`; `world` are the motion's joint positions and rotations."""
    skeleton = motion.skeleton
    places, turns = world
    joints = [skeleton.joint(f"{part}.{SIDES[side]}") for part in ("upper_arm", "forearm", "hand")]
    chest = spine(skeleton)[-1]
    target, hand = _through_gaps(places[chest], turns[chest], target, hand, valid)
    limb = np.stack([places[j] for j in joints], axis=1)
    upper, lower = limb[:, 1] - limb[:, 0], limb[:, 2] - limb[:, 1]
    lengths = norm(upper), norm(lower)
    longest = lengths[0] + lengths[1]

    wanted: dict[int, Array] = {}
    shoulder = limb[:, 0]
    clavicle = skeleton.find(f"clavicle.{SIDES[side]}")
    if clavicle in places:
        turn = _clavicle_help(places[clavicle], shoulder, target, longest - _SLACK)
        wanted[clavicle] = quat.multiply(turn, turns[clavicle])
        shoulder = places[clavicle] + quat.rotate(turn, shoulder - places[clavicle])

    way = target - shoulder
    distance = norm(way)
    aim = _elbow_aim(motion.fps, side, unit(way), turns[chest], hand, limb, told)
    held = np.minimum(1.0, (longest - _SLACK) / np.maximum(distance, 1e-9))[:, None]
    mid, end, _ = two_bone.triangle(*lengths, way * held, aim)
    # the elbow side of both bones by the arm's plane: the forearm points back along the line where the hand is near
    hinge = cross(way, aim)
    arm = _hinge(turns[joints[0]], upper, mid, hinge)
    forearm = _hinge(turns[joints[1]], lower, end - mid, hinge)
    wanted |= {joints[0]: arm, joints[1]: _twisted(forearm, end - mid, hand), joints[2]: hand}
    solved = with_world_rotations(motion, wanted)
    missed = (distance > longest) | (distance < np.abs(lengths[0] - lengths[1]) - 1e-3)
    return _blend(motion, solved, list(wanted), validity.weights(valid, motion.fps)), missed


def _through_gaps(
    origin: Array, frame: Array, target: Array, hand: Array, valid: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Targets carried through gaps as they move with the chest, at `origin` `(T, 3)`, turned by `frame`
    `(T, 4)`."""
    if valid.all():
        return target, hand
    back = quat.conjugate(frame)
    place = validity.carry(quat.rotate(back, target - origin), valid)
    turn = validity.carry_rotations(quat.multiply(back, hand), valid)
    return origin + quat.rotate(frame, place), quat.multiply(frame, turn)


def _clavicle_help(clavicle: Array, shoulder: Array, target: Array, length: Array) -> Array:
    """Turn of the clavicle `(T, 4)` that brings the shoulder nearer to a target at the end of the arm's
    reach.

    If the clavicle can give g metres, it gives x^2 / 4g for a target x metres past length - g: so the arm
    comes to its full length with no speed, just where the clavicle can give no more.
    """
    arm, way = shoulder - clavicle, target - clavicle
    a, b, distance = norm(arm), norm(way), norm(target - shoulder)
    angle = np.arccos(np.clip(dot(arm, way) / np.maximum(a * b, 1e-12), -1.0, 1.0))
    most = np.maximum(angle - _HELP_MOST, 0.0)
    gain = np.maximum(distance - np.sqrt(np.maximum(a**2 + b**2 - 2.0 * a * b * np.cos(most), 0.0)), 1e-9)
    past = np.clip(distance - (length - gain), 0.0, 2.0 * gain)
    wanted = distance - past**2 / (4.0 * gain)
    cosine = (a**2 + b**2 - wanted**2) / np.maximum(2.0 * a * b, 1e-12)
    turn = np.where(past > 0.0, angle - np.arccos(np.clip(cosine, -1.0, 1.0)), 0.0)
    return quat.from_rotation_vector(unit(cross(arm, way)) * turn[:, None])


def _elbow_aim(
    fps: float, side: int, line: Array, chest: Array, hand: Array, limb: Array, told: Array | None
) -> Array:
    """Where the elbow shall lie `(T, 3)`, seen from the line between shoulder and wrist, not of unit
    length."""
    sign = np.array([-1.0 if SIDES[side] == "L" else 1.0, 1.0, 1.0])
    # carried from there the shortest way, it is smooth but for arms that point where they cannot: back, up and inward
    local = quat.rotate(quat.conjugate(chest), line)
    carried = quat.rotate(quat.between(np.broadcast_to(_EASY * sign, local.shape), local), _ELBOW * sign)
    liked = unit(across(quat.rotate(chest, carried), line))
    along_hand = quat.rotate(hand, np.array([1.0, 0.0, 0.0]) * sign)
    bent = across(limb[:, 1] - limb[:, 0], unit(limb[:, 2] - limb[:, 0]))
    bent = bent / np.maximum(norm(bent)[:, None], 0.05)
    aim = liked - _FROM_HAND * along_hand + _FROM_MOTION * bent
    if told is not None:
        aim = _OWN_SAY * aim + told
    smooth = filters.gaussian(across(aim, line), _AIM_S * fps)
    return across(smooth, line)


def _hinge(rotation: Array, bone: Array, along: Array, hinge: Array) -> Array:
    """World rotation `(T, 4)` of an arm bone that runs along `along` in the arm's plane.

    Args:
        rotation: `(T, 4)` its world rotation in the motion.
        bone: `(T, 3)` where that has the bone's end, seen from its joint.
        along: `(T, 3)` where the end shall be.
        hinge: `(T, 3)` about which elbows bend: across `along`, not of unit length.
    """
    rest = plane(quat.rotate(quat.conjugate(rotation), bone), np.broadcast_to(_BACK, bone.shape))
    return quat.from_matrix(plane(along, cross(hinge, along)) @ np.swapaxes(rest, -1, -2))


def _twisted(forearm: Array, along: Array, hand: Array) -> Array:
    """The forearm's rotation `(T, 4)` with its share of the hand's twist about `along` `(T, 3)`."""
    axis = unit(along)
    turn = quat.multiply(hand, quat.conjugate(forearm))
    about, rest = dot(turn[:, 1:], axis), turn[:, 0]
    twist = angles.wrap(2.0 * angles.arctan2(about, rest))
    # at half a turn the side of the twist is open, and in a hand that is bent back the twist itself: the share fades
    # out lest the forearm flips
    t = np.clip((np.pi - np.abs(twist)) / np.radians(90.0), 0.0, 1.0)
    bent = np.clip((np.hypot(about, rest) - _BENT_BACK) / (_BENT - _BENT_BACK), 0.0, 1.0)
    share = _TWIST_SHARE * smoothstep(t) * smoothstep(bent)
    return quat.multiply(quat.from_rotation_vector(axis * (share * twist)[:, None]), forearm)


def _blend(motion: Motion, solved: Motion, joints: list[int], weight: Array) -> Motion:
    """`solved` where the weight `(T,)` is 1, `motion` where it is 0, local rotations of `joints` between."""
    if (weight < 1.0).any():
        for joint in joints:
            mixed = quat.slerp(motion.rotations[:, joint], solved.rotations[:, joint], weight)
            solved.rotations[:, joint] = quat.continuous(mixed)
    return solved
