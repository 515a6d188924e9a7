"""Inverse kinematics of a URDF file: python examples/01_my_urdf.py my.urdf base_link tool0."""

import sys

import numpy as np

from pipeline import load_robot, load_solver

PANDA = (load_robot("panda").urdf_path, "panda_link0", "panda_hand_tcp")  # where none is named

urdf, base, tip = sys.argv[1:4] or PANDA
robot = load_robot(urdf=urdf, base=base, tip=tip)
print(f"{robot.name}: {robot.dof} joints from {robot.base} to {robot.tip}")
for name, lower, upper in zip(robot.joint_names, robot.lower, robot.upper, strict=True):
    print(f"  {name:<20} {lower:7.3f} to {upper:6.3f}")

# A pose is x y z [m] and a unit quaternion qw qx qy qz in the frame of the base.
pose = robot.forward_kinematics(robot.sample(1, seed=0))[0]
solver = load_solver("lm", robot)
joints, found = solver.solve_one(pose, initial=robot.home)
reached = robot.forward_kinematics(joints)[0]
print("target ", np.round(pose, 3))
print("joints ", np.round(joints, 3), "found" if found else "not found")
print(f"the tip is {1e3 * np.linalg.norm(reached[:3] - pose[:3]):.4f} mm off")

poses = robot.forward_kinematics(robot.sample(1000, seed=1))
print(f"of 1,000 further poses {solver.solve(poses).found.sum()} are found")
