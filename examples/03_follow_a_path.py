"""Follow a path whose targets come every millisecond, and never let a joint jump."""

import time

import numpy as np

from pipeline import load_robot, load_solver

RATE_HZ = 1000
RADIUS, PERIOD_S = 0.08, 4.0  # a circle of the tip: m, s
MAX_JUMP = 0.01  # rad that a joint may move between two targets

robot = load_robot("panda")
solver = load_solver("lm", robot, max_jump=MAX_JUMP)

seconds = np.arange(0, PERIOD_S, 1 / RATE_HZ)
angle = 2 * np.pi * seconds / PERIOD_S
path = np.repeat(robot.forward_kinematics(robot.home), len(seconds), axis=0)
path[:, 1] += RADIUS * np.sin(angle)
path[:, 2] += RADIUS * (1 - np.cos(angle))

joints, followed, missed, spent = robot.home, [], 0, []
for pose in path:
    begin = time.perf_counter()
    answer, found = solver.solve_one(pose, initial=joints)
    spent.append(time.perf_counter() - begin)
    if found:
        joints = answer  # of a target that is missed the last joints are held
    missed += not found
    followed.append(joints)

steps = np.abs(np.diff(followed, axis=0)).max(axis=0)
off = np.linalg.norm(robot.forward_kinematics(followed)[:, :3] - path[:, :3], axis=1)
print(f"{len(path)} targets, {missed} missed, at most {1e3 * off.max():.3f} mm off")
print(f"largest step of a joint {steps.max():.4f} rad, allowed {MAX_JUMP} rad")
print(f"a target takes {1e6 * np.median(spent):.1f} us (median) of 1,000 us")
