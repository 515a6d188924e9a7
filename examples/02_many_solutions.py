"""Many solutions of one pose, free of self-collision, and how far apart they are."""

import numpy as np

from pipeline import load_robot, load_solver

COUNT = 200
APART = 0.1  # rad; solutions that are nearer in every joint count as one

robot = load_robot("panda")
solver = load_solver("lm", robot)
pose = robot.forward_kinematics(robot.sample(1, seed=3))[0]

# Seven joints and six numbers in a pose: there are infinitely many, here the first that differ.
found = solver.solve_all(pose, COUNT, apart=APART, initial=robot.home)
kept = found[~robot.in_collision(found)]
print(f"{len(found)} solutions differ by {APART} rad, {len(kept)} of them are free of collision")
reached = robot.forward_kinematics(kept)
print(f"largest distance to the target: {1e3 * np.abs(reached - pose)[:, :3].max():.4f} mm")
for name, values in zip(robot.joint_names, kept.T, strict=True):
    print(f"  {name:<14} {values.min():6.2f} to {values.max():5.2f} rad")
print("the solution nearest to home:", np.round(kept[0], 2))
