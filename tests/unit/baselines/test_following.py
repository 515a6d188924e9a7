"""Following a motion: the barrier's derivatives, what the null space is used for, and where."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import AbilityError, Budget, InitialError, PoseError, SettingError
from baselines.follow_kernel import find_null_motion, limit_barrier, new_follow_work
from baselines.joint_range import joint_range
from baselines.linearise import find_error, find_jacobian, set_target
from baselines.lm import LevenbergMarquardt
from pipeline import load_solver
from robots import Robot, load_robot
from tests.small_arms import arm, save

GAIN = 0.7
ROUNDING = 1e-9


@pytest.fixture(scope="module", params=["panda", "fetch"])
def solver(request: pytest.FixtureRequest) -> LevenbergMarquardt:
    return loaded(load_robot(request.param))


def loaded(robot: Robot, **settings: object) -> LevenbergMarquardt:
    found = baselines.load("lm", robot, **settings)
    assert isinstance(found, LevenbergMarquardt)
    return found


def steps(robot: Robot, count: int, size: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Configurations (N, dof) inside the limits, and poses that lie a step of each joint away."""
    rng = np.random.default_rng(seed)
    last = robot.sample(count, seed=seed, collision_free=False)
    moved = last + rng.uniform(-size, size, last.shape)
    return last, robot.forward_kinematics(np.clip(moved, robot.lower, robot.upper))


def barrier(robot: Robot, q: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    """H by its formula, and the derivatives that the kernel writes."""
    gradient, curvature = np.empty(robot.dof), np.empty(robot.dof)
    limit_barrier(joint_range(robot), q, gradient, curvature)
    x = ((2.0 * q - robot.lower - robot.upper) / (robot.upper - robot.lower))[~robot.endless]
    return float(-np.log(1.0 - x * x).sum()), gradient, curvature


def test_the_barrier_has_these_derivatives(solver: LevenbergMarquardt) -> None:
    robot = solver.robot
    middle, half = (robot.lower + robot.upper) / 2, (robot.upper - robot.lower) / 2
    bounded = ~robot.endless
    _, gradient, _ = barrier(robot, middle)
    np.testing.assert_allclose(gradient, 0.0, atol=1e-12)
    _, gradient, _ = barrier(robot, middle + 0.6 * half)  # 2 x / ((1 - x²) half range)
    np.testing.assert_allclose(gradient[bounded], 1.2 / (0.64 * half[bounded]))
    q = robot.sample(1, seed=1, collision_free=False)[0]
    _, gradient, curvature = barrier(robot, q)
    for k, unit in enumerate(np.eye(robot.dof)):
        above, below = barrier(robot, q + 1e-6 * unit), barrier(robot, q - 1e-6 * unit)
        assert gradient[k] == pytest.approx((above[0] - below[0]) / 2e-6, rel=1e-5, abs=1e-7)
        assert curvature[k] == pytest.approx((above[1][k] - below[1][k]) / 2e-6, rel=1e-5, abs=1e-7)
        assert (curvature[k] > 0.0) == bounded[k]


def test_a_null_motion_leaves_the_tip_and_the_limits(solver: LevenbergMarquardt) -> None:
    """It is no longer than its bound, does not move the tip, and lowers the barrier."""
    robot = solver.robot
    last, poses = steps(robot, 50, 0.01)
    w = new_follow_work(len(robot.chain.prismatic), robot.dof)
    for q, pose in zip(last, poses, strict=True):
        w.q[:] = q
        set_target(pose, w.at)
        find_error(robot.chain, w.q, pose, w.at)
        find_jacobian(robot.chain, w.at)
        find_null_motion(joint_range(robot), w, None, GAIN, 1e-12)
        J = w.at.jacobian.T
        if np.linalg.svd(J)[1][-1] < 1e-2:
            continue  # near a singularity damping lets a little of the motion through
        toward = np.linalg.lstsq(J, w.at.error, rcond=None)[0]
        assert np.abs(w.bias).max() <= GAIN * np.abs(toward).max() * (1 + 1e-4)
        assert np.abs(J @ w.bias).max() <= 1e-6 * np.abs(w.bias).max()
        assert w.bias @ barrier(robot, q)[1] < 0.0


@pytest.mark.parametrize("size", [1e-4, 1e-3, 1e-2])
def test_poses_are_reached_as_well_and_joints_step_little_more(
    solver: LevenbergMarquardt, size: float
) -> None:
    robot = solver.robot
    last, poses = steps(robot, 100, size)
    followed = solver.follow(poses, last)
    plain = loaded(robot, null_space=1e-12).follow(poses, last)
    assert followed.found.all()
    reached = robot.forward_kinematics(followed.joints)
    assert np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).max() < 1.01e-4
    assert robot.within_limits(followed.joints).all()
    own, more = np.abs(plain.joints - last).max(axis=1), np.abs(followed.joints - last).max(axis=1)
    # The gain bounds the first step; those after it undo its curvature, of second order.
    assert (more <= (1 + GAIN) * own + size * max(0.1, 20 * size)).mean() > 0.97


def test_what_stands_still_stays(solver: LevenbergMarquardt) -> None:
    robot = solver.robot
    joints = robot.sample(20, seed=2, collision_free=False)
    poses, held = robot.forward_kinematics(joints), joints
    for _ in range(20):
        held = solver.follow(poses, held).joints
    np.testing.assert_allclose(held, joints, atol=1e-5)


def test_a_long_motion_ends_further_from_limits(solver: LevenbergMarquardt) -> None:
    """To and fro over a short way, until what is gained in the null space is seen."""
    robot = solver.robot
    first = robot.sample(10, seed=4, collision_free=False)
    middle = (robot.lower + robot.upper) / 2
    sway = np.sin(np.linspace(0.0, 6 * np.pi, 200))[:, None]
    ends = []
    for start in first:
        poses = robot.forward_kinematics(start + 0.02 * sway * np.sign(middle - start))
        joints = start
        for pose in poses:
            joints, found = solver.follow_one(pose, joints)
            assert found
        ends.append(barrier(robot, joints)[0] - barrier(robot, start)[0])
    assert max(ends) < 0.05
    assert np.mean(ends) < -0.1


@pytest.mark.parametrize("name", ["lm", "cycleik_refined"])
def test_one_and_many_are_the_same_bits(name: str) -> None:
    robot = load_robot("panda")
    solver = load_solver(name, robot)
    last, poses = steps(robot, 20, 0.02)
    poses[3] = robot.forward_kinematics(robot.lower[None])[0]  # far away: searched for
    batch = solver.follow(poses, last)
    alone = [solver.follow_one(pose, q) for pose, q in zip(poses, last, strict=True)]
    np.testing.assert_array_equal(np.array([row for row, _ in alone]), batch.joints)
    np.testing.assert_array_equal([found for _, found in alone], batch.found)
    assert (batch.time_s > 0).all()
    assert (batch.iterations > 0).all()
    assert all((reason == "") == found for reason, found in zip(*reasons(batch), strict=True))
    listed, found = solver.follow_one(poses[0].tolist(), last[0].tolist())
    assert found
    np.testing.assert_array_equal(listed, batch.joints[0])


def reasons(solution: baselines.Solution) -> tuple[tuple[str, ...], np.ndarray]:
    return solution.reason, solution.found


@pytest.mark.parametrize("name", ["panda", "nico"])  # joints to spare, or none
@pytest.mark.parametrize("budget", [None, Budget(time_s=1.0)])
def test_a_row_alone_is_followed_to_as_among_many(name: str, budget: Budget | None) -> None:
    solver = loaded(load_robot(name))
    last, poses = steps(solver.robot, 40, 0.02)
    poses[::7] = solver.robot.forward_kinematics(solver.robot.sample(6, seed=5))  # lost
    poses[3, 3:] *= -1.0
    many = solver.follow(poses, last, budget)
    for row in range(len(poses)):
        alone = solver.follow(poses[row : row + 1], last[row : row + 1], budget)
        assert np.array_equal(alone.joints[0], many.joints[row])
        assert alone.found[0] == many.found[row]
        assert alone.reason[0] == many.reason[row]
    with pytest.raises(PoseError):
        solver.follow(poses[:1] * np.nan, last[:1])
    with pytest.raises(InitialError):
        solver.follow(poses[:1], last[:1] * np.nan)


@pytest.mark.parametrize(("name", "gain"), [("nico", 0.7), ("panda", 0.0)])
def test_without_joints_to_spare_or_gain_it_is_the_ordinary_answer(name: str, gain: float) -> None:
    robot = load_robot(name)
    solver = loaded(robot, null_space=gain)
    last, poses = steps(robot, 20, 0.02)
    expected = solver.solve(poses, last)
    np.testing.assert_array_equal(solver.follow(poses, last).joints, expected.joints)
    np.testing.assert_array_equal(solver.follow_one(poses[0], last[0])[0], expected.joints[0])


@pytest.mark.parametrize("name", ["lm", "cycleik_refined"])
def test_ordinary_answers_do_not_know_of_it(name: str) -> None:
    robot = load_robot("panda")
    last, poses = steps(robot, 30, 0.05)
    answers = []
    for gain in (0.0, 0.7, 3.0):
        solver = load_solver(name, robot)
        (solver.kernel if name != "lm" else solver).null_space = gain  # type: ignore[attr-defined]
        solver.null_space = gain  # type: ignore[attr-defined]
        solver.follow(poses, last)
        answers.append(
            (
                solver.solve(poses, last).joints,
                solver.solve(poses).joints,
                np.array([solver.solve_one(p, q)[0] for p, q in zip(poses, last, strict=True)]),
            )
        )
    for other in answers[1:]:
        for mine, theirs in zip(answers[0], other, strict=True):
            np.testing.assert_array_equal(mine, theirs)


def test_a_largest_jump_holds(solver: LevenbergMarquardt) -> None:
    robot = solver.robot
    bounded = loaded(robot, max_jump=0.02)
    assert bounded.lacks("follow") is None
    last, poses = steps(robot, 100, 0.018)
    followed = bounded.follow(poses, last)
    assert followed.found.mean() > 0.9
    assert np.abs(followed.joints - last).max() <= 0.02 + ROUNDING


def test_an_endless_joint_has_no_part_and_turns_on(tmp_path: Path) -> None:
    """A joint without limits comes back beside its last answer, whole turns away from zero too."""
    text = arm(7, limit='<limit lower="-2" upper="2" velocity="1" effort="1"/>')
    text = text.replace('name="j4" type="revolute"', 'name="j4" type="continuous"')
    robot = load_robot(urdf=save(tmp_path, text))
    last, poses = steps(robot, 10, 0.01)
    assert barrier(robot, last[0])[1][3] == 0.0
    last[:, 3] += 6 * np.pi
    followed = loaded(robot).follow(poses, last)
    assert followed.found.all()
    assert np.abs(followed.joints - last).max() < 0.1


def test_wrong_input_is_refused_by_name(solver: LevenbergMarquardt) -> None:
    robot = solver.robot
    pose = robot.forward_kinematics(robot.home[None])[0]
    with pytest.raises(PoseError):
        solver.follow_one(pose[:6], robot.home)
    with pytest.raises(InitialError):
        solver.follow_one(pose, robot.home[:-1])
    with pytest.raises(InitialError):
        solver.follow(pose[None], np.full(robot.dof, np.nan))
    assert len(solver.follow(np.empty((0, 7)), robot.home)) == 0
    assert solver.follow(pose[None], robot.home, Budget(iterations=1)).iterations[0] <= 1
    with pytest.raises(AbilityError, match="'bio_ik' has no follow"):
        baselines.load("bio_ik", robot).follow(pose[None], robot.home)
    for value in (-0.1, np.nan, np.inf, "much"):
        with pytest.raises(SettingError, match="null_space"):
            loaded(robot, null_space=value)
