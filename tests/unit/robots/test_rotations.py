import numpy as np
import pinocchio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robots import rotations as rot

angles = st.floats(-7.0, 7.0)
vectors = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)


@pytest.fixture(scope="module")
def quaternions() -> np.ndarray:
    random = np.random.default_rng(5).normal(size=(200, 4))
    # Half turns and near-identities: where naive conversions lose their digits.
    special = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1], [1, 1e-9, 0, 0]])
    edge = np.array([[1e-9, 1, 0, 0], [-1e-12, 0.6, 0.8, 0], [1e-200, 0, 1, 0]])
    return rot.normalised(np.concatenate([random, special, edge]))


def test_matrix_agrees_with_pinocchio(quaternions: np.ndarray) -> None:
    for w, x, y, z in quaternions:
        expected = pinocchio.Quaternion(w, x, y, z).matrix()
        assert rot.matrix_from_quaternion([w, x, y, z]) == pytest.approx(expected, abs=1e-15)


def test_matrix_and_quaternion_are_inverse(quaternions: np.ndarray) -> None:
    back = rot.quaternion_from_matrix(rot.matrix_from_quaternion(quaternions))
    assert rot.rotation_angle(back, quaternions).max() < 1e-14
    assert (back[:, 0] >= 0).all()


def test_product_of_quaternions_is_product_of_matrices(quaternions: np.ndarray) -> None:
    first, second = quaternions, quaternions[::-1]
    product = rot.matrix_from_quaternion(rot.quaternion_multiply(first, second))
    expected = rot.matrix_from_quaternion(first) @ rot.matrix_from_quaternion(second)
    assert product == pytest.approx(expected, abs=1e-14)


@given(vectors)
def test_exponential_and_logarithm_are_inverse(vector: np.ndarray) -> None:
    angle = np.linalg.norm(vector)
    if angle < np.pi - 1e-6:
        back = rot.rotation_vector_from_quaternion(rot.quaternion_from_rotation_vector(vector))
        assert back == pytest.approx(vector, abs=1e-12)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1e-4, 1.0, np.pi - 1e-6, np.pi])
def test_angle_is_exact_at_any_size(angle: float) -> None:
    start = rot.normalised([0.3, -0.5, 0.7, 0.1])
    turn = rot.quaternion_from_rotation_vector(angle * np.array([0.6, 0.0, 0.8]))
    end = -rot.quaternion_multiply(start, turn)
    assert rot.rotation_angle(start, end) == pytest.approx(angle, rel=1e-7, abs=1e-15)


def test_canonical_sign_is_unique() -> None:
    given_ = [[-0.5, 0.5, 0.5, 0.5], [0.0, -1.0, 0.0, 0.0], [-0.0, 0.0, 0.0, -1.0]]
    assert rot.canonical(given_).tolist() == [[0.5, -0.5, -0.5, -0.5], [0, 1, 0, 0], [0, 0, 0, 1]]


@given(angles, st.floats(-1.57, 1.57), angles)
def test_rpy_is_inverse_and_urdf_order(roll: float, pitch: float, yaw: float) -> None:
    matrix = rot.matrix_from_rpy([roll, pitch, yaw])
    assert matrix == pytest.approx(pinocchio.rpy.rpyToMatrix(roll, pitch, yaw), abs=1e-14)
    assert rot.matrix_from_rpy(rot.rpy_from_matrix(matrix)) == pytest.approx(matrix, abs=1e-12)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_rpy_in_gimbal_lock(pitch: float) -> None:
    matrix = rot.matrix_from_rpy([0.7, pitch, -0.4])
    assert rot.matrix_from_rpy(rot.rpy_from_matrix(matrix)) == pytest.approx(matrix, abs=1e-12)
