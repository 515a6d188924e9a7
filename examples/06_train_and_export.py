"""Train a network for a robot, solve with it, and export it as one file of TorchScript.

Sizes are toys, so the answers are poor: with profile=quick in place of smoke it takes minutes.
"""

import numpy as np
import torch

from pipeline import load_robot, load_solver, run_command

SMALL = ["profile=smoke", "dataset.train=600", "dataset.validation=60", "dataset.test=60"]
RESULTS = "results/example"

run_command("train", ["robot=nico", f"results_dir={RESULTS}", *SMALL])

robot = load_robot("nico")
# The folder is all that is needed: weights.safetensors, and a card that says what made them.
solver = load_solver("cycleik", robot, weights=f"{RESULTS}/train/nico/tiny")
poses = robot.forward_kinematics(robot.sample(100, seed=0))
joints = solver.solve(poses).joints
reached = robot.forward_kinematics(joints)
off = 1e3 * np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
print(f"trained for seconds: {off.mean():.0f} mm off on average")

inputs = torch.as_tensor(poses, dtype=torch.float32)
torch.jit.trace(solver.network, inputs).save("nico.pt")
again = torch.jit.load("nico.pt")(inputs)  # (N, hypotheses, dof); needs PyTorch and no more
difference = np.abs(again[:, 0].detach().numpy() - joints).max()
print(f"nico.pt answers the same to {difference:.1e} rad")
