"""Many solutions of one pose, free of self-collision, and how far apart they are."""

import numpy as np

from pipeline import load_robot, load_solver

COUNT = 200
APART = 0.1  # rad; solutions that are nearer in every joint count as one

robot = load_robot("panda")
solver = load_solver("lm", robot)
pose = robot.forward_kinematics(robot.sample(1, seed=3))

# Seven joints and six numbers in a pose: another start ends in another solution.
starts = robot.sample(COUNT, seed=1)
solution = solver.solve(np.repeat(pose, COUNT, axis=0), initial=starts)
joints = solution.joints[solution.found]
joints = joints[~robot.in_collision(joints)]

kept = np.empty((0, robot.dof))
for q in joints:
    if not (np.abs(kept - q).max(axis=1) < APART).any():
        kept = np.vstack([kept, q])
reached = robot.forward_kinematics(kept)
print(f"{len(joints)} of {COUNT} starts lead to a solution free of collision, {len(kept)} differ")
print(f"largest distance to the target: {1e3 * np.abs(reached - pose)[:, :3].max():.4f} mm")
for name, values in zip(robot.joint_names, kept.T, strict=True):
    print(f"  {name:<14} {values.min():6.2f} to {values.max():5.2f} rad")
nearest = kept[np.abs(kept - robot.home).max(axis=1).argmin()]
print("the solution nearest to home:", np.round(nearest, 2))
