"""Plan a Bezier motion of the tip and draw it: five postures over each other in motion.png."""

import numpy as np

from pipeline import load_robot, load_solver, plan_motion
from robots.picture import draw_overlay

robot = load_robot("panda")
solver = load_solver("lm", robot)

start = robot.forward_kinematics(robot.home)[0]
target = start.copy()
target[:3] += [0.10, 0.45, -0.15]  # m, base frame
above = np.array([0.0, 0.0, 0.35])  # m, the inner control points lift the path
control_points = [start[:3] + above, target[:3] + above]

for _ in range(2):  # the first call compiles, once on a machine
    motion = plan_motion(
        robot, solver, None, target, control_points, steps=50, start_joints=robot.home
    )
print(f"{motion.found.sum()} of 50 waypoints found in {1e3 * motion.time_s:.1f} ms")
print(f"the tip is at most {motion.tip_error_mm.max():.3f} mm off its path")
print(f"largest step of a joint {motion.largest_step:.3f} rad, {motion.flips} branch flips")
print(f"motion.joints {motion.joints.shape} are what a controller needs")

draw_overlay(robot, motion.joints[::12]).save("motion.png")
