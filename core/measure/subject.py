"""Who is measured, and by what: a body over time, the bake that it came from, and the true motion if known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..body.motion import Motion
from ..body.skeleton import Skeleton
from ..body.toes import place_toes, toe_places
from ..database.contacts import find_contacts
from ..database.motion_database import MotionDatabase
from ..errors import InputError
from ..matching.playback import Playback
from ..maths import quat
from ..recording.recording import TRACKER_ROLES, Recording
from ..recording.targets import joint_targets
from ..rig.ground import Ground, surface
from .measures import Array, Flags

LEG_M = 0.85
"""Thigh and shin of the body for which bounds on lengths and speeds are written; other bodies scale them."""
CONTACT_M_S = 0.15
"""A toe slower than this stands (paper, section 5.1)."""


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
    def size(self) -> float:
        """Its legs over those of a usual body."""
        return self.skeleton.leg_length() / LEG_M

    @property
    def root_positions(self) -> Array:
        """Virtual root `(T, 2)`."""
        return self.positions[:, 0, :2]

    @property
    def root_yaws(self) -> Array:
        """Heading `(T,)` of the virtual root, radians."""
        return quat.heading(self.rotations[:, 0])

    def points(self, joints: NDArray[np.intp], offsets: Array) -> Array:
        """World positions `(T, N, 3)` of points fixed to joints, metres."""
        return self.positions[:, joints] + quat.rotate(self.rotations[:, joints], offsets)


def body_of(motion: Motion) -> Body:
    """The body by our own forward kinematics."""
    return Body(motion.skeleton, motion.fps, *motion.forward())


@dataclass(frozen=True, slots=True, eq=False)
class Yardstick:
    """What the motion of one bake of `T` frames is measured by.

    All lengths are the avatar's: a user of another size is scaled to it before, with recording and truth.
    """

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


class Subject:
    """A body that is measured, with all that several metrics need; what is not asked for is not computed."""

    def __init__(
        self, body: Body, yardstick: Yardstick, contacts: Flags, ground: Ground | None, true: Subject | None
    ) -> None:
        self.body, self.yardstick = body, yardstick
        self.contacts = contacts
        """`(T, 2)` when its feet stand."""
        self.ground = ground
        self.true = true
        """The user's true motion to compare it with, if it is known, with contacts of its own."""

    @property
    def is_true(self) -> bool:
        """Whether this is the user's own motion."""
        return self.true is None and self.yardstick.truth is not None

    @property
    def user(self) -> Body | None:
        """The true body."""
        return None if self.true is None else self.true.body

    @property
    def playback(self) -> Playback:
        """What was matched."""
        return self.yardstick.playback

    @property
    def tracked(self) -> Flags:
        """`(T, 3)` whether head, left and right were tracked."""
        return self.yardstick.trackers.valid

    @cached_property
    def targets(self) -> Array:
        """Where the root was asked to be `(T, 2)`, metres of the avatar."""
        return self.playback.target_positions * self.yardstick.scale

    @cached_property
    def devices(self) -> tuple[Array, Array]:
        """Positions `(T, 3, 3)` and rotations `(T, 3, 4)` of the joints under the devices, by the devices."""
        return joint_targets(self.yardstick.trackers)

    @cached_property
    def under_devices(self) -> list[int]:
        """The body's joints for head, left and right hand."""
        return [self.body.skeleton.joint(role) for role in TRACKER_ROLES]

    @cached_property
    def toes(self) -> Array:
        """Positions `(T, 2, 3)` of the toes, metres."""
        return place_toes(self.body.skeleton, self.body.positions, self.body.rotations)

    @cached_property
    def toe_heights(self) -> Array:
        """Heights `(T, 2)` of the toes above where they are in T-pose, metres."""
        joints, offsets = toe_places(self.body.skeleton)
        rest = self.body.skeleton.tpose_positions()[joints] + offsets
        return self.heights(self.toes) - rest[:, 2]

    def heights(self, points: Array) -> Array:
        """Heights `(T, N)` of points over the floor, or over the plane of the ground under each."""
        if self.ground is None:
            return points[..., 2]
        heights, normals = surface(self.ground, points[..., :2])
        return (points[..., 2] - heights) * normals[..., 2]

    @cached_property
    def shared_roles(self) -> list[str]:
        """Roles that this body and the true one both have."""
        assert self.user is not None
        theirs = self.user.skeleton
        return [role for role in self.body.skeleton.roles if role and theirs.find(role) >= 0]

    @cached_property
    def shared_joints(self) -> tuple[list[int], list[int]]:
        """The joints with these roles, in this body and in the true one."""
        assert self.user is not None
        mine, theirs = self.body.skeleton, self.user.skeleton
        return [mine.joint(role) for role in self.shared_roles], [
            theirs.joint(role) for role in self.shared_roles
        ]

    @cached_property
    def away(self) -> Array:
        """From the true joints to this body's `(T, R, 3)`, metres, by shared role."""
        assert self.user is not None
        mine, theirs = self.shared_joints
        return self.body.positions[:, mine] - self.user.positions[:, theirs]


def subjects(yardstick: Yardstick, body: Body) -> tuple[Subject, Subject | None]:
    """The avatar as it is to be measured, and the true body likewise where it is known.

    Raises:
        InputError: the truth has another length or rate than the body.
    """
    truth = yardstick.truth
    if truth is None:
        return Subject(body, yardstick, yardstick.contacts, yardstick.ground, None), None
    if len(truth) != len(body) or abs(truth.fps - body.fps) > 1e-6:
        raise InputError(
            f"the true motion has {len(truth)} frames at {truth.fps:g} per second, "
            f"the avatar {len(body)} at {body.fps:g}; resample the one to the other"
        )
    user = body_of(truth)
    toes = place_toes(user.skeleton, user.positions, user.rotations)
    stands = find_contacts(toes, user.fps, CONTACT_M_S * user.size)
    true = Subject(user, yardstick, stands, None, None)
    return Subject(body, yardstick, yardstick.contacts, yardstick.ground, true), true
