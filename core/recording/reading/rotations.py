"""Rotations as files have them - quaternions, Euler angles, rotators, matrices, 6-D - as quaternions w x y z.

A way of writing rotations has a name of one to three parts: what the numbers are, the unit of angles, and "inverse"
where the file turns the world into the device. "wxyz", "xyzw-inverse", "YXZ-degrees", "rotator-degrees", "matrix".
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import cast

import numpy as np
from numpy.typing import NDArray

from ...maths import quat
from ..recording import Array

ORDERS = tuple("".join(order) for order in itertools.permutations("XYZ"))
"""Intrinsic orders of Euler angles; the angles stand as x, y, z."""
_DEGREES = {"degrees": np.pi / 180.0, "radians": 1.0}
_INVERSE = "-inverse"
_QUATERNIONS = ("wxyz", "xyzw", "zwxy")
"""What stands where a quaternion's w, x, y and z are looked for; the last is w x y z under the names x y z w."""


def _euler(order: str) -> Callable[[Array], Array]:
    columns = ["XYZ".index(letter) for letter in order]
    return lambda angles: quat.from_euler(angles[..., columns], order)


def _rotator(angles: Array) -> Array:
    """Unreal's pitch, yaw, roll: about Z, then -Y, then -X, X forward, Y right, Z up."""
    return quat.from_euler(angles[..., [1, 0, 2]] * (1.0, -1.0, -1.0), "ZYX")


def _aviation(angles: Array) -> Array:
    """Pitch, yaw, roll about Y, Z, X, as robots and aeroplanes count: X forward."""
    return quat.from_euler(angles[..., [1, 0, 2]], "ZYX")


def _pitch_about_x(angles: Array) -> Array:
    """Pitch, yaw, roll about X, Z, Y, with Z up and Y forward."""
    return quat.from_euler(angles[..., [1, 0, 2]], "ZXY")


_ANGLES: dict[str, Callable[[Array], Array]] = {
    **{order: _euler(order) for order in ORDERS},
    "rotator": _rotator,
    "aviation": _aviation,
    "pitchx": _pitch_about_x,
    "vector": quat.from_rotation_vector,
}


def _matrix(values: Array) -> Array:
    return values.reshape(*values.shape[:-1], 3, 3)


_OTHERS: dict[str, Callable[[Array], Array]] = {
    "wxyz": lambda q: q,
    "xyzw": lambda q: q[..., [3, 0, 1, 2]],
    "zwxy": lambda q: q[..., [1, 2, 3, 0]],
    "matrix": lambda m: quat.from_matrix(_matrix(m)),
    "sixd": quat.from_sixd,
    "sixdrows": lambda m: quat.conjugate(quat.from_sixd(m)),
    "sixdpairs": lambda m: quat.from_sixd(m[..., [0, 2, 4, 1, 3, 5]]),
}

KINDS: dict[str, tuple[str, ...]] = {
    "quaternion": ("wxyz", "xyzw", "zwxy", "wxyz-inverse", "xyzw-inverse"),
    "euler": tuple(
        f"{name}-{unit}" for unit in _DEGREES for name in ("YXZ", "XYZ", "ZYX", "ZXY", "XZY", "YZX", "vector")
    ),
    "rotator": tuple(
        f"{name}-{unit}"
        for unit in _DEGREES
        for name in ("rotator", "YXZ", "aviation", "pitchx", "ZYX", "XYZ")
    ),
    "matrix": ("matrix", "matrix-inverse"),
    "sixd": ("sixd", "sixdrows", "sixdpairs", "sixd-inverse"),
}
"""What numbers of each kind may mean, the usual first."""
WIDTHS = {"quaternion": 4, "euler": 3, "rotator": 3, "matrix": 9, "sixd": 6}


def kind_of(rotation: str) -> str:
    """The kind of numbers that a way of writing reads; ValueError where it is none."""
    for kind, names in KINDS.items():
        if rotation in names:
            return kind
    raise ValueError(rotation)


def to_quaternions(values: Array, rotation: str) -> Array:
    """Quaternions `(..., 4)` w x y z, of any length, of rotations as a file has them.

    Args:
        values: `(..., k)` as many numbers as the way of writing takes; NaN where the file has none.
        rotation: how they are written, one of `KINDS`.
    """
    name = rotation.removesuffix(_INVERSE)
    words = name.split("-")
    with np.errstate(invalid="ignore", divide="ignore"):
        if len(words) == 2:
            found = _ANGLES[words[0]](values * _DEGREES[words[1]])
        else:
            known: NDArray[np.bool_] = np.asarray(np.isfinite(values).all(axis=-1))
            safe = values if name in _QUATERNIONS else _filled(values, known)
            found = _OTHERS[name](safe)
            if name not in _QUATERNIONS:
                found = np.where(known[..., None], found, np.nan)
    return cast("Array", found * (1.0, -1.0, -1.0, -1.0)) if rotation.endswith(_INVERSE) else found


def _filled(values: Array, known: NDArray[np.bool_]) -> Array:
    """Zeros where numbers are missing, which every formula can take."""
    return np.where(known[..., None], values, 0.0)
