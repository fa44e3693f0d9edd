"""Quaternions at the edges: kinds of numbers, any leading axes, no length, tiny angles, half turns, gimbal lock."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from footwork.core.maths import quat
from scipy.spatial.transform import Rotation

ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def scipy_of(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1).reshape(-1, 4))


def random(n: int, seed: int = 0) -> np.ndarray:
    return np.roll(Rotation.random(n, random_state=seed).as_quat(), 1, axis=-1)


def unlike(a: np.ndarray, b: np.ndarray) -> float:
    """Greatest difference of unit quaternions as rotations, in radians."""
    return float((scipy_of(a) * scipy_of(b).inv()).magnitude().max())


Q, P = random(24, 1), random(24, 2)
V = np.random.default_rng(3).normal(size=(24, 3))
M = scipy_of(Q).as_matrix()
OF_ANY_AXES: dict[str, tuple[Callable[..., np.ndarray], tuple[np.ndarray, ...]]] = {
    "multiply": (quat.multiply, (Q, P)),
    "conjugate": (quat.conjugate, (Q,)),
    "normalize": (quat.normalize, (Q * 3.0,)),
    "rotate": (quat.rotate, (Q, V)),
    "from_rotation_vector": (quat.from_rotation_vector, (V,)),
    "to_rotation_vector": (quat.to_rotation_vector, (Q,)),
    "from_euler": (lambda a: quat.from_euler(a, "ZXY"), (V,)),
    "to_euler": (lambda q: quat.to_euler(q, "YXZ"), (Q,)),
    "to_matrix": (quat.to_matrix, (Q,)),
    "from_matrix": (quat.from_matrix, (M,)),
    "to_sixd": (quat.to_sixd, (Q,)),
    "from_sixd": (quat.from_sixd, (quat.to_sixd(Q),)),
    "between": (quat.between, (V, V[::-1] + 0.1)),
    "slerp": (quat.slerp, (Q, P, np.linspace(0.0, 1.0, 24))),
    "heading": (quat.heading, (Q,)),
    "from_yaw": (quat.from_yaw, (V[:, 0],)),
}


@pytest.mark.parametrize("name", OF_ANY_AXES)
def test_leading_axes_do_not_matter(name: str) -> None:
    function, arguments = OF_ANY_AXES[name]
    flat = function(*arguments)
    for shape in ((2, 3, 4), (24, 1)):
        shaped = function(*(a.reshape(*shape, *a.shape[1:]) for a in arguments))
        np.testing.assert_allclose(shaped, flat.reshape(*shape, *flat.shape[1:]), atol=1e-15)
    for i in (0, 5, 23):
        np.testing.assert_allclose(function(*(a[i] for a in arguments)), flat[i], atol=1e-15)


@pytest.mark.parametrize(
    "name", ["from_rotation_vector", "from_matrix", "from_sixd", "between", "slerp", "from_euler"]
)
def test_results_have_unit_length(name: str) -> None:
    function, arguments = OF_ANY_AXES[name]
    np.testing.assert_allclose(np.linalg.norm(function(*arguments), axis=-1), 1.0, atol=1e-14)


@pytest.mark.parametrize("function", [quat.multiply, quat.rotate])
def test_products_keep_the_finer_of_two_kinds(function) -> None:
    a, b = Q, P if function is quat.multiply else V
    small = np.float32
    assert function(a.astype(small), b.astype(small)).dtype == np.float32
    assert function(a, b.astype(small)).dtype == np.float64
    assert function(a.astype(small), b).dtype == np.float64
    np.testing.assert_allclose(function(a.astype(small), b.astype(small)), function(a, b), atol=2e-6)


def test_single_precision_stays_single() -> None:
    q = Q.astype(np.float32)
    for function in (quat.conjugate, quat.to_matrix, quat.to_sixd):
        assert function(q).dtype == np.float32
        np.testing.assert_allclose(function(q), function(Q), atol=1e-6)
    assert quat.from_matrix(M.astype(np.float32)).dtype == np.float32


@pytest.mark.parametrize("function", [quat.multiply, quat.rotate])
def test_one_goes_with_many(function) -> None:
    many = P.reshape(4, 6, 4) if function is quat.multiply else V.reshape(4, 6, 3)
    each = np.array([[function(Q[0], item) for item in row] for row in many])
    np.testing.assert_allclose(function(Q[0], many), each, atol=1e-15)
    each = np.array([function(q, many[0, 0]) for q in Q])
    np.testing.assert_allclose(function(Q, many[0, 0]), each, atol=1e-15)
    # rows and columns of a table: (4, 1) with (6,)
    rows, columns = Q[:4, None], many[0]
    each = np.array([[function(q, item) for item in columns] for q in Q[:4]])
    np.testing.assert_allclose(function(rows, columns), each, atol=1e-15)


def test_what_has_no_length_becomes_the_identity() -> None:
    one = np.array([0.1, -0.7, 0.5, 0.5])
    given = np.array([0.0, 1e-14, 1e-11, 1.0, -40.0])[:, None] * one
    expected = [[1, 0, 0, 0], [1, 0, 0, 0], one, one, -one]
    np.testing.assert_allclose(quat.normalize(given), expected, atol=1e-15)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.9e-8, 1.1e-8, 1e-7, 1e-3, 3.0, np.pi - 1e-9, 3.5, 7.0])
def test_rotation_vectors_of_any_length_are_scipys(angle: float) -> None:
    vector = angle * np.array([0.48, -0.6, 0.64])
    expected = np.roll(Rotation.from_rotvec(vector).as_quat(), 1)
    found = quat.from_rotation_vector(vector)
    np.testing.assert_allclose(found * np.sign(found @ expected), expected, rtol=1e-12, atol=1e-20)


@pytest.mark.parametrize("half", [0.0, 1e-13, 0.9e-10, 1.1e-10, 1e-6, 1.2, np.pi / 2 - 1e-9])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rotation_vectors_of_both_signs_of_a_quaternion(half: float, sign: float) -> None:
    axis = np.array([0.48, -0.6, 0.64])
    q = sign * np.array([np.cos(half), *np.sin(half) * axis])
    np.testing.assert_allclose(quat.to_rotation_vector(q), 2.0 * half * axis, rtol=1e-9, atol=1e-20)


def test_a_half_turn_has_a_vector_of_length_pi() -> None:
    axes = V / np.linalg.norm(V, axis=-1, keepdims=True)
    half_turns = np.concatenate([np.zeros((24, 1)), axes], axis=-1)
    np.testing.assert_allclose(quat.to_rotation_vector(half_turns), np.pi * axes, atol=1e-12)


@pytest.mark.parametrize("axis", "XYZ")
def test_turns_about_one_axis_are_scipys_for_any_kind_of_number(axis: str) -> None:
    whole = np.arange(-4, 5)
    expected = np.roll(Rotation.from_euler(axis.lower(), whole[:, None]).as_quat(), 1, axis=-1)
    for kind in (np.int64, np.float32, np.float64):
        found = quat.from_axis(axis, whole.astype(kind))
        assert found.dtype == np.float64
        assert unlike(found, expected) < 1e-12
        np.testing.assert_allclose(found[:, 0], np.cos(0.5 * whole), atol=1e-15)
    np.testing.assert_allclose(quat.from_axis(axis, 3), found[7], atol=1e-15)


@pytest.mark.parametrize("order", ORDERS)
def test_euler_angles_come_back_as_they_were(order: str) -> None:
    rng = np.random.default_rng(4)
    given = rng.uniform(-np.pi, np.pi, (300, 3))
    given[:, 1] = rng.uniform(-1.57, 1.57, 300)
    np.testing.assert_allclose(quat.to_euler(quat.from_euler(given, order), order), given, atol=1e-9)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_euler_angles_beside_and_in_gimbal_lock(order: str, sign: float) -> None:
    given = np.random.default_rng(5).uniform(-3.0, 3.0, (40, 3))
    given[:, 1] = sign * (np.pi / 2 - 1e-4)
    np.testing.assert_allclose(quat.to_euler(quat.from_euler(given, order), order), given, atol=1e-6)
    for beside in (0.0, 1e-6):
        given[:, 1] = sign * (np.pi / 2 - beside)
        q = quat.from_euler(given, order)
        found = quat.to_euler(q, order)
        np.testing.assert_array_equal(found[:, 2], np.zeros(40))
        np.testing.assert_allclose(found[:, 1], sign * np.pi / 2, atol=2e-6)
        assert unlike(quat.from_euler(found, order), q) < 3e-6


def test_quaternions_of_matrices_have_a_positive_w_and_stand_rounding() -> None:
    # every component is the largest in some of them, by far in some and hardly in others
    rng = np.random.default_rng(6)
    q = np.concatenate([random(200, 7), quat.normalize(np.eye(4) + 0.01 * rng.normal(size=(4, 4)))])
    close = quat.normalize(np.sign(rng.normal(size=(40, 4))) + 1e-3 * rng.normal(size=(40, 4)))
    q = np.concatenate([q, close])
    matrices = scipy_of(q).as_matrix()
    found = quat.from_matrix(matrices)
    assert (found[:, 0] >= 0.0).all()
    np.testing.assert_allclose(np.abs(np.sum(found * q, axis=-1)), 1.0, atol=1e-14)
    np.testing.assert_allclose(found, q * np.sign(np.sum(found * q, axis=-1, keepdims=True)), atol=1e-14)
    # a matrix that is scaled by rounding still gives a unit quaternion
    np.testing.assert_allclose(np.linalg.norm(quat.from_matrix(matrices * 1.001), axis=-1), 1.0, atol=1e-14)


def test_six_numbers_of_any_size_and_slant_are_made_axes() -> None:
    rng = np.random.default_rng(8)
    given = rng.normal(size=(50, 6)) * rng.uniform(1e-6, 100.0, (50, 1))
    found = scipy_of(quat.from_sixd(given)).as_matrix()
    for matrix, first, second in zip(found, given[:, :3], given[:, 3:], strict=True):
        # QR with a positive diagonal is the same process
        columns, upper = np.linalg.qr(np.stack([first, second], axis=-1))
        columns = columns * np.sign(np.diag(upper))
        np.testing.assert_allclose(matrix[:, :2], columns, atol=1e-8)


def test_six_zeros_are_some_rotation() -> None:
    assert np.isfinite(quat.from_sixd(np.zeros((3, 6)))).all()
    np.testing.assert_allclose(quat.to_sixd(Q), np.concatenate([M[..., 0], M[..., 1]], axis=-1), atol=1e-14)


@pytest.mark.parametrize("short", [1e-2, 1e-4, 1e-6, 0.0])
def test_between_directions_that_are_nearly_opposite(short: float) -> None:
    rng = np.random.default_rng(9)
    a = np.concatenate([np.eye(3), -np.eye(3), rng.normal(size=(200, 3))])
    a /= np.linalg.norm(a, axis=-1, keepdims=True)
    beside = np.cross(a, rng.normal(size=a.shape))
    beside /= np.linalg.norm(beside, axis=-1, keepdims=True)
    b = -np.cos(short) * a + np.sin(short) * beside
    q = quat.between(3.0 * a, 0.2 * b)
    np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1.0, atol=1e-14)
    np.testing.assert_allclose(scipy_of(q).apply(a), b, atol=1e-10 if short >= 1e-4 else 2e-6)
    np.testing.assert_allclose(scipy_of(q).magnitude(), np.pi - short, atol=2e-6)


def test_between_short_vectors_and_none() -> None:
    a, b = V[:12], V[12:]
    assert unlike(quat.between(a * 1e-9, b * 1e9), quat.between(a, b)) < 1e-7
    none = np.zeros(3)
    for q in (
        quat.between(none, b),
        quat.between(a, none),
        quat.between(none, none),
        quat.between(a, a * 7.0),
    ):
        np.testing.assert_allclose(q, np.broadcast_to([1.0, 0, 0, 0], q.shape), atol=1e-15)


def test_slerp_takes_either_sign_and_one_share_for_many() -> None:
    a, b = Q.reshape(4, 6, 4), P.reshape(4, 6, 4)
    shares = np.array([0.0, 0.25, 0.5, 1.0])[:, None]
    found = quat.slerp(a, b, shares)
    for i, share in enumerate(shares[:, 0]):
        turn = (scipy_of(b[i]) * scipy_of(a[i]).inv()).as_rotvec()
        expected = Rotation.from_rotvec(share * turn) * scipy_of(a[i])
        assert unlike(found[i], np.roll(expected.as_quat(), 1, axis=-1)) < 1e-7
        np.testing.assert_allclose(np.abs(np.sum(quat.slerp(a, -b, share)[i] * found[i], axis=-1)), 1.0)
    np.testing.assert_allclose(quat.slerp(a, b, 0), a, atol=1e-15)


def test_continuous_treats_each_joint_alone_and_keeps_the_first() -> None:
    frames = 60
    rng = np.random.default_rng(10)
    axes = np.array([[0.6, 0.0, 0.8], [0.0, -1.0, 0.0], [0.48, 0.64, -0.6]])
    smooth = quat.from_rotation_vector(np.linspace(0.0, 2.0, frames)[:, None, None] * axes)
    signs = rng.choice([-1.0, 1.0], (frames, 3))
    found = quat.continuous(smooth * signs[..., None])
    np.testing.assert_array_equal(found, smooth * signs[0][:, None])


@pytest.mark.parametrize("frames", [0, 1, 2, 5])
def test_what_is_continuous_stays_and_is_a_copy(frames: int) -> None:
    given = np.tile(Q[0], (frames, 2, 1))
    before = given.copy()
    found = quat.continuous(given)
    np.testing.assert_array_equal(found, given)
    found[:] = 0.0
    np.testing.assert_array_equal(given, before)
    if frames == 2:
        given[1, 1] *= -1.0
        np.testing.assert_array_equal(quat.continuous(given), before)


@pytest.mark.parametrize("roll", [0.0, 0.4, -1.1])
@pytest.mark.parametrize("down", [1.0, -1.0])
def test_heading_changes_from_forward_to_up_where_forward_is_steep(roll: float, down: float) -> None:
    yaws = np.linspace(-3.0, 3.0, 13)
    for pitch in np.radians([0.0, 50.0, 84.0, 84.5, 90.0]):
        angles = np.stack([yaws, np.full(13, -down * pitch), np.full(13, roll)], axis=-1)
        matrices = Rotation.from_euler("ZXY", angles).as_matrix()
        q = np.roll(Rotation.from_matrix(matrices).as_quat(), 1, axis=-1)
        # about 6 degrees from vertical: sin(84.27 degrees) = 0.995
        told = matrices[:, :, 1] if pitch < np.radians(84.27) else down * matrices[:, :, 2]
        expected = np.arctan2(-told[:, 0], told[:, 1])
        np.testing.assert_allclose(np.exp(1j * quat.heading(q)), np.exp(1j * expected), atol=1e-9)
