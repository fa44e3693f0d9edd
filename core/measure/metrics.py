"""What is measured on the avatar's final motion, beside the same of the true motion.

All lengths are the avatar's: a user of another size is scaled to it before, with recording and truth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.motion import Motion
from ..body.skeleton import LEG, SIDES, Skeleton
from ..body.toes import place_toes, toe_places
from ..database.contacts import find_contacts
from ..database.motion_database import POSE, MotionDatabase
from ..errors import InputError
from ..matching.playback import Playback
from ..maths import quat
from ..recording.recording import TRACKER_ROLES, Recording
from ..recording.targets import joint_targets
from ..rig.ground import Ground, surface
from . import measures
from .catalogue import METRICS
from .measures import Array, Flags, counted, summary

Metrics = dict[str, Any]
"""JSON-ready, see `catalogue.METRICS`. Where the true motion is known and has one, its own is in a
distribution as "floor", beside a number as "NAME_floor"."""

_LOWER_BODY = ("hips", *(f"{part}.{side}" for side in SIDES for part in LEG))
_CM = 100.0


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Where all joints of a body are over time, however that was found out."""

    skeleton: Skeleton
    fps: float
    positions: Array
    """`(T, J, 3)` in the world, metres."""
    rotations: Array
    """`(T, J, 4)` in the world, since T-pose."""

    def __len__(self) -> int:
        return len(self.positions)

    @property
    def root_positions(self) -> Array:
        """Virtual root `(T, 2)`."""
        return self.positions[:, 0, :2]

    @property
    def root_yaws(self) -> Array:
        """Heading `(T,)` of the virtual root, radians."""
        return quat.heading(self.rotations[:, 0])


def body_of(motion: Motion) -> Body:
    """The body by our own forward kinematics."""
    return Body(motion.skeleton, motion.fps, *motion.forward())


@dataclass(frozen=True, slots=True, eq=False)
class Values:
    """All single values that were measured, by metric: the first axis is time or, where named so, events.

    NaN does not count. A metric is the mean, or the distribution, of its values.
    """

    fps: float
    own: Mapping[str, Array]
    floor: Mapping[str, Array]
    """The same of the true motion, for the metrics that have one."""
    poses: NDArray[np.intp]
    """`(N, 2)` database and frame, each that was played once."""


@dataclass(frozen=True, slots=True, eq=False)
class Yardstick:
    """What the motion of one bake of `T` frames is measured by."""

    contacts: Flags
    """`(T, 2)` left, right foot on the ground in the matched motion: contacts of a foot lock would be still by
    construction."""
    trackers: Recording
    """The recording at the motion's rate and on the avatar's scale."""
    playback: Playback
    """What was matched, in the databases' metres."""
    databases: Sequence[MotionDatabase]
    unreachable: Flags
    """`(T, 2)` hand targets farther away than the arm is long."""
    scale: float = 1.0
    """The avatar's metres over the databases'."""
    truth: Motion | None = None
    """The user's true motion at the motion's rate and on the avatar's scale."""
    ground: Ground | None = None
    """What the avatar stands on; None for a floor at height 0, on which the true motion is in any case."""
    doubt: Array | None = None
    """`(T,)` radians that the predictor expects its yaws to be off by; None where it has no notion of that."""

    def measure(self, body: Body) -> Values:
        """Everything on one body.

        Raises:
            InputError: the truth has another length or rate than the body.
        """
        user = None if self.truth is None else self._user(self.truth, body)
        targets = self.playback.target_positions * self.scale
        head = joint_targets(self.trackers)[0][:, 0, :2]
        errors = [_root_values(b, targets, head, self) for b in (body, user) if b is not None]
        feet = [_foot_values(body, self.contacts, self.ground)]
        if user is not None:
            feet.append(_foot_values(user, _true_contacts(user)))
        return Values(
            body.fps,
            {
                **errors[0],
                **_tracking_values(body, self.trackers, self.unreachable),
                **feet[0],
                **_playback_values(self, targets, body.fps),
                **({} if self.doubt is None else {"orientation_doubt_deg": np.degrees(self.doubt)}),
                **(_truth_values(body, self.playback.target_yaws, user) if user is not None else {}),
            },
            {**errors[1], **feet[1]} if user is not None else {},
            np.unique(np.stack([self.playback.database, self.playback.frame], axis=-1), axis=0),
        )

    def _user(self, truth: Motion, body: Body) -> Body:
        if len(truth) != len(body) or abs(truth.fps - body.fps) > 1e-6:
            raise InputError(
                f"the true motion has {len(truth)} frames at {truth.fps:g} per second, "
                f"the avatar {len(body)} at {body.fps:g}; resample the one to the other"
            )
        return body_of(truth)


def summarise(values: Values) -> Metrics:
    """The metrics of a report."""
    out: Metrics = {}
    for name, metric in METRICS.items():
        if metric.kind == "count":
            out[name] = len(values.poses)
        elif name not in values.own:
            continue
        elif metric.kind == "number":
            out[name] = summary(values.own[name])["mean"]
            if name in values.floor:
                out[f"{name}_floor"] = summary(values.floor[name])["mean"]
        else:
            floor = {"floor": summary(values.floor[name])} if name in values.floor else {}
            out[name] = {**summary(values.own[name]), **floor}
    return out


def pool(parts: Sequence[Values]) -> Values:
    """All values of several bakes with the same databases together: a second of any counts the same."""

    def together(sides: Sequence[Mapping[str, Array]]) -> dict[str, Array]:
        names = [name for name in sides[0] if all(name in side for side in sides)]
        return {name: np.concatenate([side[name].ravel() for side in sides]) for name in names}

    return Values(
        parts[0].fps,
        together([part.own for part in parts]),
        together([part.floor for part in parts]),
        np.unique(np.concatenate([part.poses for part in parts]), axis=0),
    )


def _root_values(body: Body, targets: Array, head: Array, yardstick: Yardstick) -> dict[str, Array]:
    """The virtual root against where and how the body was asked to be, and against the head."""
    tracked = yardstick.trackers.valid[:, 0]
    return {
        "root_error_cm": measures.distances(body.root_positions, targets) * _CM,
        "root_to_head_cm": counted(measures.distances(body.root_positions, head) * _CM, tracked),
        "yaw_error_deg": np.degrees(measures.yaw_errors(body.root_yaws, yardstick.playback.target_yaws)),
    }


def _tracking_values(body: Body, trackers: Recording, unreachable: Flags) -> dict[str, Array]:
    """Head and hands against the joints under the devices, where those were tracked."""
    joints = [body.skeleton.joint(role) for role in TRACKER_ROLES]
    positions, rotations = joint_targets(trackers)
    away = counted(measures.distances(body.positions[:, joints], positions) * _CM, trackers.valid)
    turned = counted(
        np.degrees(measures.rotation_errors(body.rotations[:, joints], rotations)), trackers.valid
    )
    return {
        "head_position_error_cm": away[:, 0],
        "head_rotation_error_deg": turned[:, 0],
        "hand_position_error_cm": away[:, 1:],
        "hand_position_error_in_reach_cm": counted(away[:, 1:], ~unreachable),
        "hand_rotation_error_deg": turned[:, 1:],
        "unreachable_fraction": counted(unreachable.astype(np.float64), trackers.valid[:, 1:]),
    }


def _true_contacts(user: Body) -> Flags:
    return find_contacts(place_toes(user.skeleton, user.positions, user.rotations), user.fps)


def _foot_values(body: Body, contacts: Flags, ground: Ground | None = None) -> dict[str, Array]:
    """Skating by its four definitions, floating, sinking, penetration, jitter."""
    joints, offsets = toe_places(body.skeleton)
    rest = body.skeleton.tpose_positions()[joints]
    toes = _points(body, joints, offsets)
    heights = _heights(toes, ground) - (rest + offsets)[:, 2]
    # a point below the floor in T-pose, inside the shoe's sole, is measured from there
    depths = [
        np.minimum((rest + tips)[:, 2], 0.0) - _heights(_points(body, joints, tips), ground)
        for tips in (offsets, body.skeleton.tips[joints])
    ]
    return {
        "foot_skate_cm_s": measures.contact_speeds(toes, contacts, body.fps) * _CM,
        "nsm_skate_cm_s": measures.nsm_skate(toes, heights, body.fps) * _CM,
        "skating_ratio": measures.skating(toes, heights, body.fps).astype(np.float64),
        "slide_per_contact_cm": measures.slides(toes, contacts) * _CM,
        "floating_cm": counted(np.maximum(heights, 0.0) * _CM, contacts),
        "sinking_cm": counted(np.maximum(-heights, 0.0) * _CM, contacts),
        "penetration_cm": np.maximum(np.maximum(*depths), 0.0) * _CM,
        "jitter": measures.jitter(body.positions, body.fps),
    }


def _heights(points: Array, ground: Ground | None) -> Array:
    """Heights `(T, N)` of points over the floor, or over the plane of the ground under each."""
    if ground is None:
        return points[..., 2]
    heights, normals = surface(ground, points[..., :2])
    return (points[..., 2] - heights) * normals[..., 2]


def _points(body: Body, joints: NDArray[np.intp], offsets: Array) -> Array:
    """World positions `(T, N, 3)` of points fixed to joints."""
    return body.positions[:, joints] + quat.rotate(body.rotations[:, joints], offsets)


def _playback_values(yardstick: Yardstick, targets: Array, fps: float) -> dict[str, Array]:
    playback = yardstick.playback
    changes = np.zeros(max(len(playback) - 1, 1))
    changes[playback.transitions - 1] = fps
    matched = playback.root_positions * yardstick.scale
    return {
        "matched_root_error_cm": measures.distances(matched, targets) * _CM,
        "transitions_per_s": changes,
        "pose_jump": pose_jumps(playback, yardstick.databases),
        "clamped_fraction": playback.clamped.astype(np.float64),
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


def _truth_values(body: Body, target_yaws: Array, user: Body) -> dict[str, Array]:
    """Errors against the user's true body over the joint roles that both skeletons have."""
    ours, true = body.skeleton, user.skeleton
    roles = [role for role in ours.roles if role and true.find(role) >= 0]
    mine, theirs = [ours.joint(role) for role in roles], [true.joint(role) for role in roles]
    difference = body.positions[:, mine] - user.positions[:, theirs]
    away = np.linalg.norm(difference, axis=-1) * _CM
    lower = [i for i, role in enumerate(roles) if role in _LOWER_BODY]
    parents = _parents_among(ours, roles)
    local = [_relative(r, parents) for r in (body.rotations[:, mine], user.rotations[:, theirs])]
    return {
        "lower_body_mpjpe_cm": away[:, lower],
        "upper_body_mpjpe_cm": np.delete(away, lower, axis=1),
        "mpjpe_cm": away,
        "mpjre_deg": np.degrees(measures.rotation_vector_errors(*local)),
        "mpjae_deg": np.degrees(measures.rotation_errors(*local)),
        "mpjve_cm_s": measures.speeds(difference, body.fps) * _CM,
        "hips_error_cm": measures.distances(body.root_positions, user.root_positions) * _CM,
        "hips_height_error_cm": np.abs(difference[:, roles.index("hips"), 2]) * _CM,
        "knee_error_deg": np.degrees(np.abs(knee_bends(body) - knee_bends(user))),
        "body_yaw_error_deg": np.degrees(measures.yaw_errors(body.root_yaws, user.root_yaws)),
        "orientation_error_deg": np.degrees(measures.yaw_errors(target_yaws, user.root_yaws)),
    }


def knee_bends(body: Body) -> Array:
    """Angle `(T, 2)` in radians between thigh and shin of the left and the right leg, 0 when straight."""
    bends: list[Array] = []
    for side in SIDES:
        hip, knee, ankle = (
            body.positions[:, body.skeleton.joint(f"{part}.{side}")] for part in ("thigh", "shin", "foot")
        )
        thigh, shin = knee - hip, ankle - knee
        across = np.linalg.norm(np.cross(thigh, shin), axis=-1)
        bends.append(np.arctan2(across, np.sum(thigh * shin, axis=-1)))
    return np.stack(bends, axis=-1)


def _parents_among(skeleton: Skeleton, roles: Sequence[str]) -> NDArray[np.intp]:
    """For each role the index in `roles` of its nearest ancestor that has one of them; -1 for none."""
    joints = [skeleton.joint(role) for role in roles]
    over = [hierarchy.nearest_above(skeleton.parents, joint, joints) for joint in joints]
    return np.array([joints.index(joint) if joint >= 0 else -1 for joint in over], dtype=np.intp)


def _relative(rotations: Array, parents: NDArray[np.intp]) -> Array:
    """Rotations relative to those of the parents; a joint without one keeps its own."""
    above = rotations[:, parents]
    above[:, parents < 0] = quat.IDENTITY
    return quat.multiply(quat.conjugate(above), rotations)
