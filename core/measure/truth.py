"""The whole body beside the true one, over the joint roles that both skeletons have."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..body import hierarchy
from ..body.skeleton import LEG, SIDES, Skeleton
from ..maths import quat
from . import measures
from .measures import CM, Array
from .metric import Metric
from .subject import Body, Subject

_LOWER_BODY = ("hips", *(f"{part}.{side}" for side in SIDES for part in LEG))


def _if_known(values: Callable[[Subject, Body], Array]) -> Callable[[Subject], Array | None]:
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


def _hips_height(subject: Subject, user: Body) -> Array:
    return np.abs(subject.away[:, subject.shared_roles.index("hips"), 2]) * CM


def _knees_deg(subject: Subject, user: Body) -> Array:
    return np.degrees(np.abs(knee_bends(subject.body) - knee_bends(user)))


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


METRICS = (
    Metric(
        "lower_body_mpjpe_cm",
        "lower body MPJPE",
        "cm",
        "Hips, legs and feet to the true ones in the world, not aligned",
        _if_known(_lower_distances),
        series=True,
        tables=("summary",),
    ),
    Metric(
        "upper_body_mpjpe_cm",
        "upper body MPJPE",
        "cm",
        "The other joints, likewise",
        _if_known(_upper_distances),
    ),
    Metric("mpjpe_cm", "MPJPE", "cm", "All joints, likewise", _if_known(_distances)),
    Metric(
        "mpjre_deg",
        "MPJRE",
        "°",
        "Components of local rotation vectors, absolute differences",
        _if_known(_components_deg),
    ),
    Metric("mpjae_deg", "MPJAE", "°", "Geodesic angle between local rotations", _if_known(_angles_deg)),
    Metric("mpjve_cm_s", "MPJVE", "cm/s", "Joint velocities to the true ones", _if_known(_velocities)),
    Metric(
        "hips_height_error_cm",
        "hips height error",
        "cm",
        "Height of the hips to the true one",
        _if_known(_hips_height),
    ),
    Metric(
        "knee_error_deg",
        "knee bend error",
        "°",
        "Angle between thigh and shin to the true one",
        _if_known(_knees_deg),
    ),
)
