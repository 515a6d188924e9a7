"""`pipeline.evaluate`: a solver of one's own, judged from its joints and not from its claims."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from baselines import Answer, Budget, BudgetError, Clock, PoseError, QuerySolver
from pipeline import evaluate, load_robot, load_solver
from pipeline.errors import PipelineError

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


class Straight(QuerySolver):
    """Answers with all joints at zero and claims to have found it."""

    budgets = frozenset({"iterations"})

    def _solve_one(self, pose: np.ndarray, initial: np.ndarray, clock: Clock) -> Answer:
        return Answer(np.zeros(self.robot.dof), "")


@pytest.fixture(scope="module")
def straight() -> Straight:
    return Straight(load_robot(urdf=TWO_LINK, base="base", tip="tip"))


def test_errors_are_those_of_the_joints_whatever_is_claimed(straight: Straight) -> None:
    # Stretched along x the tip is at (0.7, 0, 0.1), with the shoulder at 90 deg at (0, 0.7, 0.1).
    poses = straight.robot.forward_kinematics([[0.0, 0.0], [np.pi / 2, 0.0]])
    rows = evaluate(straight, poses)
    assert rows["solver"].tolist() == ["Straight", "Straight"]
    assert rows["position_error_mm"].to_numpy() == pytest.approx([0, 700 * np.sqrt(2)], abs=1e-6)
    assert rows["rotation_error_deg"].to_numpy() == pytest.approx([0, 90], abs=1e-6)
    assert rows["paper_position_error_mm"].to_numpy() == pytest.approx([0, 1400 / 3], abs=1e-6)
    assert rows["claimed_and_wrong"].tolist() == [False, True]


def test_batch_budget_and_name_are_heeded(straight: Straight) -> None:
    robot = straight.robot
    poses = robot.forward_kinematics(robot.sample(7, seed=0))
    rows = evaluate(
        load_solver("lm", robot), poses, batch_size=3, budget=Budget(iterations=1), name="one step"
    )
    assert set(rows["solver"]) == {"one step"}
    assert rows["batch_size"].tolist() == [3] * 7
    assert (rows["iterations"] <= 1).all()


def test_what_cannot_be_judged_is_refused_before_it_runs(straight: Straight) -> None:
    poses = straight.robot.forward_kinematics([[0.0, 0.0]])
    with pytest.raises(BudgetError, match="heeds a budget of iterations"):
        evaluate(straight, poses, budget=Budget(time_s=1.0))
    with pytest.raises(PoseError):
        evaluate(straight, poses[:, :6])
    with pytest.raises(PipelineError, match="at least one pose"):
        evaluate(straight, poses[:0])
    with pytest.raises(PipelineError, match="batch_sizes"):
        evaluate(straight, poses, batch_size=0)
