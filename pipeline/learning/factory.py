"""Networks and objectives made by what the configuration names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import torch
from torch import nn

from pipeline.learning.config import ModelConfig, TrainConfig
from pipeline.learning.networks import IkNetwork
from pipeline.learning.objective import Objective
from pipeline.learning.registry import config_class, imported, method_of, methods
from robots import Robot


def build_network(robot: Robot, model: ModelConfig) -> IkNetwork:
    """Return the network that ``model.kind`` names, with fresh weights."""
    network: IkNetwork = imported(method_of(model.kind).networks[model.kind])(robot, model)
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
            made: Objective = imported(objective)(robot, network, train, device, seed)
            return made
    raise TypeError(f"there is no training objective for a {type(network).__name__}")


def model_config(values: Mapping[str, Any]) -> ModelConfig:
    """Return the configuration of a network from the ``model`` group of a card or a search.

    Keys that networks of this kind do not have are left out: files of earlier versions hold those
    of all kinds.
    """
    group = config_class(str(values.get("kind", "")))
    known = {item.name for item in fields(group)}
    made: ModelConfig = group(**{name: v for name, v in values.items() if name in known})
    return made
