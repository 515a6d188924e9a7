"""Rotations in torch: agreement with SciPy, finite gradients everywhere."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from pipeline.learning.rotation import matrix_from_quaternion, quaternion_from_matrix

HALF_TURNS = [np.pi * axis for axis in np.eye(3)] + [np.pi * np.ones(3) / np.sqrt(3)]


def test_quaternion_equals_scipy_up_to_sign() -> None:
    rotation = Rotation.random(5000, random_state=0)
    ours = quaternion_from_matrix(torch.as_tensor(rotation.as_matrix())).numpy()
    theirs = rotation.as_quat(scalar_first=True)
    assert np.minimum(np.abs(ours - theirs).max(1), np.abs(ours + theirs).max(1)).max() < 1e-12


def test_matrix_equals_scipy_and_is_even_in_the_quaternion() -> None:
    rotation = Rotation.random(500, random_state=1)
    quaternion = torch.as_tensor(rotation.as_quat(scalar_first=True))
    matrix = matrix_from_quaternion(quaternion)
    np.testing.assert_allclose(matrix.numpy(), rotation.as_matrix(), atol=1e-12)
    assert torch.equal(matrix, matrix_from_quaternion(-quaternion))


@pytest.mark.parametrize("vector", [np.zeros(3), *HALF_TURNS])
def test_gradients_are_finite_where_others_divide_by_zero(vector: np.ndarray) -> None:
    matrix = torch.as_tensor(Rotation.from_rotvec(vector).as_matrix())[None].requires_grad_()
    quaternion_from_matrix(matrix).sum().backward()
    assert matrix.grad is not None
    assert torch.isfinite(matrix.grad).all()
