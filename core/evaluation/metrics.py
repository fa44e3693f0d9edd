"""The `metrics` of a bake's report, measured on the avatar's final motion, beside those of the true motion.

All lengths are the avatar's: a user of another size is scaled to it before, with recording and truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..database.contacts import find_contacts, toe_places, toe_positions
from ..database.motion_database import POSE, MotionDatabase
from ..database.virtual_root import virtual_root
from ..errors import InputError
from ..matching.playback import Playback
from ..maths import quat
from ..mocap.skeleton import LEG, SIDES, Motion, Skeleton
from ..recording.body import joint_targets
from ..recording.recording import TRACKER_ROLES, Recording
from . import measures
from .measures import Array, Flags, summary

Metrics = dict[str, Any]
"""JSON-ready. Distributions are {"mean", "std", "p95", "max"}; where the true motion is known and has
one, its own is in them as "floor"."""

_LOWER_BODY = ("hips", *(f"{part}.{side}" for side in SIDES for part in LEG))
_CM = 100.0


def bake_metrics(
    motion: Motion,
    contacts: Flags,
    trackers: Recording,
    playback: Playback,
    databases: Sequence[MotionDatabase],
    unreachable: Flags,
    *,
    scale: float = 1.0,
    truth: Motion | None = None,
) -> Metrics:
    """Everything that is measured on one bake of `T` frames.

    Args:
        motion: the avatar's final motion, metres.
        contacts: `(T, 2)` left, right foot held on the ground.
        trackers: the recording at the motion's rate and on the avatar's scale.
        playback: what was matched, in the databases' metres.
        databases: those that were played.
        unreachable: `(T, 2)` hand targets farther away than the arm is long.
        scale: the avatar's metres over the databases'.
        truth: the user's true motion at the motion's rate and on the avatar's scale.

    Raises:
        InputError: the truth has another length or rate than the motion.
    """
    if truth is not None and (len(truth) != len(motion) or abs(truth.fps - motion.fps) > 1e-6):
        raise InputError(
            f"the true motion has {len(truth)} frames at {truth.fps:g} per second, "
            f"the avatar {len(motion)} at {motion.fps:g}; resample the one to the other"
        )
    avatar = _body(motion)
    user = _body(truth) if truth is not None else None
    return {
        **_root_metrics(avatar, playback.target_positions * scale, playback.target_yaws, user),
        **_tracking_metrics(avatar, trackers, unreachable),
        **_foot_metrics(avatar, contacts, user),
        **_playback_metrics(playback, databases, motion.fps),
        **(_truth_metrics(avatar, playback.target_yaws, user) if user is not None else {}),
    }


@dataclass(frozen=True, slots=True, eq=False)
class _Body:
    """A motion with what is measured more than once."""

    motion: Motion
    positions: Array
    """`(T, J, 3)` in the world."""
    rotations: Array
    """`(T, J, 4)` in the world."""
    root_positions: Array
    """`(T, 2)`."""
    root_yaws: Array
    """`(T,)`."""


def _body(motion: Motion) -> _Body:
    return _Body(motion, *motion.forward(), *virtual_root(motion))


def _root_metrics(avatar: _Body, targets: Array, yaws: Array, user: _Body | None) -> Metrics:
    """The virtual root of the final motion against where and how the body was asked to be."""

    def errors(body: _Body) -> Metrics:
        return {
            "root_error_cm": summary(measures.distances(body.root_positions, targets) * _CM),
            "yaw_error_deg": summary(np.degrees(measures.yaw_errors(body.root_yaws, yaws))),
        }

    return _with_floors(errors(avatar), errors(user) if user is not None else {})


def _with_floors(metrics: Metrics, floors: Metrics) -> Metrics:
    """Each distribution with its floor inside, each plain number with its floor beside it."""
    out = dict(metrics)
    for key, floor in floors.items():
        if isinstance(floor, dict):
            out[key] = {**metrics[key], "floor": floor}
        else:
            out[f"{key}_floor"] = floor
    return out


def _tracking_metrics(avatar: _Body, trackers: Recording, unreachable: Flags) -> Metrics:
    """Head and hands against the joints under the devices, where those were tracked."""
    joints = [avatar.motion.skeleton.joint(role) for role in TRACKER_ROLES]
    positions, rotations = joint_targets(trackers)
    away = measures.distances(avatar.positions[:, joints], positions) * _CM
    turned = np.degrees(measures.rotation_errors(avatar.rotations[:, joints], rotations))
    head, hands = trackers.valid[:, 0], trackers.valid[:, 1:]
    return {
        "head_position_error_cm": summary(away[head, 0]),
        "head_rotation_error_deg": summary(turned[head, 0]),
        "hand_position_error_cm": summary(away[:, 1:][hands]),
        "hand_position_error_in_reach_cm": summary(away[:, 1:][hands & ~unreachable]),
        "hand_rotation_error_deg": summary(turned[:, 1:][hands]),
        "unreachable_fraction": measures.fraction(unreachable, hands),
    }


def _foot_metrics(avatar: _Body, contacts: Flags, user: _Body | None) -> Metrics:
    """Skating by its four definitions, floating, sinking, penetration, jitter.

    Floating and sinking are how far a toe in contact is above and below its place in T-pose, penetration how
    deep the lower of toe and toe tip is below the floor at any time.
    """
    if user is None:
        return _feet_of(avatar, contacts)
    true_contacts = find_contacts(toe_positions(user.motion), user.motion.fps)
    return _with_floors(_feet_of(avatar, contacts), _feet_of(user, true_contacts))


def _feet_of(body: _Body, contacts: Flags) -> Metrics:
    skeleton, fps = body.motion.skeleton, body.motion.fps
    joints, offsets = toe_places(skeleton)
    rest = skeleton.tpose_positions()[joints]
    toes = _points(body, joints, offsets)
    heights = toes[..., 2] - (rest + offsets)[:, 2]
    # a point below the floor in T-pose, inside the shoe's sole, is measured from there
    depths = [
        np.minimum((rest + tips)[:, 2], 0.0) - _points(body, joints, tips)[..., 2]
        for tips in (offsets, skeleton.tips[joints])
    ]
    return {
        "foot_skate_cm_s": summary(measures.contact_speeds(toes, contacts, fps) * _CM),
        "nsm_skate_cm_s": summary(measures.nsm_skate(toes, heights, fps) * _CM),
        "skating_ratio": measures.skating_ratio(toes, heights, fps),
        "slide_per_contact_cm": summary(measures.slides(toes, contacts) * _CM),
        "floating_cm": summary(np.maximum(heights, 0.0)[contacts] * _CM),
        "sinking_cm": summary(np.maximum(-heights, 0.0)[contacts] * _CM),
        "penetration_cm": summary(np.maximum(np.maximum(*depths), 0.0) * _CM),
        "jitter": measures.jitter(body.positions, fps),
    }


def _points(body: _Body, joints: NDArray[np.intp], offsets: Array) -> Array:
    """World positions `(T, N, 3)` of points fixed to joints."""
    return body.positions[:, joints] + quat.rotate(body.rotations[:, joints], offsets)


def _playback_metrics(playback: Playback, databases: Sequence[MotionDatabase], fps: float) -> Metrics:
    used = np.unique(np.stack([playback.database, playback.frame], axis=-1), axis=0)
    return {
        "transitions_per_s": measures.transitions_per_s(len(playback.transitions), len(playback), fps),
        "pose_jump": summary(pose_jumps(playback, databases)),
        "poses_used": len(used),
        "clamped_fraction": measures.fraction(playback.clamped),
    }


def pose_jumps(playback: Playback, databases: Sequence[MotionDatabase]) -> Array:
    """How far each transition's pose features are from those that would have followed: `(K,)`, normalised.

    Both are measured by the new frame's database, in which every group of features has the deviation 1.
    """
    out = np.empty(len(playback.transitions))
    for i, at in enumerate(playback.transitions.tolist()):
        new = databases[int(playback.database[at])].features
        old = databases[int(playback.database[at - 1])].features
        left = old.values[playback.frame[at - 1] + 1] * old.deviation + old.mean
        jump = new.values[playback.frame[at]] - (left - new.mean) / new.deviation
        out[i] = np.linalg.norm(jump[POSE])
    return out


def _truth_metrics(avatar: _Body, target_yaws: Array, user: _Body) -> Metrics:
    """Errors against the user's true body over the joint roles that both skeletons have."""
    ours, true = avatar.motion.skeleton, user.motion.skeleton
    roles = [role for role in ours.roles if role and true.find(role) >= 0]
    mine, theirs = [ours.joint(role) for role in roles], [true.joint(role) for role in roles]
    difference = avatar.positions[:, mine] - user.positions[:, theirs]
    away = np.linalg.norm(difference, axis=-1) * _CM
    lower = [i for i, role in enumerate(roles) if role in _LOWER_BODY]
    parents = _parents_among(ours, roles)
    local = [_relative(r, parents) for r in (avatar.rotations[:, mine], user.rotations[:, theirs])]
    return {
        "lower_body_mpjpe_cm": summary(away[:, lower]),
        "upper_body_mpjpe_cm": summary(np.delete(away, lower, axis=1)),
        "mpjpe_cm": summary(away),
        "mpjre_deg": summary(np.degrees(measures.rotation_vector_errors(*local))),
        "mpjae_deg": summary(np.degrees(measures.rotation_errors(*local))),
        "mpjve_cm_s": summary(measures.speeds(difference, avatar.motion.fps) * _CM),
        "hips_error_cm": summary(measures.distances(avatar.root_positions, user.root_positions) * _CM),
        "body_yaw_error_deg": summary(np.degrees(measures.yaw_errors(avatar.root_yaws, user.root_yaws))),
        "orientation_error_deg": summary(np.degrees(measures.yaw_errors(target_yaws, user.root_yaws))),
    }


def _parents_among(skeleton: Skeleton, roles: Sequence[str]) -> NDArray[np.intp]:
    """For each role the index in `roles` of its nearest ancestor that has one of them; -1 for none."""
    place = {skeleton.joint(role): i for i, role in enumerate(roles)}
    out = np.full(len(roles), -1, dtype=np.intp)
    for joint, i in place.items():
        ancestor = int(skeleton.parents[joint])
        while ancestor >= 0 and ancestor not in place:
            ancestor = int(skeleton.parents[ancestor])
        out[i] = place.get(ancestor, -1)
    return out


def _relative(rotations: Array, parents: NDArray[np.intp]) -> Array:
    """Rotations relative to those of the parents; a joint without one keeps its own."""
    above = rotations[:, parents]
    above[:, parents < 0] = quat.IDENTITY
    return quat.multiply(quat.conjugate(above), rotations)
