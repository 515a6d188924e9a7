"""CycleIK as a solver: the network's best hypothesis, by a compiled kernel where it has one."""

from __future__ import annotations

from typing import Any, ClassVar

import numba
import numpy as np
from numpy.typing import NDArray

from baselines import SettingError
from pipeline.learning.cycleik import METHOD
from pipeline.learning.cycleik.compiled.answers import (
    CompiledExperts,
    answer_on_threads,
    answer_rows,
    compiled_experts,
)
from pipeline.learning.cycleik.compiled.query import refined_query
from pipeline.learning.cycleik.compiled.ranking import merge_ranked
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.solver import Hypotheses, NeuralSolver
from robots import Robot
from robots.arguments import as_int, compiled_floats
from robots.threads import forked

Array = NDArray[np.float64]

_TO_MM_AND_DEG = np.array([1e3, 180 / np.pi])


class CycleIk(NeuralSolver):
    """CycleIK: deterministic, the best hypothesis of one forward pass.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        cells: Of a network of experts, how many answer a pose: those of the nearest cells. Close
            to a border the neighbour may err less than the expert that has learned the pose.
        **settings: Tolerances and threads, see `NeuralSolver`.

    Raises:
        SettingError: The network has fewer experts, or none.
    """

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model

    def __init__(self, robot: Robot, weights: str, cells: int = 1, **settings: Any) -> None:
        super().__init__(robot, weights, **settings)
        experts = self.network if isinstance(self.network, Experts) else None
        most = 1 if experts is None else len(experts.centres)
        self.cells = as_int(cells, "cells", SettingError)
        if not 1 <= self.cells <= most:
            raise SettingError(f"expected cells from 1 to {most} with this network, got {cells}")
        self.compiled = None if experts is None else compiled_experts(experts)

    def hypotheses(self, poses: Array) -> Hypotheses:
        """Return the network's answers to poses (N, 7), best first."""
        if self.compiled is None:
            return super().hypotheses(poses)
        return self._compiled_hypotheses(poses, self.compiled)

    def refined_query(self, tried: int) -> tuple[Any, tuple[Any, ...]] | None:
        """See `NeuralSolver`."""
        if self.compiled is None or self.cells > 1:
            return None
        heads = self.network.heads
        ranking = self._ranking()
        return refined_query, (heads, min(tried, heads), ranking, self.robot.chain, self.compiled)

    def _ranking(self) -> Array:
        """(2,) what an error of 1 m and of 1 rad counts when hypotheses are compared."""
        tolerances = np.array([self.position_tolerance_mm, self.rotation_tolerance_deg])
        return 1 / tolerances * _TO_MM_AND_DEG

    def _compiled_hypotheses(self, poses: Array, experts: CompiledExperts) -> Hypotheses:
        """The same without torch."""
        shape = self.cells, len(poses), self.network.heads
        joints, errors = np.empty((*shape, self.robot.dof)), np.empty((*shape, 2))
        rows, ranking = compiled_floats(poses), self._ranking()
        for nearer in range(self.cells):
            arguments = (
                *(self.robot.chain, experts, rows, ranking),
                *(nearer, joints[nearer], errors[nearer]),
            )
            if self.threads == 1 or len(rows) == 1 or forked():
                answer_rows(*arguments)
            else:
                answer_on_threads(self.threads or numba.config.NUMBA_NUM_THREADS, *arguments)
        if self.cells == 1:
            joints, errors = joints[0], errors[0]
        else:
            joints, errors = merge_ranked(joints, errors, ranking)
        errors *= _TO_MM_AND_DEG
        return Hypotheses(joints, errors[..., 0], errors[..., 1])
