"""Remembered configurations as seeds of the compiled Levenberg-Marquardt kernel: no learning."""

from __future__ import annotations

import time
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import baselines
from baselines.checks import count_settings, thread_setting
from baselines.kernel_abilities import KernelAbilities
from baselines.lm import LevenbergMarquardt
from baselines.lm_kernel import LmOptions
from baselines.protocol import Budget, Solution, Solver
from baselines.refine import refine
from baselines.seed_library import LIBRARY_SEED, pose_features

if TYPE_CHECKING:
    from scipy.spatial import KDTree

    from robots import Robot

Array = NDArray[np.float64]


class Lookup(KernelAbilities, Solver):
    """The nearest of many remembered configurations, refined to the tolerances of `lm`.

    Nearness is that of `baselines.seed_library`: distance in units of half the workspace, and of
    the rotation matrices with half that weight. A k-d tree finds it (Bentley, CACM 1975). Then come
    random restarts. An initial guess that is given comes first, so that a motion stays on its
    branch of solutions.

    Args:
        robot: The robot to solve for.
        remembered: Configurations that are drawn, free of self-collision, and kept.
        neighbours: Of these, the nearest that are descended from.
        threads: Threads of the search and of the kernel; 0 for all.
        time_s: Wall-clock budget per pose of the descent where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.

    Attributes:
        joints: (M, dof) what is remembered [rad or m].
        kernel: The solver `lm`, whose tolerances and damping are used.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        remembered: int,
        neighbours: int,
        threads: int,
        time_s: float | None,
        iterations: int | None,
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        sizes = count_settings({"remembered": remembered, "neighbours": neighbours}, least=1)
        self.remembered = sizes["remembered"]
        self.neighbours = min(sizes["neighbours"], self.remembered)
        self.threads = thread_setting(threads)
        kernel = baselines.load("lm", robot, time_s=time_s, iterations=iterations)
        assert isinstance(kernel, LevenbergMarquardt)
        self.kernel, self.tolerances = kernel, kernel.tolerances

    def options(self, budget: Budget | None) -> LmOptions:
        """The kernel's options, by default under this solver's own budget."""
        return self.kernel.options(self.budget if budget is None else budget)

    @cached_property
    def joints(self) -> Array:
        """What is remembered, free of collision where that can be told; drawn when first needed."""
        known = not self.robot.urdf.broken_collisions
        return self.robot.sample(self.remembered, seed=LIBRARY_SEED, collision_free=known)

    @cached_property
    def tree(self) -> KDTree:
        """Their poses in the order of `joints`."""
        from scipy.spatial import KDTree

        return KDTree(pose_features(self.robot, self.robot.forward_kinematics(self.joints)))

    def nearest(self, poses: Array) -> Array:
        """Return the remembered configurations nearest to targets.

        Args:
            poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz.

        Returns:
            (N, neighbours, dof) [rad or m], the nearest first.
        """
        ranks = np.arange(1, self.neighbours + 1)
        features = pose_features(self.robot, poses)
        _, rows = self.tree.query(features, ranks, workers=self.threads or -1)
        found: Array = self.joints[rows]
        return found

    def first_seeds(self, poses: Array, initial: Array | None) -> Array:
        """See `KernelAbilities`: the initial guess, then the nearest remembered configurations."""
        nearest = self.nearest(poses)
        return nearest if initial is None else np.concatenate((initial[:, None], nearest), axis=1)

    def _solve_batch(self, poses: Array, initial: Array, budget: Budget | None) -> Solution:
        return self._descended(poses, initial[:, None], budget)

    def _solve_unguided(self, poses: Array, budget: Budget | None) -> Solution:
        return self._descended(poses, np.empty((len(poses), 0, self.robot.dof)), budget)

    def _descended(self, poses: Array, first: Array, budget: Budget | None) -> Solution:
        """Descend from the first seeds (N, 0 or 1, dof), then from the nearest remembered ones."""
        _ = self.tree  # preparing it is no part of a query
        begin = time.perf_counter()
        seeds = np.concatenate((first, self.nearest(poses)), axis=1)
        search_s = (time.perf_counter() - begin) / len(poses)
        refined = refine(self.robot, poses, seeds, self.options(budget), self.threads)
        refined.time_s[:] += search_s
        return refined.solution()
