"""Raw rows of scripted solvers on a two-link arm: nothing is believed and nothing is dropped."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scripted import Scripted, task

from baselines import Budget, SolverError
from pipeline.evaluation.config import Tolerance
from pipeline.evaluation.rows import COLUMNS
from pipeline.evaluation.runner import (
    EvaluationError,
    count_poses,
    evaluate_solver,
)
from pipeline.evaluation.task import EvaluationTask
from pipeline.evaluation.verification import VerificationError, tip_poses

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


def test_errors_come_from_the_joints_not_from_the_claim(robot, config):
    target = robot.sample(1, seed=9, collision_free=False)
    liar = Scripted(robot, robot.home)
    rows = evaluate_solver(EvaluationTask(robot, liar, robot.forward_kinematics(target)), config)
    wanted = robot.forward_kinematics(target)[0, :3]
    home = robot.forward_kinematics(robot.home)[0, :3]
    assert rows.found.all()
    assert rows.claimed_and_wrong.all()
    assert rows.position_error_mm[0] == pytest.approx(np.linalg.norm(wanted - home) * 1e3)
    assert rows.position_error_mm[0] == rows.idle_position_error_mm[0]


def test_a_right_answer_is_right_and_columns_are_complete(robot, config):
    joints = robot.sample(1, seed=2, collision_free=False)
    given = EvaluationTask(
        robot, Scripted(robot, joints[0]), robot.forward_kinematics(joints), seed=7
    )
    rows = evaluate_solver(given, config)
    assert rows.position_error_mm[0] < 1e-9
    assert not rows.claimed_and_wrong[0]
    described = {"target_y_m", "target_z_m", *(f"q{i}" for i in range(robot.dof))} | set(COLUMNS)
    assert set(rows.columns) == described
    assert (rows.seed == 7).all()
    np.testing.assert_array_equal(rows[[f"q{i}" for i in range(robot.dof)]], joints)


def test_a_joint_beyond_its_limit_makes_a_claim_wrong(robot, config):
    beyond = robot.upper + 0.01
    given = EvaluationTask(robot, Scripted(robot, beyond), tip_poses(robot, beyond[None]))
    rows = evaluate_solver(given, config)
    assert rows.position_error_mm[0] < 1e-9
    assert not rows.within_limits[0]
    assert rows.claimed_and_wrong[0]


def test_not_found_is_unanswered_unless_every_answer_counts(robot, config):
    given = task(robot, Scripted(robot, robot.home, found=False))
    assert not evaluate_solver(given, config).answered.any()
    given.solver.always_answers = True
    rows = evaluate_solver(given, config)
    assert rows.answered.all()
    assert not rows.found.any()
    assert not rows.claimed_and_wrong.any()


@pytest.mark.parametrize("fault", [SolverError("no"), RuntimeError("crashed"), ZeroDivisionError()])
def test_a_failing_solver_becomes_rows_with_a_reason(robot, config, fault):
    rows = evaluate_solver(task(robot, Scripted(robot, robot.home, fault=fault)), config)
    assert len(rows) == 12
    assert not rows.found.any()
    assert rows.reason.str.startswith(type(fault).__name__).all()


def test_joints_that_are_not_finite_become_home_and_not_found(robot, config):
    rows = evaluate_solver(task(robot, Scripted(robot, [np.nan] * robot.dof)), config)
    assert not rows.found.any()
    assert np.isfinite(rows.position_error_mm).all()
    assert (rows.reason == "joints were not finite").all()


def test_a_mistake_in_a_solver_is_not_hidden(robot, config):
    with pytest.raises(TypeError):
        evaluate_solver(task(robot, Scripted(robot, robot.home, fault=TypeError("bug"))), config)


def test_batches_first_for_all_poses_then_for_time(robot, config):
    config = replace(config, batch_sizes=[5, 2], latency_poses=3)
    given = task(robot, Scripted(robot, robot.home))
    rows = evaluate_solver(given, config)
    assert rows.groupby("batch_size").size().to_dict() == {2: 2, 5: 12}
    assert rows[rows.batch_size == 5].pose.tolist() == list(range(12))
    assert count_poses(given, config) == len(rows) == 14


def test_a_batch_larger_than_the_test_set_goes_through_it_again(robot, config):
    config = replace(config, batch_sizes=[1, 30])
    given = task(robot, Scripted(robot, robot.home))
    rows = evaluate_solver(given, config)
    large = rows[rows.batch_size == 30]
    assert large.pose.tolist() == [k % 12 for k in range(30)]
    again = large[large.pose == 5]
    assert again.target_x_m.nunique() == 1
    assert large.time_per_pose_us.nunique() == 1


def test_a_solver_that_is_slow_pose_by_pose_is_judged_in_batches(robot, config):
    config = replace(config, batch_sizes=[1, 4], error_batch_size={"scripted": 6})
    rows = evaluate_solver(task(robot, Scripted(robot, robot.home)), config)
    assert rows.batch_size.unique().tolist() == [6, 1, 4]
    assert rows.groupby("batch_size").size().to_dict() == {6: 12, 1: 4, 4: 4}


def test_the_budget_is_what_the_solver_heeds(robot, config):
    solver = Scripted(robot, robot.home)
    evaluate_solver(task(robot, solver), replace(config, iterations=30))
    assert set(solver.budgets_seen) == {Budget(iterations=30)}


def test_a_killed_run_goes_on_with_the_same_rows(robot, config, tmp_path):
    class KilledError(Exception):
        pass

    def kill_at_ten(done, seen=[]):  # noqa: B006 - counts across calls
        seen.append(done)
        if sum(seen) >= 10:
            raise KilledError

    joints = robot.sample(1, seed=1, collision_free=False)[0]
    given = task(robot, Scripted(robot, joints))
    with pytest.raises(KilledError):
        evaluate_solver(given, config, tmp_path, kill_at_ten)
    before = given.solver.calls
    rows = evaluate_solver(given, config, tmp_path)
    assert given.solver.calls - before == 2
    whole = evaluate_solver(given, config)
    timings = ["time_per_pose_us", "solver_time_us"]
    assert rows.drop(columns=timings).equals(whole.drop(columns=timings))


def test_parts_of_another_question_or_damaged_ones_are_not_used(robot, config, tmp_path):
    given = task(robot, Scripted(robot, robot.home))
    evaluate_solver(given, config, tmp_path)
    other = replace(given, solver=Scripted(robot, robot.upper))
    changed = replace(config, claim=Tolerance(position_mm=1.0, rotation_deg=1.0))
    evaluate_solver(other, changed, tmp_path)
    assert other.solver.calls == 12
    damaged = next(tmp_path.glob("batch1_00000000.parquet"))
    damaged.write_bytes(damaged.read_bytes()[:100])
    again = replace(given, solver=Scripted(robot, robot.upper))
    evaluate_solver(again, changed, tmp_path)
    assert again.solver.calls == 5


def test_what_cannot_be_evaluated_is_refused(robot, config):
    empty = replace(task(robot, Scripted(robot, robot.home)), poses=np.empty((0, 7)))
    with pytest.raises(EvaluationError, match="at least one pose"):
        evaluate_solver(empty, config)
    with pytest.raises(VerificationError, match="shape"):
        tip_poses(robot, np.zeros((2, robot.dof + 1)))
    with pytest.raises(ValueError, match=r"evaluate\.chunk"):
        replace(config, chunk=0)
