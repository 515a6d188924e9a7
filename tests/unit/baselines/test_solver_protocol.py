import numpy as np
import pytest

from baselines import Budget, BudgetError, InitialError, PoseError, Solution, Solver
from baselines.checks import check_initial, check_poses
from baselines.protocol import OUT_OF_ITERATIONS, OUT_OF_TIME, Answer, Clock, QuerySolver
from baselines.restarts import restart_configurations

POSE = np.array([0.1, 0.2, 0.3, 0.5, -0.5, 0.5, 0.5])
LOWER, UPPER = np.array([-1.0, 0.0]), np.array([1.0, 0.5])


class OneJoint:
    """As much of a robot as the protocol looks at."""

    name, dof = "one_joint", 2
    lower, upper, home = LOWER, UPPER, np.array([0.0, 0.25])
    endless = np.zeros(2, dtype=bool)


class Counting(QuerySolver):
    """Never finds anything, and leaves the limits."""

    def _solve_one(self, pose, initial, clock):
        while not clock.expired():
            clock.tick()
        return Answer(initial + 10.0, clock.expired())


@pytest.mark.parametrize(
    "values", [{}, {"time_s": 0.0}, {"time_s": -1.0}, {"time_s": np.inf}, {"iterations": 0}]
)
def test_impossible_budgets_are_refused(values):
    with pytest.raises(BudgetError):
        Budget(**values)


def test_poses_come_back_unit_and_as_a_copy():
    given = POSE[None] * np.array([1, 1, 1, 1.0005, 1.0005, 1.0005, 1.0005])
    before = given.copy()
    checked = check_poses(given)
    assert np.allclose(np.linalg.norm(checked[:, 3:], axis=1), 1.0, atol=1e-15)
    assert np.array_equal(given, before)


def test_poses_in_single_precision_are_unit_enough():
    check_poses(np.float32(POSE)[None])


@pytest.mark.parametrize("empty", [[], np.empty((0, 7)), np.empty(0)])
def test_no_poses_are_zero_poses(empty):
    assert check_poses(empty).shape == (0, 7)


def test_a_quaternion_without_length_is_refused():
    with pytest.raises(PoseError, match="pose 0 has a quaternion"):
        check_poses([[0, 0, 0, 0, 0, 0, 0]])


def test_the_initial_guess_is_moved_into_the_limits():
    guess = check_initial([-5.0, 0.3], 3, OneJoint.home, LOWER, UPPER)
    assert guess.tolist() == [[-1.0, 0.3]] * 3


def test_the_initial_guess_is_home_if_none_is_given():
    assert check_initial(None, 1, OneJoint.home, LOWER, UPPER).tolist() == [[0.0, 0.25]]


def test_one_guess_for_each_pose_must_be_as_many():
    with pytest.raises(InitialError, match=r"\(2,\) or \(3, 2\), got \(4, 2\)"):
        check_initial(np.zeros((4, 2)), 3, OneJoint.home, LOWER, UPPER)


def test_the_clock_counts_iterations():
    clock = Clock(Budget(iterations=2))
    assert clock.expired() == ""
    clock.tick()
    clock.tick()
    assert clock.expired() == OUT_OF_ITERATIONS


def test_a_query_solver_stops_by_the_clock_and_stays_inside_the_limits():
    solution = Counting(OneJoint()).solve(np.stack([POSE, POSE]), budget=Budget(time_s=0.002))
    assert solution.reason == (OUT_OF_TIME, OUT_OF_TIME)
    assert not solution.found.any()
    assert (solution.time_s >= 0.002).all()
    assert (solution.joints == UPPER).all()
    assert len(solution) == 2


def test_the_solvers_own_budget_serves_where_none_is_given():
    solution = Counting(OneJoint(), iterations=7).solve(POSE[None])
    assert solution.iterations.tolist() == [7]


def test_a_budget_that_the_solver_does_not_heed_is_refused():
    class TimeOnly(Counting):
        budgets = frozenset({"time_s"})

    with pytest.raises(BudgetError, match="heeds a budget of time_s, got only iterations"):
        TimeOnly(OneJoint(), time_s=0.1).solve(POSE[None], budget=Budget(iterations=3))


def test_missing_packages_are_named():
    class Missing(Counting):
        requires = ("numpy", "no_such_package")

    assert Counting.skip() is None
    assert Missing.skip() == "not installed: no_such_package"


def test_a_solver_without_a_method_cannot_be_made():
    with pytest.raises(TypeError):
        Solver(OneJoint())


def test_an_empty_solution_has_the_right_shape():
    assert Solution.empty(0, 3).joints.shape == (0, 3)


def first_restarts(pose, count=3):
    stream = restart_configurations(pose, LOWER, UPPER)
    return np.array([next(stream) for _ in range(count)])


def test_restarts_depend_on_the_pose_alone():
    turned = POSE * np.array([1, 1, 1, -1, -1, -1, -1])
    assert np.array_equal(first_restarts(POSE), first_restarts(turned))
    assert not np.array_equal(first_restarts(POSE), first_restarts(POSE + 1e-6))


def test_restarts_fill_the_limits():
    drawn = first_restarts(POSE, 2000)
    assert (drawn >= LOWER).all() and (drawn <= UPPER).all()
    assert np.allclose(drawn.mean(axis=0), (LOWER + UPPER) / 2, atol=0.05)
    assert np.allclose(drawn.std(axis=0), (UPPER - LOWER) / np.sqrt(12), atol=0.03)
