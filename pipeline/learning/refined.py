"""A network's hypotheses as seeds of the compiled Levenberg-Marquardt kernel."""

from __future__ import annotations

import math
import time
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import NDArray

import baselines
from baselines import Budget, SettingError, Solution
from baselines.abilities import AVOID, FOLLOW
from baselines.avoid import refine_avoiding
from baselines.compiled_query import CompiledQuery
from baselines.following import FollowingSolver
from baselines.joint_range import joint_range
from baselines.kernel_abilities import KernelAbilities
from baselines.lm import LevenbergMarquardt
from baselines.lm_kernel import LmOptions
from baselines.refine import Refined, merged, refine
from baselines.refine_torch import refine_place, refine_torch
from baselines.registry import settings, solver_class
from baselines.seed_library import LIBRARY_SEED, SeedLibrary, build_seed_library
from pipeline.learning.solver import Hypotheses, NeuralSolver
from robots import Obstacles, Robot
from robots.pose_bound import pose_bound
from robots.suggestions import unknown_name

POSITION, ROTATION = "position_tolerance_m", "rotation_tolerance_rad"


class RefinedSolver(KernelAbilities, FollowingSolver):
    """The best hypotheses of a neural solver, each refined to the tolerances of `lm`.

    Then come the nearest configurations of the seed library and random restarts. An initial guess
    that is given comes before the hypotheses, so that a motion stays on its branch of solutions;
    without one the best hypothesis is the first seed.

    Args:
        robot: The robot it solves for.
        proposer: Name of the neural solver whose hypotheses are refined.
        weights: Folder of weights.safetensors and card.json for the proposer.
        hypotheses: Hypotheses tried first.
        seed_library: Random configurations that are remembered with their poses; 0 for none.
        neighbours: Of these, the nearest that are tried next, before random configurations.
        device: Where the refinement runs: cpu is the compiled kernel, cuda its twin in torch, auto
            takes an accelerator where there is one.
        threads: Threads of the network and of the kernel; 0 leaves torch as it is, and takes all of
            numba's.
        time_s: Wall-clock budget per pose of the refinement where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
        **further: Other settings of the proposer; where left out, those of its YAML hold.

    Attributes:
        proposer: The neural solver.
        kernel: The solver `lm`, whose damping and motion in the null space are used, and whose
            tolerances unless the proposer's are tighter.

    Raises:
        SettingError: The proposer is not a neural solver, or has no such setting.
    """

    requires: ClassVar[tuple[str, ...]] = ("torch",)
    abilities: ClassVar[frozenset[str]] = KernelAbilities.abilities | {AVOID, FOLLOW}

    def __init__(
        self,
        robot: Robot,
        proposer: str,
        weights: str,
        hypotheses: int,
        seed_library: int,
        neighbours: int,
        device: str,
        threads: int,
        time_s: float | None,
        iterations: int | None,
        **further: Any,
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        self.proposer = _neural(proposer, robot, weights=weights, threads=threads, **further)
        self.tried = hypotheses
        self.library = build_seed_library(robot, seed_library, neighbours, LIBRARY_SEED)
        place = refine_place(robot, device, "float64")
        self.accelerator = place if place.device.type == "cuda" else None
        # What the proposer would not call found, this solver does not either.
        own, known = self.proposer, settings("lm")
        distance = min(float(known[POSITION]), own.position_tolerance_mm / 1e3)
        angle = min(float(known[ROTATION]), math.radians(own.rotation_tolerance_deg))
        tolerances = {POSITION: distance, ROTATION: angle}
        kernel = baselines.load("lm", robot, time_s=time_s, iterations=iterations, **tolerances)
        assert isinstance(kernel, LevenbergMarquardt)
        self.kernel, self.null_space = kernel, kernel.null_space

    @property
    def threads(self) -> int:
        """Threads of the network and of the kernel."""
        return self.proposer.threads

    @threads.setter
    def threads(self, count: int) -> None:
        self.proposer.threads = count

    @property
    def position_tolerance_mm(self) -> float:
        """Position error against which the proposer ranks its hypotheses."""
        return self.proposer.position_tolerance_mm

    @property
    def rotation_tolerance_deg(self) -> float:
        """Rotation error against which it ranks them."""
        return self.proposer.rotation_tolerance_deg

    def hypotheses(self, poses: NDArray[np.float64]) -> Hypotheses:
        """Return the proposer's answers to poses (N, 7), best first, before any refinement."""
        return self.proposer.hypotheses(poses)

    def proposals(self, poses: NDArray[np.float64], count: int) -> NDArray[np.float64]:
        """Return the best hypotheses (N, count, dof) of poses (N, 7) in the domain; one thread."""
        seeds = np.empty((len(poses), count, self.robot.dof))
        seeding = self.proposer.seeding(poses, seeds)
        if seeding is None:
            return self.hypotheses(poses).joints[:, :count]
        seeding(slice(None))
        return seeds

    def options(self, budget: Budget | None) -> LmOptions:
        """See `CompiledQuerySolver`: those of `lm`, by default under this solver's own budget."""
        return self.kernel.options(self.budget if budget is None else budget)

    def compile_query(self, options: LmOptions) -> CompiledQuery | None:
        """See `CompiledQuerySolver`; a proposer without a compiled network has none."""
        query = None if self.accelerator is not None else self.proposer.refined_query(self.tried)
        if query is None:
            return None
        function, arguments = query
        robot = self.robot
        bound = (joint_range(robot), robot.home, *arguments, self.library, pose_bound(robot))
        return CompiledQuery(function, options, robot.dof, *bound)

    def seed_memory(self) -> SeedLibrary:
        """See `KernelAbilities`."""
        return self.library

    def first_seeds(
        self, poses: NDArray[np.float64], initial: NDArray[np.float64] | None
    ) -> NDArray[np.float64]:
        """See `KernelAbilities`: the initial guess, then all hypotheses of the network."""
        answers = self.hypotheses(poses).joints
        return answers if initial is None else np.concatenate((initial[:, None], answers), axis=1)

    def _solve_unguided(self, poses: NDArray[np.float64], budget: Budget | None) -> Solution:
        return self._refined(poses, np.empty((len(poses), 0, self.robot.dof)), budget)

    def _solve_batch(
        self, poses: NDArray[np.float64], initial: NDArray[np.float64], budget: Budget | None
    ) -> Solution:
        return self._refined(poses, initial[:, None], budget)

    def _solve_avoiding(
        self,
        poses: NDArray[np.float64],
        initial: NDArray[np.float64] | None,
        budget: Budget | None,
        sets: list[Obstacles],
    ) -> Solution:
        """Descend from the initial guess, then from every hypothesis, the best first."""
        start = time.perf_counter()
        seeds = self.first_seeds(poses, initial)
        network_s = (time.perf_counter() - start) / len(poses)
        bound = self.options(budget), self.kernel.slide, self.library, sets
        refined = refine_avoiding(self.robot, poses, seeds, *bound)
        refined.time_s[:] += network_s
        return refined.solution()

    def _refined(
        self, poses: NDArray[np.float64], first: NDArray[np.float64], budget: Budget | None
    ) -> Solution:
        """Refine from the first seeds (N, 0 or 1, dof), then from the hypotheses.

        Poses outside the proposer's domain start as in `lm`: at home where there is no first seed.
        """
        if first.shape[1] == 0 and self.tried == 1 and self.accelerator is None:
            seeds = np.empty((len(poses), 1, self.robot.dof))
            seeding = self.proposer.seeding(poses, seeds)
            if seeding is not None:
                bound = self.options(budget), self.threads, self.library
                return refine(self.robot, poses, seeds, *bound, seeding=seeding).solution()
        inside = self.proposer.in_domain(poses)
        if inside.all():
            return self._proposed(poses, first, budget).solution()
        outside = ~inside
        start = first[outside]
        if start.shape[1] == 0:
            start = np.broadcast_to(self.robot.home, (len(start), 1, self.robot.dof))
        refined = self._descended(poses[outside], start, budget)
        if not inside.any():
            return refined.solution()
        proposed = self._proposed(poses[inside], first[inside], budget)
        return merged(inside, proposed, refined).solution()

    def _proposed(
        self, poses: NDArray[np.float64], first: NDArray[np.float64], budget: Budget | None
    ) -> Refined:
        """Refine from the first seeds, and where these do not lead to a solution, from hypotheses.

        A guess that does spares the network. Where it does not, its descent is made again among
        the others, so that an answer is the one that all seeds in their order give. Under a limit
        of time no descent is made twice.
        """
        if first.shape[1] == 0 or self.options(budget).time_ns:
            return self._answered(poses, first, budget)
        guessed = self._descended(poses, first, budget, starts=1)
        if guessed.found.all():
            return guessed
        missed = ~guessed.found
        answered = self._answered(poses[missed], first[missed], budget)
        answered.time_s[:] += guessed.time_s[missed]
        return merged(missed, answered, guessed.rows(~missed))

    def _answered(
        self, poses: NDArray[np.float64], first: NDArray[np.float64], budget: Budget | None
    ) -> Refined:
        """Refine from the first seeds, then from the hypotheses."""
        start = time.perf_counter()
        answers = self.hypotheses(poses).joints[:, : self.tried]
        network_s = (time.perf_counter() - start) / len(poses)
        refined = self._descended(poses, np.concatenate((first, answers), axis=1), budget)
        refined.time_s[:] += network_s
        return refined

    def _descended(
        self,
        poses: NDArray[np.float64],
        seeds: NDArray[np.float64],
        budget: Budget | None,
        starts: int | None = None,
    ) -> Refined:
        """Descend from seeds (N, K, dof), then from the seed library; so many starts at most."""
        options = self.options(budget)
        if starts is not None:
            options = options._replace(starts=min(options.starts, starts))
        if self.accelerator is not None:
            return refine_torch(self.accelerator, poses, seeds, options, self.library)
        return refine(self.robot, poses, seeds, options, self.threads, self.library)


def _neural(name: str, robot: Robot, **overrides: Any) -> NeuralSolver:
    """Load the solver whose hypotheses are refined."""
    proposers = [known for known in baselines.names() if _is_network(known)]
    if name not in proposers:
        raise SettingError(f"proposer: {unknown_name('neural solver', name, proposers)}")
    seeds = cast("type[NeuralSolver]", solver_class(name)).as_proposer
    solver = baselines.load(name, robot, **{**seeds, **overrides})
    assert isinstance(solver, NeuralSolver)
    return solver


def _is_network(name: str) -> bool:
    """Whether a solver is a network alone; its settings tell, without an import."""
    values = settings(name)
    return "weights" in values and "proposer" not in values
