"""The whole body beside the true one, over the joint roles that both skeletons have."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.skeleton import LEG, SIDES, Skeleton
from ..body.trunk import spine
from ..maths import quat
from . import measures
from .frozen import frozen_body
from .legs import joints
from .limbs import swivel_errors
from .measures import CM, Array
from .metric import Metric
from .subject import Body, Subject

_LOWER_BODY = ("hips", *(f"{part}.{side}" for side in SIDES for part in LEG))
_BENT_M = 0.04
"""An elbow nearer than this to the line from shoulder to wrist swivels to no side."""


def _if_known(values: Callable[[Subject, Body], Array | None]) -> Callable[[Subject], Array | None]:
    """A metric's values where the true body is known."""
    return lambda subject: None if subject.user is None else values(subject, subject.user)


def _lower(subject: Subject) -> list[int]:
    return [i for i, role in enumerate(subject.shared_roles) if role in _LOWER_BODY]


def _distances(subject: Subject, user: Body) -> Array:
    return np.linalg.norm(subject.away, axis=-1) * CM


def _lower_distances(subject: Subject, user: Body) -> Array:
    return _distances(subject, user)[:, _lower(subject)]


def _upper_distances(subject: Subject, user: Body) -> Array:
    return np.delete(_distances(subject, user), _lower(subject), axis=1)


def _frozen_distances(subject: Subject, user: Body) -> Array:
    body = subject.body
    frozen = frozen_body(subject.yardstick.databases, body.skeleton, body.root_positions, body.root_yaws)
    mine, theirs = (np.array(side)[_lower(subject)] for side in subject.shared_joints)
    return measures.distances(frozen[:, mine], user.positions[:, theirs]) * CM


def _hips(subject: Subject, user: Body) -> Array:
    return measures.distances(subject.body.positions[:, 0], user.positions[:, 0]) * CM


def _hips_on_ground(subject: Subject, user: Body) -> Array:
    return measures.distances(subject.body.root_positions, user.root_positions) * CM


def _hips_above(subject: Subject, user: Body) -> Array:
    return (subject.body.positions[:, 0, 2] - user.positions[:, 0, 2]) * CM


def _yaw_deg(subject: Subject, user: Body) -> Array:
    return np.degrees(measures.yaw_errors(subject.body.root_yaws, user.root_yaws))


def _chest_deg(subject: Subject, user: Body) -> Array:
    mine, theirs = (body.rotations[:, spine(body.skeleton)[-1]] for body in (subject.body, user))
    return np.degrees(measures.rotation_errors(mine, theirs))


def _elbows(subject: Subject, user: Body) -> Array:
    mine, theirs = (joints(body, ("forearm",))[:, :, 0] for body in (subject.body, user))
    return measures.distances(mine, theirs) * CM


def _swivels_deg(subject: Subject, user: Body) -> Array:
    mine, theirs = (joints(body, ("upper_arm", "forearm", "hand")) for body in (subject.body, user))
    return np.degrees(swivel_errors(mine, theirs, _BENT_M * user.size))


def _clavicles_deg(subject: Subject, user: Body) -> Array | None:
    rows = [i for i, role in enumerate(subject.shared_roles) if role.startswith("clavicle")]
    return _angles_deg(subject, user)[:, rows] if rows else None


def _local_rotations(subject: Subject, user: Body) -> tuple[Array, Array]:
    """Rotations `(T, R, 4)` of both bodies relative to the next shared joint above."""
    mine, theirs = subject.shared_joints
    parents = _parents_among(subject.body.skeleton, subject.shared_roles)
    return (
        _relative(subject.body.rotations[:, mine], parents),
        _relative(user.rotations[:, theirs], parents),
    )


def _components_deg(subject: Subject, user: Body) -> Array:
    return np.degrees(measures.rotation_vector_errors(*_local_rotations(subject, user)))


def _angles_deg(subject: Subject, user: Body) -> Array:
    return np.degrees(measures.rotation_errors(*_local_rotations(subject, user)))


def _velocities(subject: Subject, user: Body) -> Array:
    return measures.speeds(subject.away, subject.body.fps) * CM


def _parents_among(skeleton: Skeleton, roles: Sequence[str]) -> NDArray[np.intp]:
    """For each role the index in `roles` of its nearest ancestor that has one of them; -1 for none."""
    among = [skeleton.joint(role) for role in roles]
    over = [hierarchy.nearest_above(skeleton.parents, joint, among) for joint in among]
    return np.array([among.index(joint) if joint >= 0 else -1 for joint in over], dtype=np.intp)


def _relative(rotations: Array, parents: NDArray[np.intp]) -> Array:
    """Rotations relative to those of the parents; a joint without one keeps its own."""
    above = rotations[:, parents]
    above[:, parents < 0] = quat.IDENTITY
    return quat.multiply(quat.conjugate(above), rotations)


def _metric(
    name: str,
    label: str,
    unit: str,
    says: str,
    values: Callable[[Subject, Body], Array | None],
    shown: bool = False,
    better: str = "lower",
    since: int = 0,
) -> Metric:
    """A distribution over time that needs the truth."""
    tables = ("summary",) if shown else ()
    return Metric(
        name, label, unit, says, _if_known(values), group="truth", better=better, series=shown, tables=tables,
        since=since,
    )  # fmt: skip


METRICS = (
    _metric(
        "lower_body_mpjpe_cm", "legs (lower body MPJPE)", "cm",
        "Hips, legs and feet to the true ones in the world, not aligned", _lower_distances, True,
    ),
    _metric(
        "frozen_pose_lower_body_mpjpe_cm", "legs of a frozen mean pose", "cm",
        "The same of the databases' mean pose at the avatar's own root and yaw: legs that are no better know nothing",
        _frozen_distances,
    ),
    _metric("hips_error_cm", "hips", "cm", "Hips joint to the true hips joint", _hips, True, since=4),
    _metric("body_yaw_error_deg", "yaw", "°", "Heading of the hips to that of the true hips", _yaw_deg, True),
    _metric("chest_error_deg", "chest", "°", "Angle of the chest's rotation to the true chest's", _chest_deg, True),
    _metric("elbow_error_cm", "elbows", "cm", "Elbows to the true elbows", _elbows, True),
    _metric(
        "hips_on_ground_error_cm", "hips on the ground", "cm", "Hips to the true hips, seen from above",
        _hips_on_ground,
    ),
    _metric(
        "hips_height_error_cm", "hips height error", "cm", "Height of the hips to the true one",
        lambda subject, user: np.abs(_hips_above(subject, user)),
    ),
    _metric(
        "hips_height_bias_cm", "hips height bias", "cm",
        "Height of the hips minus the true one: below 0 the hips are too low", _hips_above, True, better="zero",
    ),
    _metric(
        "elbow_swivel_error_deg", "elbow swivel", "°",
        "Elbow about the line from shoulder to wrist to the true side, where both arms are bent", _swivels_deg,
    ),
    _metric(
        "clavicle_error_deg", "clavicles", "°", "Rotation of the clavicles since the chest to the true one",
        _clavicles_deg,
    ),
    _metric("upper_body_mpjpe_cm", "upper body MPJPE", "cm", "The other joints, likewise", _upper_distances),
    _metric("mpjpe_cm", "MPJPE", "cm", "All joints, likewise", _distances),
    _metric(
        "mpjre_deg", "MPJRE", "°", "Components of local rotation vectors, absolute differences", _components_deg
    ),
    _metric("mpjae_deg", "MPJAE", "°", "Geodesic angle between local rotations", _angles_deg),
    _metric("mpjve_cm_s", "MPJVE", "cm/s", "Joint velocities to the true ones", _velocities),
)  # fmt: skip
