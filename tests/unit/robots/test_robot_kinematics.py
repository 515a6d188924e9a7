import math

import numpy as np
import pinocchio
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from robots import Robot, RobotError, available_robots, load_robot
from robots.kinematics import tip_frame, tip_frame_and_jacobian
from robots.rotations import (
    matrix_from_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    rotation_angle,
    rotation_vector_from_quaternion,
)
from robots.trigonometry import sine_cosine

NAMES = [*available_robots(), "two_link", "mixed"]


@pytest.fixture(scope="module", params=NAMES)
def robot(request: pytest.FixtureRequest) -> Robot:
    if request.param in ("two_link", "mixed"):
        return request.getfixturevalue(request.param)
    return load_robot(request.param)


@njit
def _both(angle):  # type: ignore[no-untyped-def]
    return sine_cosine(angle)


@settings(deadline=None)  # the first call compiles
@given(st.floats(-1e6, 1e6))
def test_sine_and_cosine(angle: float) -> None:
    sine, cosine = _both(angle)
    assert abs(sine - math.sin(angle)) < 3e-16
    assert abs(cosine - math.cos(angle)) < 3e-16


def test_sine_and_cosine_of_no_number() -> None:
    assert all(math.isnan(value) for value in _both(float("nan")))


def test_two_links_by_hand(two_link: Robot) -> None:
    shoulder, elbow = 0.3, 0.5
    x = 0.4 * math.cos(shoulder) + 0.3 * math.cos(shoulder + elbow)
    y = 0.4 * math.sin(shoulder) + 0.3 * math.sin(shoulder + elbow)
    half = (shoulder + elbow) / 2
    expected = [x, y, 0.1, math.cos(half), 0, 0, math.sin(half)]
    assert two_link.forward_kinematics([shoulder, elbow])[0] == pytest.approx(expected, abs=1e-15)
    far = [0.3 * -math.sin(shoulder + elbow), 0.3 * math.cos(shoulder + elbow), 0, 0, 0, 1]
    assert two_link.jacobian([shoulder, elbow])[0, :, 1] == pytest.approx(far, abs=1e-15)
    assert two_link.jacobian([shoulder, elbow])[0, :2, 0] == pytest.approx([-y, x], abs=1e-15)


def _pinocchio_pose(robot: Robot, model: object, frame: int, q: np.ndarray) -> np.ndarray:
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, q)
    return data.oMf[frame].homogeneous


def test_pose_equals_pinocchio(robot: Robot) -> None:
    if robot.name == "mixed":
        pytest.skip("a coupled joint, which a plain Pinocchio model has not")
    model, frame = robot.pinocchio()
    joints = robot.sample(50, seed=1, collision_free=False)
    poses = robot.forward_kinematics(joints)
    for q, pose in zip(joints, poses, strict=True):
        expected = _pinocchio_pose(robot, model, frame, q)
        assert np.abs(pose[:3] - expected[:3, 3]).max() < 1e-12
        assert np.abs(matrix_from_quaternion(pose[3:]) - expected[:3, :3]).max() < 1e-12


def test_coupled_robot_equals_pinocchio_with_the_coupling_written_out(mixed: Robot) -> None:
    model, _ = mixed.collision.exact.model, None
    base, tool = model.getFrameId("bench"), model.getFrameId("tool")
    for q in mixed.sample(30, seed=2, collision_free=False):
        positions = np.zeros(model.nq)
        values = dict(zip(mixed.joint_names, q, strict=True)) | {"follower": -0.5 * q[2] + 0.2}
        for name, value in values.items():
            positions[model.joints[model.getJointId(name)].idx_q] = value
        data = model.createData()
        pinocchio.framesForwardKinematics(model, data, positions)
        expected = (data.oMf[base].inverse() * data.oMf[tool]).homogeneous
        pose = mixed.forward_kinematics(q)[0]
        assert np.abs(pose[:3] - expected[:3, 3]).max() < 1e-12
        assert np.abs(matrix_from_quaternion(pose[3:]) - expected[:3, :3]).max() < 1e-12


def test_jacobian_equals_finite_differences(robot: Robot) -> None:
    joints = robot.sample(20, seed=3, collision_free=False)
    jacobian, step = robot.jacobian(joints), 1e-6
    for k in range(robot.dof):
        shift = step * np.eye(robot.dof)[k]
        before = robot.forward_kinematics(joints - shift)
        after = robot.forward_kinematics(joints + shift)
        linear = (after[:, :3] - before[:, :3]) / (2 * step)
        turn = quaternion_multiply(after[:, 3:], quaternion_conjugate(before[:, 3:]))
        angular = rotation_vector_from_quaternion(turn) / (2 * step)
        assert np.abs(jacobian[:, :3, k] - linear).max() < 1e-8
        assert np.abs(jacobian[:, 3:, k] - angular).max() < 1e-8


def test_batches_and_threads_and_single_poses_agree(robot: Robot) -> None:
    joints = robot.sample(2500, seed=4, collision_free=False)
    poses = robot.forward_kinematics(joints)
    assert np.array_equal(poses, robot.forward_kinematics(joints, parallel=True))
    # A pose must not depend on where in a batch it stands.
    assert np.array_equal(poses[1000:1003], robot.forward_kinematics(joints[1000:1003]))
    R, p, J = np.empty((3, 3)), np.empty(3), np.empty((6, robot.dof))
    for i in (0, 63, 64, 2499):
        tip_frame(robot.chain, joints[i], R, p)
        assert np.abs(p - poses[i, :3]).max() < 1e-14
        tip_frame_and_jacobian(robot.chain, joints[i], R, p, J)
        assert np.abs(J - robot.jacobian(joints[i])[0]).max() < 1e-13
        assert np.abs(R - matrix_from_quaternion(poses[i, 3:])).max() < 1e-13


def test_quaternions_are_unit_and_canonical(robot: Robot) -> None:
    quaternion = robot.forward_kinematics(robot.sample(2000, collision_free=False))[:, 3:]
    assert np.abs(np.linalg.norm(quaternion, axis=1) - 1).max() < 1e-14
    assert (quaternion[:, 0] >= 0).all()


def test_torch_chain_agrees(robot: Robot) -> None:
    import torch

    if robot.name == "mixed":
        with pytest.raises(RobotError, match="mimics"):
            robot.torch_chain()
        return
    joints = robot.sample(100, seed=6, collision_free=False)
    poses = robot.forward_kinematics(joints)
    for dtype, tolerance in ((torch.float32, 5e-6), (torch.float64, 1e-6)):
        chain = robot.torch_chain(dtype)
        matrix = chain.forward_kinematics(torch.tensor(joints, dtype=dtype)).get_matrix().numpy()
        assert np.abs(matrix[:, :3, 3] - poses[:, :3]).max() < tolerance
        assert np.abs(matrix[:, :3, :3] - matrix_from_quaternion(poses[:, 3:])).max() < tolerance


def test_empty_batch(two_link: Robot) -> None:
    nothing = np.empty((0, 2))
    assert two_link.forward_kinematics(nothing).shape == (0, 7)
    assert two_link.jacobian(nothing).shape == (0, 6, 2)
    assert two_link.in_collision(nothing).shape == (0,)


@pytest.mark.parametrize("joints", [[0.0], [[0.0, 0.0, 0.0]], [[[0.0, 0.0]]], []])
def test_wrong_shape_is_refused(two_link: Robot, joints: list) -> None:
    with pytest.raises(RobotError, match=r"\(N, 2\)"):
        two_link.forward_kinematics(joints)


def test_whole_turns_change_nothing(mixed: Robot) -> None:
    q = mixed.sample(10, collision_free=False)
    turned = q + np.array([2 * np.pi, 0, 0])
    first, second = mixed.forward_kinematics(q), mixed.forward_kinematics(turned)
    assert np.abs(first[:, :3] - second[:, :3]).max() < 1e-14
    assert rotation_angle(first[:, 3:], second[:, 3:]).max() < 1e-14
