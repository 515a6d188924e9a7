"""Train a network for a robot, solve with it, and take it away: one file of TorchScript, one of C.

Sizes are toys, so the answers are poor: with profile=quick in place of smoke it takes minutes.
"""

import numpy as np
import torch

from pipeline import load_robot, load_solver, run_command

SMALL = ["profile=smoke", "dataset.train=600", "dataset.validation=60", "dataset.test=60"]
RESULTS = "results/example"
WEIGHTS = f"{RESULTS}/train/nico/tiny"

run_command("train", ["robot=nico", f"results_dir={RESULTS}", *SMALL])

robot = load_robot("nico")
# The folder is all that is needed: weights.safetensors, and a card that says what made them.
solver = load_solver("cycleik", robot, weights=WEIGHTS)
poses = robot.forward_kinematics(robot.sample(100, seed=0))
joints = solver.solve(poses).joints
reached = robot.forward_kinematics(joints)
off = 1e3 * np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
print(f"trained for seconds: {off.mean():.0f} mm off on average")

for target in ("torchscript", "c"):  # to=onnx needs: pip install 'cycleik-bench[export]'
    run_command("export", ["robot=nico", f"to={target}", f"weights={WEIGHTS}"])
again = torch.jit.load("nico_ik.pt")(torch.as_tensor(poses))[0]  # (N, dof); needs PyTorch alone
difference = np.abs(again.numpy() - joints).max()
print(f"nico_ik.pt answers the same to {difference:.1e} rad")
