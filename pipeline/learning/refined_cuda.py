"""Refined CycleIK on a CUDA device: the network's hypotheses never leave it."""

from __future__ import annotations

from typing import Any

import numpy as np

from baselines.lm_cuda import DeviceAnswers, LmCuda
from baselines.lm_kernel import LmOptions
from baselines.refine import Refined
from baselines.seed_library import SeedLibrary
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.networks import IkNetwork
from robots import Robot

RANKED = 16  # hypotheses that are sorted at most


class RefinedCuda:
    """A network's hypotheses and the descents from them, both on the device.

    Where a block works at a pose, its threads start from all hypotheses and from remembered
    configurations at once; where a thread does, it starts from the best hypotheses first.

    Args:
        robot: The robot.
        network: Its network.
        options: Of the descents, see `LmCuda`.
        library: Configurations to start from after the hypotheses.
        hypotheses: The best ones that a thread with a pose of its own tries.
        position_weight: Of an error in m when hypotheses are compared.
        rotation_weight: Of an error in rad.
        **settings: Other settings of `LmCuda`.

    Raises:
        SettingError: A setting that is none, or there is no device.
    """

    def __init__(
        self,
        robot: Robot,
        network: IkNetwork,
        options: LmOptions,
        library: SeedLibrary | None = None,
        hypotheses: int = 1,
        position_weight: float = 100.0,
        rotation_weight: float = 9 / np.pi,
        **settings: Any,
    ) -> None:
        self.lm = LmCuda(robot, options, library, **settings)
        self.tried = min(hypotheses, network.heads)
        self.heads = min(network.heads, RANKED)
        self._weights = position_weight, rotation_weight
        self._seeds: dict[int, Any] = {}
        self._seeder = self._hypotheses  # one object, by which recorded launches are known
        self._experts: Any = None
        if isinstance(network, Experts):
            from pipeline.learning.cycleik.experts_cuda import DeviceExperts

            self._experts = DeviceExperts(network)
        else:
            self._network = network.to("cuda").eval()

    def solve(self, poses: Any) -> Refined:
        """Solve poses (N, 7) on the host or on the device and bring the answers to the host."""
        return self.lm.solve(poses, self._seeder)

    def solve_on_device(self, poses: Any) -> DeviceAnswers:
        """Start solving poses (N, 7), N > 0; see `LmCuda.solve_on_device`."""
        return self.lm.solve_on_device(poses, self._seeder)

    def _hypotheses(self, targets: Any) -> tuple[Any, int]:
        """Seeds (N, K, dof) for targets, all on the device, and how many a lane tries."""
        count = len(targets)
        if self._experts is None:
            seeds = self._answers(targets)
        else:
            if count not in self._seeds:
                if len(self._seeds) >= 16:
                    self._seeds.clear()
                self._seeds[count] = self.lm.new_array((count, self.heads, self.lm.dof))
            seeds = self._seeds[count]
            self._experts.answer(targets, seeds, self.lm.launch, self.lm.blocks_for(count))
        if self.lm.mapping_for(count) == "lane":
            self.lm.rank(targets, seeds, *self._weights)
            return seeds, self.tried
        return seeds, self.heads

    def _answers(self, targets: Any) -> Any:
        import torch

        with torch.inference_mode():
            poses = torch.as_tensor(targets, device="cuda")
            answers = self._network(poses.to(torch.float32))
            return answers[:, : self.heads].double().contiguous()
