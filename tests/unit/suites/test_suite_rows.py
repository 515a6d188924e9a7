"""Solvers on suites: starts are the suite's, and on a trajectory the solver's own last answer."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from baselines import Solution, Solver
from baselines.abilities import FOLLOW
from pipeline.data.dataset import joint_columns
from pipeline.evaluation.config import EvaluateConfig
from pipeline.evaluation.runner import evaluate_solver, plan_chunks
from pipeline.evaluation.task import EvaluationTask
from pipeline.suites.generators import Suite
from pipeline.suites.problems import reached
from pipeline.suites.rows import COLUMNS, follows, initial, with_problems
from robots import Robot, load_robot


class Adds(Solver):
    """Answers with its initial guess and a hundredth more; remembers what it was given."""

    name = "adds"

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot)
        self.given: list[np.ndarray] = []

    def _solve_batch(self, poses: Any, initial: Any, budget: Any) -> Solution:
        self.given += list(initial)
        solution = Solution.empty(len(poses), self.robot.dof)
        return replace(solution, joints=initial + 0.01, reason=("no",) * len(poses))


class Follows(Adds):
    """Adds more where it follows a motion."""

    abilities = frozenset({FOLLOW})

    def _follow(self, poses: Any, last: Any, budget: Any) -> Solution:
        return replace(Solution.empty(len(poses), self.robot.dof), joints=last + 0.03)


def task(robot: Robot, suite: Suite, solver: type[Solver] = Adds) -> EvaluationTask:
    problems = suite.problems
    return EvaluationTask(
        robot,
        solver(robot),
        problems.poses,
        initial=initial(problems, robot),
        follows=follows(problems),
    )


def test_a_start_is_given_to_the_solver(arm: Robot, warm: Suite, evaluate: EvaluateConfig) -> None:
    given = task(arm, warm)
    rows = with_problems(evaluate_solver(given, evaluate), warm, arm)
    np.testing.assert_allclose(given.solver.given, warm.problems.start)  # type: ignore[attr-defined]
    np.testing.assert_allclose(rows.known_distance, 0.11)
    assert (rows.seeded_by == "given").all()
    assert {"suite", "suite_version", "stratum", "known_distance"} <= {*rows}
    assert rows.suite_version.unique().tolist() == [3]


def test_a_waypoint_starts_from_the_answer_before(
    arm: Robot, followed: Suite, evaluate: EvaluateConfig, tmp_path: Path
) -> None:
    """Also across a kill: chunks end where trajectories do."""
    given = task(arm, followed)
    assert list(plan_chunks(given, evaluate)) == [(1, 0, 3), (1, 3, 5)]
    rows = with_problems(evaluate_solver(given, evaluate, tmp_path), followed, arm)
    joints = rows[["q0", "q1"]].to_numpy()
    first = followed.problems.joints[[0, 3]]
    wanted = [first[0] + 0.01, first[0] + 0.02, first[0] + 0.03, first[1] + 0.01, first[1] + 0.02]
    np.testing.assert_allclose(joints, wanted)
    np.testing.assert_allclose(rows.joint_step, [np.nan, 0.01, 0.01, np.nan, 0.01])
    told = evaluate_solver(task(arm, followed, Follows), evaluate)
    off = told[["q0", "q1"]].to_numpy() - first[[0, 0, 0, 1, 1]]
    np.testing.assert_allclose(off[:, 0], [0.01, 0.04, 0.07, 0.01, 0.04])
    assert {*COLUMNS} <= {*rows}
    (tmp_path / "batch1_00000000.parquet").unlink()
    again = task(arm, followed)
    resumed = with_problems(evaluate_solver(again, evaluate, tmp_path), followed, arm)
    assert len(again.solver.given) == 3  # type: ignore[attr-defined]
    np.testing.assert_array_equal(resumed[["q0", "q1"]], rows[["q0", "q1"]])


def test_a_full_turn_of_an_endless_joint_is_no_step() -> None:
    """And a trajectory runs on over half a turn, where a joint with limits would be held."""
    robot = load_robot("fetch")
    turning = int(np.flatnonzero(robot.endless)[0])
    joints = np.repeat(robot.home[None], 3, axis=0)
    joints[:, turning] = [3.10, 3.14, 3.18]
    start = np.full_like(joints, np.nan)
    further = {"step": np.arange(3), "trajectory": np.zeros(3, dtype=int)}
    problems = reached(robot, joints, "plain", start, **further)
    np.testing.assert_allclose(problems.joints, joints)
    answers = joints.copy()
    answers[1, turning] -= 2 * np.pi
    frame = pd.DataFrame(answers, columns=joint_columns(robot)).assign(pose=np.arange(3))
    rows = with_problems(frame, Suite("tracking", "tracking", 1, problems, ""), robot)
    np.testing.assert_allclose(rows.joint_step, [np.nan, 0.04, 0.04], atol=1e-9)
