"""Which poses a training step sees: a function of seed and step, so that a run can be resumed."""

from __future__ import annotations

import torch
from torch import Tensor

from pipeline.seeding import derive_seed


class Batches:
    """Indices of the poses of each step: every epoch in an order of its own.

    The order follows from the seed and the epoch alone, so a resumed run draws what an
    uninterrupted one draws.

    Args:
        count: Poses in the set.
        size: Poses a step; a last, smaller batch is left out.
        seed: Root of the orders.
        device: Where the indices are wanted. They are drawn on the CPU: the same on every device.
    """

    def __init__(
        self, count: int, size: int, seed: int, device: torch.device | str = "cpu"
    ) -> None:
        self.count, self.size, self.seed, self.device = count, size, seed, device
        self.per_epoch = count // size
        self._epoch = -1
        self._order = torch.empty(0, dtype=torch.long)

    def indices(self, step: int) -> Tensor:
        """Return the indices (size,) of a step."""
        epoch, place = divmod(step, self.per_epoch)
        if epoch != self._epoch:
            self._order = self.epoch(epoch).to(self.device)
            self._epoch = epoch
        return self._order[place * self.size : (place + 1) * self.size]

    def epoch(self, number: int) -> Tensor:
        """Return the order (count,) in which an epoch goes through the set, on the CPU."""
        generator = torch.Generator().manual_seed(derive_seed(self.seed, "epoch", number))
        return torch.randperm(self.count, generator=generator)
