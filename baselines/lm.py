"""The compiled Levenberg-Marquardt solver, from home and then from random configurations."""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.abilities import AVOID, FOLLOW
from baselines.avoid import refine_avoiding
from baselines.avoid_kernel import Slide
from baselines.checks import (
    count_settings,
    damping_settings,
    positive_settings,
    thread_setting,
)
from baselines.compiled_query import CompiledQuery
from baselines.errors import SettingError
from baselines.following import FollowingSolver
from baselines.joint_range import joint_range
from baselines.kernel_abilities import KernelAbilities
from baselines.lm_kernel import LmOptions
from baselines.lm_query import lm_query, near_rows
from baselines.protocol import Budget, Solution
from baselines.refine import Refined, refine
from baselines.seed_library import LIBRARY_SEED, SeedLibrary, build_seed_library
from robots.arguments import as_float
from robots.pose_bound import pose_bound

if TYPE_CHECKING:
    from robots import Robot
    from robots.obstacles import Obstacles

Array = NDArray[np.float64]

# Without an iteration limit the time limit ends a query; this one is never reached.
UNLIMITED = 2**62


class LevenbergMarquardt(KernelAbilities, FollowingSolver):
    """Levenberg-Marquardt with joint limits as an active set and random restarts.

    Args:
        robot: The robot to solve for.
        seed_library: Random configurations that are remembered with their poses; 0 for none.
        neighbours: Of these, the nearest that are descended from where the initial guess leads
            nowhere, before random configurations.
        max_jump: How far each joint may be from the initial guess, or from home without one
            [rad or m]; what is further is not found. None allows any distance.
        null_space: Where a motion is followed, largest motion of a joint within the null space,
            away from the limits, as a share of the largest in the step to the target; 0 for none.
        avoid_steps: Steps within the null space in which joints that collide are moved away, where
            `solve` has something to avoid; 0 takes the first free one of many answers.
        avoid_margin_m: What is nearer than the clearance and this is pushed away [m].
        avoid_move: Largest motion of a joint in such a step [rad or m].
        return_share: Share of a limit of time that is left for the way back, so that a call that
            finds nothing ends within the limit.
        threads: Threads that share a batch; 0 for all of numba's.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
        **options: The other fields of `LmOptions`.
    """

    abilities: ClassVar[frozenset[str]] = KernelAbilities.abilities | {AVOID, FOLLOW}

    def __init__(
        self,
        robot: Robot,
        *,
        seed_library: int,
        neighbours: int,
        max_jump: float | None,
        null_space: float,
        avoid_steps: int,
        avoid_margin_m: float,
        avoid_move: float,
        return_share: float,
        threads: int,
        time_s: float | None,
        iterations: int | None,
        **options: Any,
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        self.threads = thread_setting(threads)
        remembered = {"seed_library": seed_library, "neighbours": neighbours}
        self._remembered = count_settings(remembered, least=0)
        self.max_jump = max_jump
        if max_jump is not None:
            self.max_jump = positive_settings({"max_jump": max_jump})["max_jump"]
        self.null_space = as_float(null_space, "null_space", SettingError)
        if not 0.0 <= self.null_space < math.inf:
            raise SettingError(f"expected null_space to be finite and at least 0, got {null_space}")
        pushed = positive_settings({"avoid_margin_m": avoid_margin_m, "avoid_move": avoid_move})
        steps = count_settings({"avoid_steps": avoid_steps}, least=0)["avoid_steps"]
        if not 0.0 <= return_share < 1.0:
            raise SettingError(f"expected return_share from 0 to below 1, got {return_share!r}")
        self._worked_share = 1.0 - return_share
        self.slide = Slide(steps, *pushed.values())
        # The kernel is compiled for these types; others would have it compiled again.
        sizes = ("position_tolerance_m", "rotation_tolerance_rad")
        damping, gain = damping_settings(options.pop("damping"), options.pop("damping_gain"))
        checked: dict[str, Any] = {
            **positive_settings({key: options.pop(key) for key in sizes}),
            **count_settings({"patience": options.pop("patience")}),
            **count_settings({key: options.pop(key) for key in list(options)}, least=0),
        }
        self._options = LmOptions(
            **checked,
            damping=damping,
            damping_gain=gain,
            iterations=UNLIMITED,
            starts=UNLIMITED,
            time_ns=0,
        )
        self.position_tolerance_m = self._options.position_tolerance_m
        self.rotation_tolerance_rad = self._options.rotation_tolerance_rad
        self.tolerances = (self.position_tolerance_m, self.rotation_tolerance_rad)

    @cached_property
    def library(self) -> SeedLibrary:
        """What is descended from after the initial guess; drawn when it is first needed."""
        return build_seed_library(
            self.robot,
            self._remembered["seed_library"],
            self._remembered["neighbours"],
            LIBRARY_SEED,
        )

    def options(self, budget: Budget | None) -> LmOptions:
        """The kernel's options under a budget."""
        if budget is None:
            budget = self.budget or Budget(iterations=UNLIMITED)
        return self._options._replace(
            iterations=UNLIMITED if budget.iterations is None else budget.iterations,
            time_ns=0
            if budget.time_s is None
            else max(1, int(self._worked_share * budget.time_s * 1e9)),
        )

    def compile_query(self, options: LmOptions) -> CompiledQuery:
        """See `CompiledQuerySolver`."""
        robot = self.robot
        bound = (joint_range(robot), robot.home, robot.chain, self.library, pose_bound(robot))
        return CompiledQuery(lm_query, options, robot.dof, *bound, self.max_jump)

    def seed_memory(self) -> SeedLibrary:
        """See `KernelAbilities`."""
        return self.library

    def first_seeds(self, poses: Array, initial: Array | None) -> Array:
        """See `KernelAbilities`: the initial guess, or home."""
        guesses = np.tile(self.robot.home, (len(poses), 1)) if initial is None else initial
        return guesses[:, None]

    def lacks(self, ability: str) -> str | None:
        """See `Abilities`: within a largest jump there is one descent and no more."""
        if self.max_jump is not None and ability in self.abilities - {FOLLOW}:
            return f"solver {self.name!r} has no {ability} with max_jump={self.max_jump:g}"
        return super().lacks(ability)

    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        options = self.options(budget)
        if self.max_jump is not None:
            return self._solve_near(poses, initial, options)
        refined = refine(
            self.robot, poses, initial[:, None, :], options, self.threads, self.library
        )
        return refined.solution()

    def _solve_avoiding(
        self, poses: Array, initial: Array | None, budget: Budget | None, sets: list[Obstacles]
    ) -> Solution:
        seeds = self.first_seeds(poses, initial)
        bound = self.options(budget), self.slide, self.library, sets
        return refine_avoiding(self.robot, poses, seeds, *bound).solution()

    def _solve_near(self, poses: Array, initial: Array, options: LmOptions) -> Solution:
        """Solve poses within the largest jump of their initial guesses."""
        robot, answers = self.robot, np.empty_like(initial)
        outcomes = np.empty((len(poses), 4), dtype=np.int64)
        bound = self.library, options, self.max_jump
        near_rows(robot.chain, poses, initial[:, None], *bound, answers, outcomes)
        status, iterations, starts, ns = outcomes.T
        time_s = np.asarray(ns * 1e-9, dtype=np.float64)
        joints = robot.nearest_turns(answers)
        return Refined(joints, status, iterations, starts, time_s).solution()
