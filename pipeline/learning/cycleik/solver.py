"""CycleIK as a solver: the network's best hypothesis, by a compiled kernel where it has one."""

from __future__ import annotations

from typing import Any, ClassVar

import numba
import numpy as np
from numpy.typing import NDArray

from pipeline.learning.cycleik import METHOD
from pipeline.learning.cycleik.compiled.answers import (
    CompiledExperts,
    answer_on_threads,
    answer_rows,
    compiled_experts,
)
from pipeline.learning.cycleik.compiled.query import refined_query
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.solver import Hypotheses, NeuralSolver
from robots import Robot
from robots.arguments import compiled_floats
from robots.threads import forked

_TO_MM_AND_DEG = np.array([1e3, 180 / np.pi])


class CycleIk(NeuralSolver):
    """CycleIK: deterministic, the best hypothesis of one forward pass.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        **settings: Tolerances and threads, see `NeuralSolver`.
    """

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model

    def __init__(self, robot: Robot, weights: str, **settings: Any) -> None:
        super().__init__(robot, weights, **settings)
        self.compiled = (
            compiled_experts(self.network) if isinstance(self.network, Experts) else None
        )

    def hypotheses(self, poses: NDArray[np.float64]) -> Hypotheses:
        """Return the network's answers to poses (N, 7), best first."""
        if self.compiled is None:
            return super().hypotheses(poses)
        return self._compiled_hypotheses(poses, self.compiled)

    def refined_query(self, tried: int) -> tuple[Any, tuple[Any, ...]] | None:
        """See `NeuralSolver`."""
        if self.compiled is None:
            return None
        heads = self.network.heads
        ranking = self._ranking()
        return refined_query, (heads, min(tried, heads), ranking, self.robot.chain, self.compiled)

    def _ranking(self) -> NDArray[np.float64]:
        """(2,) what an error of 1 m and of 1 rad counts when hypotheses are compared."""
        tolerances = np.array([self.position_tolerance_mm, self.rotation_tolerance_deg])
        return 1 / tolerances * _TO_MM_AND_DEG

    def _compiled_hypotheses(
        self, poses: NDArray[np.float64], experts: CompiledExperts
    ) -> Hypotheses:
        """The same without torch."""
        count, heads = len(poses), self.network.heads
        joints = np.empty((count, heads, self.robot.dof))
        errors = np.empty((count, heads, 2))
        arguments = (
            self.robot.chain,
            experts,
            compiled_floats(poses),
            self._ranking(),
            joints,
            errors,
        )
        if self.threads == 1 or count == 1 or forked():
            answer_rows(*arguments)
        else:
            answer_on_threads(self.threads or numba.config.NUMBA_NUM_THREADS, *arguments)
        errors *= _TO_MM_AND_DEG
        return Hypotheses(joints, errors[..., 0], errors[..., 1])
