import numpy as np
import pytest
from numpy.testing import assert_allclose

from pipeline.planning.timing import minimum_jerk, time_scale

WAYPOINTS = np.cumsum(np.random.default_rng(0).normal(0, 0.1, size=(50, 6)), axis=0)
LIMIT = np.array([1.0, 2.0, 1.0, 0.5, 1.0, 3.0])


def test_minimum_jerk_starts_and_stops_at_rest():
    share = np.linspace(0, 1, 1001)
    position, velocity = minimum_jerk(share)
    assert_allclose(position[[0, -1]], [0, 1])
    assert_allclose(velocity[[0, -1]], 0)
    assert_allclose(velocity.max(), 1.875)
    assert_allclose(np.gradient(position, share)[1:-1], velocity[1:-1], atol=1e-4)


def test_a_straight_joint_path_takes_its_closed_form_duration():
    trajectory = time_scale([[0.0], [0.4], [0.8]], [1.0], speed=0.5, rate=1000.0)
    assert_allclose(trajectory.duration, 1.875 * 0.8 / 0.5, atol=2e-3)


def test_no_joint_exceeds_its_limit_and_one_comes_near_it():
    trajectory = time_scale(WAYPOINTS, LIMIT, speed=0.7, rate=240.0)
    share = np.abs(trajectory.velocities) / (0.7 * LIMIT)
    assert 0.95 < share.max() <= 1.01
    assert_allclose(trajectory.velocities[[0, -1]], 0, atol=1e-12)


def test_ends_are_kept_and_velocities_are_the_derivative():
    trajectory = time_scale(WAYPOINTS, LIMIT, speed=1.0, rate=2000.0)
    assert_allclose(trajectory.joints[[0, -1]], WAYPOINTS[[0, -1]], atol=1e-12)
    slope = np.gradient(trajectory.joints, trajectory.time, axis=0)
    assert_allclose(slope[2:-2], trajectory.velocities[2:-2], atol=5e-2)


def test_a_path_that_stands_still_is_short():
    trajectory = time_scale(np.ones((5, 2)), [1.0, 1.0], speed=1.0, rate=100.0)
    assert_allclose(trajectory.joints, 1.0)


def test_no_limit_is_refused():
    with pytest.raises(ValueError, match="positive velocity limits"):
        time_scale(WAYPOINTS, np.zeros(6), speed=1.0, rate=100.0)


def test_a_jump_costs_its_own_length_and_no_more() -> None:
    """One joint at 1 rad/s: 0.98 rad of even steps take as long as 0.49 with a jump of 0.49."""
    even = np.linspace(0.0, 0.98, 50)[:, None]
    jump = np.concatenate([np.linspace(0.0, 0.49, 25), np.linspace(0.98, 1.47, 25)])[:, None]
    seconds = [time_scale(path, [1.0], speed=1.0, rate=240.0).duration for path in (even, jump)]
    assert seconds[0] == pytest.approx(0.98 * 1.875, abs=0.01)
    assert seconds[1] == pytest.approx(1.47 * 1.875, rel=0.1)  # 27 s with even knots


def test_waypoints_that_coincide_are_passed() -> None:
    path = np.array([[0.0], [0.5], [0.5], [0.5], [1.0]])
    trajectory = time_scale(path, [1.0], speed=1.0, rate=240.0)
    assert np.isfinite(trajectory.joints).all()
    assert trajectory.joints.max() == pytest.approx(1.0, abs=1e-9)
    assert np.abs(trajectory.velocities).max() <= 1.0 + 1e-6
