"""Errors of poses: by hand, against SciPy, and what they must not depend on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from pipeline.evaluation.metrics import MetricError, euler_zyx, pose_errors, within

HALF = np.sqrt(0.5)
UNIT = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


def pose(position, quaternion):
    return np.array([[*position, *quaternion]])


def random_poses(count, seed):
    generator = np.random.default_rng(seed)
    quaternions = Rotation.random(count, random_state=seed).as_quat()[:, [3, 0, 1, 2]]
    return np.hstack([generator.uniform(-1, 1, (count, 3)), quaternions])


def test_position_by_hand():
    errors = pose_errors(UNIT[None], pose([0.003, -0.004, 0.012], [1, 0, 0, 0]))
    assert errors.position_mm == pytest.approx([13.0])
    assert errors.paper_position_mm == pytest.approx([19.0 / 3])
    assert errors.rotation_deg == pytest.approx([0.0])


def test_quarter_turn_about_one_axis():
    errors = pose_errors(UNIT[None], pose([0, 0, 0], [HALF, 0, 0, HALF]))
    assert errors.rotation_deg == pytest.approx([90.0])
    assert errors.paper_rotation_deg == pytest.approx([30.0])


def test_rotation_error_is_in_axes_of_the_base():
    turned = Rotation.from_euler("xyz", [40, -30, 120], degrees=True)
    offset = Rotation.from_euler("zyx", [6, 9, 12], degrees=True)
    target, reached = (r.as_quat()[[3, 0, 1, 2]] for r in (offset * turned, turned))
    errors = pose_errors(pose([0, 0, 0], target), pose([0, 0, 0], reached))
    assert errors.paper_rotation_deg == pytest.approx([9.0])
    # In axes of the target the same two poses give other angles.
    other = np.abs((turned.inv() * offset * turned).as_euler("zyx", degrees=True)).mean()
    assert abs(other - 9.0) > 0.05


@pytest.mark.parametrize("size_deg", [1e-3, 1.0, 20.0, 120.0])
def test_both_products_are_told_apart(size_deg):
    generator = np.random.default_rng(8)
    target = Rotation.random(400, random_state=8)
    axes = generator.normal(size=(400, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    reached = Rotation.from_rotvec(np.deg2rad(size_deg) * axes) * target
    both = [
        np.hstack([np.zeros((400, 3)), r.as_quat()[:, [3, 0, 1, 2]]]) for r in (target, reached)
    ]
    errors = pose_errors(*both)
    of_base = np.abs((target * reached.inv()).as_euler("zyx", degrees=True)).mean(axis=1)
    of_target = np.abs((target.inv() * reached).as_euler("zyx", degrees=True)).mean(axis=1)
    np.testing.assert_allclose(errors.paper_rotation_deg, of_base, rtol=1e-6, atol=1e-9)
    assert np.abs(of_base - of_target).max() > 0.05 * size_deg


def test_agrees_with_scipy():
    target, reached = random_poses(500, 1), random_poses(500, 2)
    errors = pose_errors(target, reached)
    a, b = (Rotation.from_quat(p[:, [4, 5, 6, 3]]) for p in (target, reached))
    difference = a * b.inv()
    euler = np.abs(difference.as_euler("zyx", degrees=True)).mean(axis=1)
    np.testing.assert_allclose(errors.rotation_deg, np.rad2deg(difference.magnitude()), atol=1e-9)
    np.testing.assert_allclose(errors.paper_rotation_deg, euler, atol=1e-7)


def test_small_angles_keep_their_digits():
    half = 0.5e-7
    errors = pose_errors(UNIT[None], pose([0, 0, 0], [np.cos(half), np.sin(half), 0, 0]))
    assert errors.rotation_deg == pytest.approx([np.rad2deg(1e-7)], rel=1e-6)
    assert errors.paper_rotation_deg == pytest.approx([np.rad2deg(1e-7) / 3], rel=1e-6)


def test_gimbal_lock_gives_angles_of_the_same_rotation():
    for sign in (1, -1):
        matrix = Rotation.from_euler("zyx", [25, sign * 90, 0], degrees=True).as_matrix()
        angles = euler_zyx(matrix)
        again = Rotation.from_euler("zyx", angles).as_matrix()
        np.testing.assert_allclose(again, matrix, atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(
    arrays(float, (4,), elements=st.floats(-1, 1)),
    arrays(float, (4,), elements=st.floats(-1, 1)),
)
def test_quaternion_sign_does_not_matter(first, second):
    if min(np.linalg.norm(first), np.linalg.norm(second)) < 1e-2:
        return
    a, b = first / np.linalg.norm(first), second / np.linalg.norm(second)
    errors = pose_errors(pose([0, 0, 0], a), pose([0, 0, 0], b))
    negated = pose_errors(pose([0, 0, 0], -a), pose([0, 0, 0], b))
    np.testing.assert_allclose(negated.rotation_deg, errors.rotation_deg, atol=1e-9)
    np.testing.assert_allclose(negated.paper_rotation_deg, errors.paper_rotation_deg, atol=1e-9)


def test_a_whole_set_is_the_same_whichever_of_the_two_quaternions_is_written():
    target, reached = random_poses(300, 5), random_poses(300, 6)
    wanted = pose_errors(target, reached)
    flip = np.array([1, 1, 1, -1, -1, -1, -1])
    for first, second in ((target * flip, reached), (target, reached * flip)):
        errors = pose_errors(first, second)
        for name in vars(wanted):
            np.testing.assert_allclose(getattr(errors, name), getattr(wanted, name), atol=1e-9)


def test_half_a_turn_is_the_largest_rotation():
    errors = pose_errors(UNIT[None], pose([0, 0, 0], [0, 1, 0, 0]))
    assert errors.rotation_deg == pytest.approx([180.0])
    assert errors.paper_rotation_deg == pytest.approx([60.0])


def test_position_and_rotation_by_hand_together():
    target = pose([0.1, 0.2, 0.3], Rotation.from_rotvec([0, 0, np.pi / 2]).as_quat()[[3, 0, 1, 2]])
    reached = pose(
        [0.1, 0.204, 0.297], Rotation.from_rotvec([0, 0, np.pi / 3]).as_quat()[[3, 0, 1, 2]]
    )
    errors = pose_errors(target, reached)
    assert errors.position_mm == pytest.approx([5.0])
    assert errors.paper_position_mm == pytest.approx([7.0 / 3])
    assert errors.rotation_deg == pytest.approx([30.0])
    assert errors.paper_rotation_deg == pytest.approx([10.0])


def test_paper_family_is_never_above_the_geodesic_one_in_position():
    errors = pose_errors(random_poses(200, 3), random_poses(200, 4))
    assert (errors.paper_position_mm <= errors.position_mm + 1e-9).all()


def test_limits_are_exclusive_and_nan_never_succeeds():
    position, rotation = [9.999, 10.0, np.nan, 1.0], [1.0, 1.0, 1.0, 20.0]
    assert within(position, rotation, 10.0, 20.0).tolist() == [True, False, False, False]


@pytest.mark.parametrize(
    ("bad", "what"),
    [
        (np.zeros((3, 6)), r"shape \(N, 7\)"),
        (np.full((1, 7), np.nan), "finite"),
        (pose([0, 0, 0], [2, 0, 0, 0]), "unit"),
        (np.vstack([UNIT, UNIT]), "as many"),
    ],
)
def test_unusable_poses_are_refused(bad, what):
    with pytest.raises(MetricError, match=what):
        pose_errors(UNIT[None], bad)
