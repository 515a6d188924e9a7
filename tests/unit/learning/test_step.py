"""The step that can be captured needs no decision of the host, and decides alike."""

from __future__ import annotations

from typing import Any

import pytest
import torch
from torch.utils._python_dispatch import TorchDispatchMode

from pipeline.config import compose
from pipeline.learning.checkpoint import Progress
from pipeline.learning.cycleik.mlp import CycleIkMlp
from pipeline.learning.factory import build_network
from pipeline.learning.step import BranchlessStep, EagerStep, TrainState, is_captured
from pipeline.learning.trainer import Trainer, TrainingError, TrainingRun
from pipeline.settings import Config
from robots import Robot, load_robot

SIZE, STEPS = 40, 25
SMALL = [
    "profile=smoke",
    "model=tiny",
    f"train.batch_size={SIZE}",
    "train.kinematics=products",
    "train.device=cpu",
]
CPU, CUDA = torch.device("cpu"), torch.device("cuda")


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("nico")


@pytest.fixture(scope="module")
def batches(robot: Robot) -> tuple[torch.Tensor, torch.Tensor]:
    joints = robot.sample(SIZE * STEPS, seed=2, collision_free=False)
    poses = robot.forward_kinematics(joints)
    shape = (STEPS, SIZE, -1)
    return tuple(torch.as_tensor(v, dtype=torch.float32).reshape(shape) for v in (poses, joints))


class HostSync(Exception):  # noqa: N818 - what a captured step must not do
    """A number left its device, or a tensor was made of numbers of the host."""


class Watched(TorchDispatchMode):
    """Refuses what a CUDA graph refuses."""

    REFUSED = ("_local_scalar_dense", "nonzero", "lift_fresh", "masked_select", "equal.default")

    def __torch_dispatch__(
        self, func: Any, types: Any, args: Any = (), kwargs: Any = None
    ) -> object:
        if any(name in str(func) for name in self.REFUSED):
            raise HostSync(str(func))
        return func(*args, **(kwargs or {}))


def made(robot: Robot, kind: type, *overrides: str) -> tuple[EagerStep | BranchlessStep, Trainer]:
    config: Config = compose([*SMALL, *overrides])
    torch.manual_seed(5)
    trainer = Trainer(
        robot, build_network(robot, config.model), config.train, TrainingRun(0, "", "step")
    )
    state = TrainState(
        trainer.objective,
        trainer.network,
        trainer.optimizer,
        trainer.products,
        config.train.max_gradient_norm,
    )
    return (BranchlessStep(state, SIZE) if kind is BranchlessStep else EagerStep(state)), trainer


def run(step: EagerStep | BranchlessStep, batches: Any, trainer: Trainer) -> Progress:
    progress = Progress()
    for poses, joints in zip(*batches, strict=True):
        step(poses, joints, progress, STEPS, trainer.learning_rate(progress.step, STEPS))
    step.flush(progress)
    return progress


@pytest.mark.parametrize(
    "options",
    [
        ["train.gradient_clip=1.0e+9"],
        ["train.gradient_clip=null"],
        ["train.gradient_clip=0.3", "train.weight_decay=0.1"],
        ["train.negate_input=true", "train.loss=former"],
        ["train.constraints=[{joints: [1, 2], posture: 0.1, weight: 3}]"],
    ],
)
def test_both_steps_train_alike(robot: Robot, batches: Any, options: list[str]) -> None:
    steps, trainers, runs = [], [], []
    for kind in (EagerStep, BranchlessStep):
        step, trainer = made(robot, kind, *options)
        steps.append(step)
        trainers.append(trainer)
        runs.append(run(step, batches, trainer))
    assert runs[0].loss_steps == runs[1].loss_steps == STEPS
    assert runs[1].loss_sum == pytest.approx(runs[0].loss_sum, rel=1e-4)
    for one, other in zip(*(made.network.parameters() for made in trainers), strict=True):
        torch.testing.assert_close(other, one, rtol=1e-3, atol=1e-5)


def test_a_bad_gradient_changes_nothing_and_is_counted(robot: Robot, batches: Any) -> None:
    poses, joints = (part[:4].clone() for part in batches)
    poses[1::2, 0, 0] = torch.nan
    step, trainer = made(robot, BranchlessStep, "train.weight_decay=0.1")
    progress = run(step, (poses, joints), trainer)
    assert (progress.loss_steps, progress.skipped, progress.step) == (2, 2, 4)
    assert all(torch.isfinite(p).all() for p in trainer.network.parameters())
    good, other = made(robot, BranchlessStep, "train.weight_decay=0.1")
    alone = Progress()
    for index in (0, 2):
        rate = other.learning_rate(index, STEPS)
        good(poses[index], joints[index], alone, STEPS, rate)
    for one, second in zip(trainer.network.parameters(), other.network.parameters(), strict=True):
        assert torch.equal(one, second)


def test_nothing_in_it_needs_the_host(robot: Robot, batches: Any) -> None:
    step, _ = made(robot, BranchlessStep, "train.negate_input=true")
    poses, joints = batches
    progress = Progress()
    step(poses[0], joints[0], progress, STEPS, 1e-3)
    assert isinstance(step, BranchlessStep)
    with Watched():
        step._body()
    eager, _ = made(robot, EagerStep)
    with pytest.raises(HostSync), Watched():
        eager(poses[0], joints[0], Progress(), STEPS, 1e-3)


def test_only_what_can_be_captured_is(robot: Robot) -> None:
    def requested(device: torch.device, *overrides: str) -> bool:
        config = compose(["profile=smoke", "model=tiny", *overrides])
        return is_captured(config.train, build_network(robot, config.model), device)

    config = compose(["profile=smoke", "model=tiny"])
    assert isinstance(build_network(robot, config.model), CycleIkMlp)
    assert requested(CUDA) and requested(CUDA, "train.step=captured")
    assert not requested(CUDA, "train.step=eager")
    assert not requested(CPU)
    assert not requested(CUDA, "model=compact")
    assert not requested(CUDA, "train.kinematics=pytorch_kinematics")
    with pytest.raises(TrainingError, match=r"captured needs a CUDA device .*use auto or eager"):
        requested(CPU, "train.step=captured")
    with pytest.raises(TrainingError, match="one shape for every batch"):
        requested(CUDA, "train.step=captured", "model=compact")


def test_compiled_kinematics_are_refused_where_they_cannot_run(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.learning.trainer.pick_device", lambda name: CUDA)
    config = compose(["profile=smoke", "model=tiny", "train.kinematics=compiled"])
    with pytest.raises(TrainingError, match=r"compiled runs on the CPU, .* cuda: use auto"):
        Trainer(robot, build_network(robot, config.model), config.train, TrainingRun(0, "", "step"))
