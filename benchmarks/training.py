"""How fast the training loop is on this machine, beside a plain one and beside its matrix products.

    python benchmarks/training.py [--models compact ...] [--robots panda ...] [--rounds 7]

The project is to be installed (`pip install -e .`). In turns, within one run, it times

- steps of the trainer with the settings of conf/train (and of Table I for the model `paper`);
- steps of a plain eager loop on the same batches: float32, autograd through pytorch-kinematics,
  Adam tensor by tensor, the loss read after every step; losses and network are the same;
- a large float32 matrix product, as PyTorch computes it by default and by the faster of its
  libraries that does not round, and a sum of two large arrays: what this machine can do at best.

Prints a Markdown table with a row for each robot and model: samples per second of both loops and
their ratio; the share of the faster product's rate (`peak`) that the trainer's step reaches with
its linear layers alone, the share of it that memory leaves, and the share of the default product's
rate. Memory: every weight is read for the forward and the backward pass and its gradient written
beside the products, then the norm of the gradient and Adam move 32 bytes a weight. Small batches
spend more on that than on products. Each figure is a median over rounds, and ratios are medians of
the ratios within a round, so that load from elsewhere falls on both sides. A figure that misses its
limit is marked with `!`.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median

import torch
from torch import Tensor, nn

from pipeline.config import compose, group_choices
from pipeline.data.dataset import PoseSet
from pipeline.learning.checkpoint import Progress
from pipeline.learning.factory import build_network, make_objective
from pipeline.learning.networks import parameter_count
from pipeline.learning.null_space.network import NullSpaceGenerator
from pipeline.learning.precision import matmul_precision
from pipeline.learning.trainer import Trainer, TrainingRun
from pipeline.settings import Config
from robots import Robot, available_robots, load_robot

SEED = 0
MATRIX = 2048
ROUND_S = 1.0  # of each of the three in a round
POSES = 20_000
TOTAL_STEPS = 100_000
# Limits: gain over the plain loop, and share of the rate of matrix products.
GAIN_LIMIT, GAIN_MODELS = 1.5, ("compact",)
SHARE_LIMIT, SHARE_MODELS = 0.5, ("paper",)
BESIDE, AFTER = 12, 32  # bytes a weight: read twice and its gradient written; norm 4, Adam 28
ARRAY = 2**24  # float32 numbers, more than caches hold
HEAD = (
    "| robot | model | parameters | batch | trainer /s | plain /s | gain | share of peak "
    "| memory leaves | share of default |"
)


class Plain:
    """The loop that one would write first.

    Args:
        robot: The robot.
        config: Names the losses; optimiser and kinematics are this loop's own.
        network: The network that it trains.
    """

    def __init__(self, robot: Robot, config: Config, network: nn.Module) -> None:
        train = replace(config.train, kinematics="pytorch_kinematics")
        self.objective = make_objective(robot, network, train, torch.device("cpu"), SEED)
        self.optimizer = torch.optim.Adam(
            network.parameters(), lr=train.learning_rate, foreach=False, fused=False
        )
        self.losses: list[float] = []

    def step(self, poses: Tensor, joints: Tensor) -> None:
        """One step on poses (N, 7) that were made from joints (N, dof)."""
        self.optimizer.zero_grad()
        loss = self.objective.loss(poses, joints, len(self.losses), 0.0)
        loss.backward()
        self.optimizer.step()
        self.losses.append(loss.item())


def rate(call: Callable[[], object], seconds: float) -> float:
    """Calls per second over about as many seconds, at least two calls."""
    count, start = 0, time.perf_counter()
    while count < 2 or time.perf_counter() - start < seconds:
        call()
        count += 1
    return count / (time.perf_counter() - start)


def config_of(robot: str, model: str) -> Config:
    profile = "paper" if model.startswith("paper") else "quick"
    return compose([f"robot={robot}", f"profile={profile}", f"model={model}", "train.device=cpu"])


def layer_operations(network: nn.Module, rows: int) -> float:
    """Operations of the linear layers in a step: forward, and backward to weights and inputs.

    The first layer needs no gradient of its input. Networks without such layers count as zero.

    Args:
        network: The network.
        rows: Answers in a step: poses of a batch, times the answers that each of them gets.
    """
    layers = [module.weight for module in network.modules() if isinstance(module, nn.Linear)]
    if not layers:
        return 0.0
    return 2.0 * rows * (3 * sum(weight.numel() for weight in layers) - layers[0].numel())


def measure(robot: Robot, model: str, rounds: int) -> str:
    """One row of the table."""
    config = config_of(robot.name, model)
    batch = config.train.batch_size
    joints = robot.sample(POSES, seed=SEED, collision_free=False)
    torch.manual_seed(SEED)
    networks = [build_network(robot, config.model) for _ in range(2)]
    trainer = Trainer(robot, networks[0], config.train, TrainingRun(SEED, "", "benchmark"))
    plain = Plain(robot, config, networks[1])
    data = PoseSet(robot.forward_kinematics(joints), joints)
    poses, made_from = trainer.tensor(data.poses), trainer.tensor(data.joints)
    for network in networks:
        network.prepare(poses)
    progress = Progress()
    left, right = torch.randn(MATRIX, MATRIX), torch.randn(MATRIX, MATRIX)
    first, second, total = (torch.zeros(ARRAY) for _ in range(3))

    def chosen() -> Tensor:
        return torch.randint(POSES, (batch,))

    def ours() -> None:
        rows = chosen()
        trainer.step(poses[rows], made_from[rows], progress, TOTAL_STEPS)

    def theirs() -> None:
        rows = chosen()
        plain.step(poses[rows], made_from[rows])

    def product() -> None:
        with matmul_precision(trainer.products.forward):
            torch.matmul(left, right)

    def default_product() -> None:
        torch.matmul(left, right)

    def transfer() -> None:
        torch.add(first, second, out=total)

    calls = (ours, theirs, product, transfer, default_product)
    for call in calls:
        rate(call, 0.2)
    turns = [[rate(call, ROUND_S) for call in calls] for _ in range(rounds)]
    gain = median(own / other for own, other, *_ in turns)
    answers = config.train.variance_samples if isinstance(networks[0], NullSpaceGenerator) else 1
    operations = layer_operations(networks[0], batch * answers)
    weights = parameter_count(networks[0])
    shares, limits, of_default = [], [], []
    for own, _, products, transfers, default in turns:
        computed_s = operations / (products * 2.0 * MATRIX**3)
        of_default.append(own * operations / (default * 2.0 * MATRIX**3))
        weight_s = weights / (transfers * 3 * 4 * ARRAY)
        shares.append(own * computed_s)
        limits.append(computed_s / (max(computed_s, BESIDE * weight_s) + AFTER * weight_s))
    share, limit = median(shares), median(limits)
    missed = (
        model in GAIN_MODELS and gain < GAIN_LIMIT,
        model in SHARE_MODELS and share < SHARE_LIMIT,
    )
    cells = [
        robot.name,
        model,
        f"{weights:,}",
        str(batch),
        *(f"{batch * median(turn[side] for turn in turns):,.0f}" for side in (0, 1)),
        f"{gain:.2f}{' !' if missed[0] else ''}",
        f"{share:.2f}{' !' if missed[1] else ''}" if operations else "–",
        f"{limit:.2f}" if operations else "–",
        f"{median(of_default):.2f}" if operations else "–",
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--models", nargs="+", default=group_choices("model"))
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument("--rounds", type=int, default=7)
    options = parser.parse_args()
    print(
        f"{torch.get_num_threads()} threads; limits: gain {GAIN_LIMIT} ({', '.join(GAIN_MODELS)}), "
        f"share {SHARE_LIMIT} ({', '.join(SHARE_MODELS)})\n\n{HEAD}\n" + "|---" * 10 + "|"
    )
    for model in options.models:
        for name in options.robots:
            print(measure(load_robot(name), model, options.rounds), flush=True)


if __name__ == "__main__":
    main()
