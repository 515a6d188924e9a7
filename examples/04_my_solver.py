"""A solver of one's own, outside the project, judged beside `lm` on the same poses."""

import numpy as np

from baselines import Answer, Clock, QuerySolver
from pipeline import Budget, evaluate, load_robot, load_solver
from robots.rotations import quaternion_conjugate, quaternion_multiply
from robots.rotations import rotation_vector_from_quaternion as rotation_vector


class Transpose(QuerySolver):
    """Steps along the transposed Jacobian; no restarts (Wolovich and Elliott, CDC 1984)."""

    def _solve_one(self, pose: np.ndarray, initial: np.ndarray, clock: Clock) -> Answer:
        joints = initial
        while True:
            tip = self.robot.forward_kinematics(joints)[0]
            turn = quaternion_multiply(pose[3:], quaternion_conjugate(tip[3:]))
            error = np.concatenate([pose[:3] - tip[:3], rotation_vector(turn)])
            if np.abs(error).max() < 1e-4:
                return Answer(joints, "")
            if reason := clock.expired():
                return Answer(joints, reason)
            clock.tick()
            J = self.robot.jacobian(joints)[0]
            ascent = J @ J.T @ error
            joints = joints + J.T @ error * (error @ ascent) / (ascent @ ascent)
            joints = np.clip(joints, self.lower, self.upper)


robot = load_robot("panda")
poses = robot.forward_kinematics(robot.sample(30, seed=0))
for solver in (Transpose(robot), load_solver("lm", robot)):
    rows = evaluate(solver, poses, budget=Budget(iterations=200))
    good = (rows["position_error_mm"] < 1) & (rows["rotation_error_deg"] < 1)
    print(f"{rows['solver'][0]}: {good.mean():.0%} within 1 mm / 1 deg, medians:")
    print(rows[["position_error_mm", "rotation_error_deg", "time_per_pose_us"]].median().round(3))
