"""The network of the paper."""

from __future__ import annotations

from typing import ClassVar

import torch
from torch import Tensor

from pipeline.learning.config import ModelConfig
from pipeline.learning.networks import POSE_SIZE, GeluTanhLayers, IkNetwork
from robots import Robot


class CycleIkMlp(IkNetwork):
    """Fully connected, GELU layers, then tanh layers (figure 1 of the paper).

    Args:
        robot: The robot.
        model: Neurons of each hidden layer and the number of tanh layers, output included.
    """

    capturable: ClassVar[bool] = True
    roundable: ClassVar[bool] = True

    def __init__(self, robot: Robot, model: ModelConfig) -> None:
        super().__init__(robot, heads=1)
        self.layers = GeluTanhLayers([POSE_SIZE, *model.hidden, robot.dof], model.tanh_layers)

    def normalised(self, position: Tensor, quaternion: Tensor) -> Tensor:
        """See `IkNetwork.normalised`."""
        output: Tensor = self.layers(torch.cat((position, quaternion), dim=1))
        return output
