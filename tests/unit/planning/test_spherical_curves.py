import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation, Slerp

from pipeline.planning.bezier import path_parameter
from pipeline.planning.rotation import slerp, spherical_bezier
from robots.rotations import rotation_angle

K = path_parameter(50)


def random_rotations(number, seed=0):
    q = np.random.default_rng(seed).normal(size=(number, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def matrices(q):
    return Rotation.from_quat(np.asarray(q)[..., [1, 2, 3, 0]]).as_matrix()


@given(st.integers(0, 10_000))
def test_slerp_is_scipys(seed):
    q = random_rotations(2, seed)
    ours = matrices(slerp(q[0], q[1], K))
    ends = Rotation.from_quat(q[:, [1, 2, 3, 0]])
    assert_allclose(ours, Slerp([0, 1], ends)(K).as_matrix(), atol=1e-12)


def test_angular_speed_is_constant():
    q = random_rotations(2, 3)
    path = slerp(q[0], q[1], K)
    steps = rotation_angle(path[:-1], path[1:])
    assert_allclose(steps, rotation_angle(q[0], q[1]) / 49, atol=1e-13)


def test_antipodal_ends_are_one_rotation():
    q = random_rotations(1, 5)[0]
    assert_allclose(matrices(slerp(q, -q, K)), np.tile(matrices(q), (50, 1, 1)), atol=1e-15)


def test_half_turn_turns_half_way_in_the_middle():
    path = slerp([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], [0.5])
    assert_allclose(rotation_angle(path[0], [1.0, 0.0, 0.0, 0.0]), np.pi / 2, atol=1e-15)


def test_two_keys_give_slerp():
    q = random_rotations(2, 7)
    assert_allclose(matrices(spherical_bezier(q, K)), matrices(slerp(q[0], q[1], K)), atol=1e-12)


def test_the_curve_passes_every_key_whatever_its_sign():
    keys = random_rotations(5, 11)
    path = spherical_bezier(keys * [[1], [-1], [1], [1], [-1]], np.linspace(0, 1, 5))
    assert_allclose(matrices(path), matrices(keys), atol=1e-12)


def test_angular_velocity_is_continuous_at_the_keys():
    keys = random_rotations(4, 13)
    h = 1e-5
    for k in (1 / 3, 2 / 3):
        path = spherical_bezier(keys, [k - h, k, k + h])
        before = Rotation.from_matrix(matrices(path[0]).T @ matrices(path[1])).as_rotvec() / h
        after = Rotation.from_matrix(matrices(path[1]).T @ matrices(path[2])).as_rotvec() / h
        assert_allclose(before, after, atol=1e-3 * np.linalg.norm(after))


def test_keys_on_one_axis_stay_on_it():
    angles = np.array([0.0, 0.4, 0.5, 1.3])
    keys = np.stack([np.cos(angles / 2), 0 * angles, 0 * angles, np.sin(angles / 2)], axis=1)
    assert_allclose(spherical_bezier(keys, K)[:, 1:3], 0.0, atol=1e-15)


def test_no_unit_quaternion_is_refused():
    with pytest.raises(ValueError, match="unit quaternions"):
        slerp([1.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], K)
    with pytest.raises(ValueError, match="at least 2 keys"):
        spherical_bezier([[1.0, 0.0, 0.0, 0.0]], K)
