"""Networks and objectives made by what the configuration names."""

from __future__ import annotations

from importlib import import_module
from typing import Any

import torch
from torch import nn

from pipeline.learning.networks import IkNetwork
from pipeline.learning.objective import Objective
from pipeline.learning.registry import method_of, methods
from pipeline.settings import ModelConfig, TrainConfig
from robots import Robot


def build_network(robot: Robot, model: ModelConfig) -> IkNetwork:
    """Return the network that ``model.kind`` names, with fresh weights."""
    network: IkNetwork = _imported(method_of(model.kind).networks[model.kind])(robot, model)
    return network


def make_objective(
    robot: Robot, network: nn.Module, train: TrainConfig, device: torch.device, seed: int = 0
) -> Objective:
    """Return the objective that a network of this class is trained for.

    Args:
        robot: Gives forward kinematics.
        network: The network, on the device.
        train: Losses and their weights.
        device: Where batches lie.
        seed: Root of the noise of objectives that draw some.

    Raises:
        TypeError: No method declares this class or one that it is derived from.
    """
    declared = {name: m.objective for m in methods().values() for name in m.networks.values()}
    for base in type(network).__mro__:
        objective = declared.get(f"{base.__module__}.{base.__qualname__}")
        if objective is not None:
            made: Objective = _imported(objective)(robot, network, train, device, seed)
            return made
    raise TypeError(f"there is no training objective for a {type(network).__name__}")


def _imported(name: str) -> Any:
    """The class of a dotted name."""
    module, _, attribute = name.rpartition(".")
    return getattr(import_module(module), attribute)
