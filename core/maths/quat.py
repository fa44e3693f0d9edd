"""Quaternions `[w, x, y, z]` over any leading axes: arrays in, arrays out.

All functions broadcast over the leading axes; the last axis holds the components. Results lie in memory with time
fastest (Fortran order), so that each component of each joint is one run of numbers, which numpy works through several
times as fast. Rotations are active:
`rotate(q, v)` turns the vector, `multiply(a, b)` applies `b` first. Formulas: Dam, Koch, Lillholm,
"Quaternions, Interpolation and Animation" (1998); the 6-D representation: Zhou et al. 2019.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import angles

Array = NDArray[np.floating[Any]]

IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
_AXES = {"X": 0, "Y": 1, "Z": 2}


def multiply(a: Array, b: Array) -> Array:
    """Hamilton product `(..., 4)`: the rotation that does `b`, then `a`."""
    aw, ax, ay, az = _components(a)
    bw, bx, by, bz = _components(b)
    out = np.empty(np.broadcast_shapes(a.shape, b.shape), dtype=np.result_type(a, b), order="F")
    w, x, y, z = _components(out)
    # written in place: most of the time would otherwise go into fresh memory
    part = np.empty_like(w)
    times = np.multiply
    times(aw, bw, out=w)
    w -= times(ax, bx, out=part)
    w -= times(ay, by, out=part)
    w -= times(az, bz, out=part)
    times(aw, bx, out=x)
    x += times(ax, bw, out=part)
    x += times(ay, bz, out=part)
    x -= times(az, by, out=part)
    times(aw, by, out=y)
    y -= times(ax, bz, out=part)
    y += times(ay, bw, out=part)
    y += times(az, bx, out=part)
    times(aw, bz, out=z)
    z += times(ax, by, out=part)
    z -= times(ay, bx, out=part)
    z += times(az, bw, out=part)
    return out


def conjugate(q: Array) -> Array:
    """The inverse of a unit quaternion `(..., 4)`."""
    return q * np.array([1.0, -1.0, -1.0, -1.0], dtype=q.dtype)


def normalize(q: Array) -> Array:
    """Unit quaternions `(..., 4)`; the zero quaternion becomes the identity."""
    length: Array = np.linalg.norm(q, axis=-1, keepdims=True)
    return np.where(length > 1e-12, q / np.maximum(length, 1e-12), IDENTITY)


def rotate(q: Array, v: Array) -> Array:
    """Vectors `(..., 3)` turned by unit quaternions `(..., 4)`."""
    w, x, y, z = _components(q)
    vx, vy, vz = _components(v)
    # the cross products in full: numpy's own take several times as long on few rows
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    shape = (*np.broadcast_shapes(q.shape[:-1], v.shape[:-1]), 3)
    out = np.empty(shape, dtype=np.result_type(q, v), order="F")
    out[..., 0] = vx + w * tx + (y * tz - z * ty)
    out[..., 1] = vy + w * ty + (z * tx - x * tz)
    out[..., 2] = vz + w * tz + (x * ty - y * tx)
    return out


def _components(vectors: Array) -> tuple[Array, ...]:
    return tuple([vectors[..., i] for i in range(vectors.shape[-1])])


def _joined(components: Sequence[Array]) -> Array:
    out = np.empty((*components[0].shape, len(components)), dtype=components[0].dtype, order="F")
    for i, component in enumerate(components):
        out[..., i] = component
    return out


def from_rotation_vector(vector: Array) -> Array:
    """Unit quaternions `(..., 4)` of rotation vectors `(..., 3)`: axis times angle in radians."""
    angle: Array = np.linalg.norm(vector, axis=-1, keepdims=True)
    half = 0.5 * angle
    # sin(a/2)/a by its limit near zero, where the quotient loses all digits
    factor = np.where(angle > 1e-8, np.sin(half) / np.maximum(angle, 1e-8), 0.5)
    return np.concatenate([np.cos(half), factor * vector], axis=-1)


def to_rotation_vector(q: Array) -> Array:
    """Rotation vectors `(..., 3)`, angle in [0, pi], of unit quaternions `(..., 4)`."""
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine: Array = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * angles.arctan2(sine, q[..., :1])
    return q[..., 1:] * np.where(sine > 1e-10, angle / np.maximum(sine, 1e-10), 2.0)


def from_axis(axis: str, angle: ArrayLike) -> Array:
    """Rotations about one world axis "X", "Y" or "Z" by `angle` radians `(...)`: `(..., 4)`."""
    half = 0.5 * np.asarray(angle, dtype=np.float64)
    out = np.zeros((*half.shape, 4), order="F")
    out[..., 0] = np.cos(half)
    out[..., 1 + _AXES[axis]] = np.sin(half)
    return out


def from_euler(angles: Array, order: str) -> Array:
    """Quaternions of intrinsic Euler angles.

    Args:
        angles: `(..., 3)` radians, in the order of `order`.
        order: three axis letters, e.g. "ZXY": the product Rz Rx Ry, as BVH channels are read.
    """
    q = from_axis(order[0], angles[..., 0])
    for i in (1, 2):
        q = multiply(q, from_axis(order[i], angles[..., i]))
    return q


def to_euler(q: Array, order: str) -> Array:
    """Intrinsic Euler angles `(..., 3)` in radians of unit quaternions, for the six Tait-Bryan orders.

    The inverse of `from_euler`. At gimbal lock (middle angle +-pi/2) the last angle is set to zero.
    """
    i, j, k = (_AXES[letter] for letter in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    m = to_matrix(q)
    middle = np.arcsin(np.clip(sign * m[..., i, k], -1.0, 1.0))
    free = np.abs(m[..., i, k]) < 1.0 - 1e-10
    first = np.where(
        free,
        angles.arctan2(-sign * m[..., j, k], m[..., k, k]),
        angles.arctan2(sign * m[..., k, j], m[..., j, j]),
    )
    last = np.where(free, angles.arctan2(-sign * m[..., i, j], m[..., i, i]), 0.0)
    return np.stack([first, middle, last], axis=-1)


def to_matrix(q: Array) -> Array:
    """Rotation matrices `(..., 3, 3)` of unit quaternions `(..., 4)`."""
    w, x, y, z = _components(q)
    out = np.empty((*q.shape[:-1], 3, 3), dtype=q.dtype, order="F")
    out[..., 0, 0] = 1 - 2 * (y * y + z * z)
    out[..., 0, 1] = 2 * (x * y - w * z)
    out[..., 0, 2] = 2 * (x * z + w * y)
    out[..., 1, 0] = 2 * (x * y + w * z)
    out[..., 1, 1] = 1 - 2 * (x * x + z * z)
    out[..., 1, 2] = 2 * (y * z - w * x)
    out[..., 2, 0] = 2 * (x * z - w * y)
    out[..., 2, 1] = 2 * (y * z + w * x)
    out[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return out


def from_matrix(m: Array) -> Array:
    """Unit quaternions `(..., 4)`, w >= 0, of rotation matrices `(..., 3, 3)` (Shepperd's method)."""
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    yz, zx, xy = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    sxy, szx, syz = m[..., 1, 0] + m[..., 0, 1], m[..., 0, 2] + m[..., 2, 0], m[..., 2, 1] + m[..., 1, 2]
    # row i is the quaternion times four times its i-th component: the one with the largest is the exact one
    w, x, y, z = 1 + xx + yy + zz, 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz
    rows = ((w, yz, zx, xy), (yz, x, sxy, szx), (zx, sxy, y, syz), (xy, szx, syz, z))
    best = np.argmax(_joined((w, x, y, z)), axis=-1)
    q = _joined([np.choose(best, column) for column in zip(*rows, strict=True)])
    length: Array = np.linalg.norm(q, axis=-1, keepdims=True)
    q = q / length
    return np.where(q[..., :1] < 0.0, -q, q)


def to_sixd(q: Array) -> Array:
    """The first two columns of the rotation matrix, `(..., 6)` (Zhou et al. 2019)."""
    m = to_matrix(q)
    return np.concatenate([m[..., 0], m[..., 1]], axis=-1)


def from_sixd(sixd: Array) -> Array:
    """Unit quaternions of 6-D rotations `(..., 6)` by Gram-Schmidt (Zhou et al. 2019)."""
    x: Array = sixd[..., :3] / np.maximum(np.linalg.norm(sixd[..., :3], axis=-1, keepdims=True), 1e-12)
    y: Array = sixd[..., 3:] - np.sum(x * sixd[..., 3:], axis=-1, keepdims=True) * x
    y = y / np.maximum(np.linalg.norm(y, axis=-1, keepdims=True), 1e-12)
    return from_matrix(np.stack([x, y, np.cross(x, y)], axis=-1))


def between(a: Array, b: Array) -> Array:
    """The shortest rotation `(..., 4)` that turns directions `a` into `b`, both `(..., 3)` of any length.

    Opposite directions turn by pi about an axis perpendicular to `a`.
    """
    a = a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-12)
    b = b / np.maximum(np.linalg.norm(b, axis=-1, keepdims=True), 1e-12)
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    q = np.concatenate([1.0 + cosine, np.cross(a, b)], axis=-1)
    helper = np.where(np.abs(a[..., :1]) < 0.9, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    half_turn = np.concatenate([np.zeros_like(a[..., :1]), np.cross(a, helper)], axis=-1)
    return normalize(np.where(cosine < -1.0 + 1e-9, half_turn, q))


def slerp(a: Array, b: Array, t: ArrayLike) -> Array:
    """Spherical linear interpolation on the shortest arc; `t` in [0, 1] with the leading axes' shape."""
    step = to_rotation_vector(multiply(b, conjugate(a)))
    return normalize(multiply(from_rotation_vector(step * np.asarray(t)[..., None]), a))


def continuous(q: Array) -> Array:
    """`q` `(T, ..., 4)` with signs chosen so that neighbours in time lie in the same half-space."""
    if len(q) < 2:
        return q.copy()
    flips = np.einsum("...i,...i->...", q[1:], q[:-1]) < 0.0
    if not flips.any():
        return q.copy(order="K")
    signs = np.where(np.logical_xor.accumulate(flips, axis=0), -1.0, 1.0)
    return np.concatenate([q[:1], q[1:] * signs[..., None]], axis=0)


def from_yaw(yaw: ArrayLike) -> Array:
    """Rotations about the world's Z by `yaw` radians `(...)`: `(..., 4)`."""
    return from_axis("Z", yaw)


def heading(q: Array) -> Array:
    """The yaw in radians `(...)` of the projection on the ground of the body's forward axis +Y.

    Where forward is within about 6 degrees of vertical the body's up axis tells the heading instead: looking
    straight down, the top of the head points forward; straight up, backward.
    """
    w, x, y, z = _components(q)
    forward = 2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)
    up = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    steep, sign = np.abs(forward[2]) > 0.995, -np.sign(forward[2])
    east, north = (np.where(steep, sign * up[i], forward[i]) for i in range(2))
    return angles.arctan2(-east, north)
