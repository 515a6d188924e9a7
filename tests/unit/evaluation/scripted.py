"""Solvers whose answers a test chooses."""

from dataclasses import replace

import numpy as np

from baselines import QuerySolver, Solution, Solver
from baselines.protocol import Answer
from pipeline.evaluation.task import EvaluationTask


class Scripted(Solver):
    """Answers with joints that the test chose; counts its calls."""

    name = "scripted"

    def __init__(self, robot, joints, found=True, fault=None):
        super().__init__(robot)
        self.joints, self.claim, self.fault = np.asarray(joints), found, fault
        self.budgets_seen = []

    @property
    def calls(self):
        return len(self.budgets_seen)

    def _solve_batch(self, poses, initial, budget):
        self.budgets_seen.append(budget)
        if self.fault is not None:
            raise self.fault
        count = len(poses)
        solution = Solution.empty(count, self.robot.dof)
        joints = np.broadcast_to(self.joints, (count, self.robot.dof)).copy()
        reason = "" if self.claim else "no solution"
        return replace(
            solution, joints=joints, found=np.full(count, self.claim), reason=(reason,) * count
        )


class OneByOne(QuerySolver):
    name = "one_by_one"

    def _solve_one(self, pose, initial, clock):
        return Answer(initial, "")


def task(robot, solver, count=12):
    joints = robot.sample(count, seed=3, collision_free=False)
    return EvaluationTask(robot, solver, robot.forward_kinematics(joints), seed=7)
