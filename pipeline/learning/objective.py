"""What a trainer needs of an objective, and what a step captured as a CUDA graph needs."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from torch import Tensor

ERRORS_BATCH = 4096  # poses of a forward pass when errors are measured


class Objective(Protocol):
    """What the trainer minimises. Noise, if any, follows from a seed and the step alone.

    Made of robot, network, `TrainConfig`, device and seed.
    """

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """Return the scalar loss of a batch.

        Args:
            poses: (N, 7) targets, metres and unit quaternions, scalar first.
            joints: (N, dof) rad or m, the joints that the poses were made from.
            step: Steps done so far.
            done: The same as a share of the run, in [0, 1).
        """

    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return errors (N,) in mm and deg of a solver's answers to poses (N, 7)."""


@runtime_checkable
class CapturableObjective(Protocol):
    """An objective whose loss is a function of tensors alone, for networks of one shape."""

    def network_input(self, poses: Tensor, step: int) -> Tensor:
        """Return what the network sees of poses (N, 7) in a step."""

    def loss_of(self, network_input: Tensor, poses: Tensor) -> Tensor:
        """Return the scalar loss of what the network sees (N, 7) against poses (N, 7)."""
