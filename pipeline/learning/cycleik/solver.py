"""CycleIK as a solver: the network's best hypothesis, by a compiled kernel where it has one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines import Budget, SettingError, Solution
from baselines.compiled_query import CompiledQuery, CompiledQuerySolver
from baselines.joint_range import joint_range
from baselines.lm_kernel import OUT_OF_REACH
from baselines.refine import REASONS, thread_count
from pipeline.learning.cycleik import METHOD
from pipeline.learning.cycleik.compiled.answers import (
    CompiledExperts,
    answer_on_threads,
    compiled_experts,
    seed_rows,
)
from pipeline.learning.cycleik.compiled.query import (
    DEG,
    MM,
    NOT_PRECISE,
    NOT_THERE,
    PROOF_M,
    PROOF_RAD,
    NetworkOptions,
    network_query,
    refined_query,
)
from pipeline.learning.cycleik.compiled.ranking import merge_ranked
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.solver import NOT_PRECISE as OUTSIDE
from pipeline.learning.solver import Hypotheses, NeuralSolver
from robots import Robot
from robots.arguments import as_int, compiled_floats
from robots.pose_bound import pose_bound, proven_rows
from robots.suggestions import unknown_name

Array = NDArray[np.float64]

AUTO, FLOAT32, FLOAT64 = PRECISIONS = "auto", "float32", "float64"
_TO_MM_AND_DEG = np.array([MM, DEG])


class CycleIk(NeuralSolver, CompiledQuerySolver[NetworkOptions]):
    """CycleIK: deterministic, the best hypothesis of one forward pass.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        cells: Of a network of experts, how many answer a pose: those of the nearest cells. Close
            to a border the neighbour may err less than the expert that has learned the pose.
        precision: In which the layers compute, float32 or float64. auto takes float64 for a network
            of experts, which a file that is exported agrees with to 1e-8, and float32 for a network
            of millions of parameters, which takes three times as long in float64.
        **settings: Tolerances and threads, see `NeuralSolver`.

    Raises:
        SettingError: The network has fewer experts, or none; or there is no such precision.
    """

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
    reasons: ClassVar[Mapping[int, str]] = {
        0: "",
        NOT_PRECISE: OUTSIDE,
        NOT_THERE: REASONS[OUT_OF_REACH],
    }
    # A descent needs no more of its seeds.
    as_proposer: ClassVar[Mapping[str, Any]] = {"precision": "float32"}

    def __init__(
        self, robot: Robot, weights: str, cells: int, precision: str, **settings: Any
    ) -> None:
        super().__init__(robot, weights, **settings)
        experts = self.network if isinstance(self.network, Experts) else None
        most = 1 if experts is None else len(experts.centres)
        self.cells = as_int(cells, "cells", SettingError)
        if not 1 <= self.cells <= most:
            raise SettingError(f"expected cells from 1 to {most} with this network, got {cells}")
        if precision not in PRECISIONS:
            raise SettingError(unknown_name("precision", precision, PRECISIONS))
        self.precision = precision if precision != AUTO else FLOAT32 if experts is None else FLOAT64
        if experts is None and self.precision == FLOAT64:
            self.network.double()
        self.compiled = None if experts is None else compiled_experts(experts, self.precision)

    def hypotheses(self, poses: Array) -> Hypotheses:
        """Return the network's answers to poses (N, 7), best first."""
        if self.compiled is None:
            return super().hypotheses(poses)
        return self._compiled_hypotheses(poses, self.compiled)

    def options(self, budget: Budget | None) -> NetworkOptions:
        """See `CompiledQuerySolver`: tolerances as they are now; there is no budget."""
        return NetworkOptions(float(self.position_tolerance_mm), float(self.rotation_tolerance_deg))

    def compile_query(self, options: NetworkOptions) -> CompiledQuery | None:
        """See `CompiledQuerySolver`."""
        if self.compiled is None or self.cells > 1:
            return None
        robot = self.robot
        bound = joint_range(robot), robot.chain, self.compiled, pose_bound(robot)
        return CompiledQuery(network_query, options, robot.dof, *bound)

    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        """See `Solver`: a pose that a bound proves to have no configuration is not found."""
        solution = super()._solve_batch(poses, initial, budget)
        proven = np.zeros(len(poses), dtype=bool)
        proven_rows(pose_bound(self.robot), compiled_floats(poses), PROOF_M, PROOF_RAD, proven)
        if not proven.any():
            return solution
        reason = np.array(solution.reason, dtype=object)
        reason[proven] = self.reasons[NOT_THERE]
        return replace(solution, found=solution.found & ~proven, reason=tuple(reason.tolist()))

    def _options_now(self) -> NetworkOptions:
        return self.options(None)

    def refined_query(self, tried: int) -> tuple[Any, tuple[Any, ...]] | None:
        """See `NeuralSolver`."""
        if self.compiled is None or self.cells > 1:
            return None
        tried = min(tried, self.network.heads)
        return refined_query, (tried, self._ranking(), self.robot.chain, self.compiled)

    def seeding(self, poses: Array, seeds: Array) -> Callable[[slice], None] | None:
        """See `NeuralSolver`."""
        if self.compiled is None or self.cells > 1 or seeds.shape[1] > self.network.heads:
            return None
        network = self.robot.chain, self.compiled
        ranking, home = self._ranking(), self.robot.home
        return lambda rows: seed_rows(*network, poses[rows], ranking, home, seeds[rows])

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
            network = self.robot.chain, experts, rows, ranking
            room = nearer, joints[nearer], errors[nearer]
            answer_on_threads(thread_count(self.threads), *network, *room)
        if self.cells == 1:
            joints, errors = joints[0], errors[0]
        else:
            joints, errors = merge_ranked(joints, errors, ranking)
        errors *= _TO_MM_AND_DEG
        return Hypotheses(joints, errors[..., 0], errors[..., 1])
