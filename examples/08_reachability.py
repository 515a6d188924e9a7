"""A map of where a robot can grasp from above: a plane of poses, each solved and checked."""

import numpy as np

from pipeline import Budget, load_robot, load_solver

HEIGHT = 0.1  # m over the base
SIDE, CELLS = 0.9, 31  # m from the middle to the edge of the map; cells in a row
DOWN = (0.0, 1.0, 0.0, 0.0)  # qw qx qy qz: half a turn about x, so the tip's z axis points down

robot = load_robot("panda")
solver = load_solver("lm", robot)

line = np.linspace(-SIDE, SIDE, CELLS)
x, y = np.meshgrid(line[::-1], line[::-1], indexing="ij")
poses = np.array([(a, b, HEIGHT, *DOWN) for a, b in zip(x.ravel(), y.ravel(), strict=True)])
solution = solver.solve(poses, budget=Budget(iterations=500))

reached = solution.found
free = reached & ~robot.in_collision(solution.joints)
signs = np.select([free, reached], ["o", "x"], ".").reshape(CELLS, CELLS)
print(f"{robot.name}, tip down, {HEIGHT} m over the base, which is B; x goes up, y to the left")
signs[CELLS // 2, CELLS // 2] = "B"
for row in signs:
    print(" ".join(row))
print("o reached, x reached with a self-collision, . not found")
cell = (2 * SIDE / (CELLS - 1)) ** 2
print(f"{free.sum() * cell:.2f} m2 reached without a collision")
