"""What only some solvers do: many solutions, poses in part, motions, and reasons for a "no"."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from baselines.checks import check_initial, check_poses, count_settings, positive_settings
from baselines.errors import AbilityError, InitialError, PoseError
from baselines.freedom import Freedom, widths_of
from robots.arguments import as_floats

if TYPE_CHECKING:
    from baselines.explanation import Explanation
    from baselines.followed_path import FollowedPath
    from baselines.protocol import Budget, Solution
    from robots import Robot

Array = NDArray[np.float64]

MANY, PARTIAL, EXPLAIN, FOLLOW = "solve_all", "solve_partial", "explain", "follow"
AVOID = "avoid"  # of `Solver.solve`


class Abilities:
    """The part of the solver protocol that a solver may leave out.

    Attributes:
        abilities: Which of "solve_all", "solve_partial", "explain", "follow" and "avoid" it has.
    """

    name: str
    robot: Robot
    abilities: ClassVar[frozenset[str]] = frozenset()

    def lacks(self, ability: str) -> str | None:
        """Say why this solver has no such ability, or None if it has it.

        Args:
            ability: Name of a method, "solve_all", "solve_partial", "explain" or "follow", or
                "avoid", an argument of `Solver.solve`.
        """
        if ability in self.abilities:
            return None
        return f"solver {self.name or type(self).__name__!r} has no {ability}"

    def solve_all(
        self, pose: ArrayLike, count: int, *, apart: float, initial: ArrayLike | None = None
    ) -> Array:
        """Find solutions of one pose that differ, up to a number of them.

        Args:
            pose: (7,) target in the base frame, x y z in m, then unit qw qx qy qz.
            count: The search ends with so many; an arm with more joints than a pose has numbers has
                infinitely many.
            apart: Two solutions differ by more than this in one joint [rad or m]; joints that turn
                for ever are compared by the shorter way round.
            initial: (dof,) that the solutions are sorted by, the nearest first [rad or m]; in the
                order in which they were found if None.

        Returns:
            (K, dof) joints within the tolerances of the solver, K from 0 to `count`.

        Raises:
            AbilityError: This solver gives one answer to a pose.
            PoseError: As `Solver.solve`.
            InitialError: As `Solver.solve`.
            SettingError: A count or a distance that cannot be.
        """
        self._need(MANY)
        limit = count_settings({"count": count})["count"]
        distance = positive_settings({"apart": apart})["apart"]
        target = _one_pose(pose)
        guesses = self._guesses(initial, 1)
        return self._solve_all(target, limit, distance, None if guesses is None else guesses[0])

    def solve_partial(
        self,
        poses: ArrayLike,
        freedom: Freedom | Sequence[Freedom],
        initial: ArrayLike | None = None,
        budget: Budget | None = None,
    ) -> Solution:
        """Find joints whose tip poses are `poses` but for what these leave open.

        Args:
            poses: (N, 7) targets as for `Solver.solve`; numbers that are free do not matter.
            freedom: What is open, for all poses or for each.
            initial: See `Solver.solve`.
            budget: See `Solver.solve`.

        Returns:
            One row per pose; `found` means that what counts of the error is within the tolerances.

        Raises:
            AbilityError: This solver knows whole poses only.
            FreedomError: Freedoms that do not fit the poses.
            PoseError: As `Solver.solve`.
            InitialError: As `Solver.solve`.
            BudgetError: As `Solver.solve`.
        """
        self._need(PARTIAL)
        targets = check_poses(poses)
        widths = widths_of(freedom, len(targets))
        guesses = self._guesses(initial, len(targets))
        return self._nearest_turns(self._solve_partial(targets, widths, guesses, budget), initial)

    def explain(self, pose: ArrayLike) -> Explanation:
        """Say why a pose has no solution, with the evidence.

        Args:
            pose: (7,) target in the base frame, x y z in m, then unit qw qx qy qz.

        Raises:
            AbilityError: This solver gives no reasons.
            PoseError: As `Solver.solve`.
        """
        self._need(EXPLAIN)
        return self._explain(_one_pose(pose))

    def follow(self, poses: ArrayLike, last: ArrayLike, budget: Budget | None = None) -> Solution:
        """Find joints for poses that follow others in a motion, from the answers to those.

        Unlike `Solver.solve` with the same guess, it keeps a motion on its branch of solutions
        where it can: between two answers an arm with joints to spare moves away from its limits.

        Args:
            poses: (N, 7) targets as for `Solver.solve`; each may be of another motion.
            last: (dof,) or (N, dof) answers to the poses before, see `initial` of `Solver.solve`.
            budget: See `Solver.solve`.

        Returns:
            One row per pose.

        Raises:
            AbilityError: This solver answers every pose for itself.
            PoseError: As `Solver.solve`.
            InitialError: As `Solver.solve`.
            BudgetError: As `Solver.solve`.
        """
        self._need(FOLLOW)
        if (answer := self._follow_at_once(poses, last, budget)) is not None:
            return answer
        count = len(check_poses(poses))
        self._guesses(last, count)
        # As they came: the kernel makes quaternions unit by itself, and twice is not the same bits.
        targets = np.array(as_floats(poses, "poses", PoseError), order="C").reshape(count, 7)
        rows = np.broadcast_to(
            as_floats(last, "last joints", InitialError), (count, self.robot.dof)
        )
        return self._follow(targets, np.array(rows, order="C"), budget)

    def follow_one(self, pose: ArrayLike, last: ArrayLike) -> tuple[Array, bool]:
        """Find joints for the next pose of a motion, under the solver's own budget.

        What `follow` answers to a batch of one, by the shortest path there is.

        Args:
            pose: (7,) target in the base frame, x y z in m, then unit qw qx qy qz.
            last: (dof,) answer to the pose before [rad or m].

        Returns:
            As `Solver.solve_one`.

        Raises:
            AbilityError: As `follow`.
            PoseError: As `Solver.solve`.
            InitialError: As `Solver.solve`.
        """
        solution = self.follow(_one_pose(pose)[None], last)
        return solution.joints[0], bool(solution.found[0])

    def follow_path(
        self, poses: ArrayLike, start: ArrayLike, *, max_jump: float = 0.1, attempts: int = 128
    ) -> FollowedPath:
        """Find joints along a path that is known beforehand, without a jump.

        Following pose after pose by `follow` may lead an arm to where a limit ends its branch of
        solutions. Here it begins again from the start where that happens, and moves a
        redundant arm through other postures; the answers depend on nothing else.

        Args:
            poses: (S, 7) targets in the base frame, x y z in m, then unit qw qx qy qz; S > 0.
            start: (dof,) joints from which the first pose is reached without a jump [rad or m].
            max_jump: How far a joint may move from pose to pose [rad or m].
            attempts: How often the path is begun at most; an arm with no joints to spare, or a
                solver that does not use them, has one way only and begins once.

        Returns:
            The joints as far as the best attempt came.

        Raises:
            AbilityError: This solver answers every pose for itself.
            PoseError: As `Solver.solve`, or there is no pose.
            InitialError: As `Solver.solve`.
            SettingError: A distance or a number of attempts that cannot be.
        """
        self._need(FOLLOW)
        targets = check_poses(poses)
        if len(targets) == 0:
            raise PoseError("expected a path of one pose or more, got none")
        jump = positive_settings({"max_jump": max_jump})["max_jump"]
        most = count_settings({"attempts": attempts})["attempts"]
        first = as_floats(start, "start", InitialError)
        self._guesses(first[None], 1)
        return self._follow_path(np.array(targets, order="C"), first.copy(), jump, most)

    def _solve_all(self, pose: Array, count: int, apart: float, guess: Array | None) -> Array:
        """Solve a checked pose (7,) up to `count` times, sorted by a guess (dof,)."""
        raise NotImplementedError

    def _solve_partial(
        self, poses: Array, widths: Array, initial: Array | None, budget: Budget | None
    ) -> Solution:
        """Solve checked poses (N, 7) under widths (N, 6), from guesses (N, dof) or none."""
        raise NotImplementedError

    def _follow_at_once(
        self, poses: ArrayLike, last: ArrayLike, budget: Budget | None
    ) -> Solution | None:
        """Follow to what needs no check, on a shorter path; None for what takes the way of all."""
        return None

    def _follow(self, poses: Array, last: Array, budget: Budget | None) -> Solution:
        """Solve poses (N, 7) from the answers (N, dof) to those before, both as they came."""
        raise NotImplementedError

    def _follow_path(
        self, poses: Array, start: Array, max_jump: float, attempts: int
    ) -> FollowedPath:
        """Follow checked poses (S, 7) from joints (dof,) as they came."""
        raise NotImplementedError

    def _explain(self, pose: Array) -> Explanation:
        """Explain a checked pose (7,)."""
        raise NotImplementedError

    def _need(self, ability: str) -> None:
        reason = self.lacks(ability)
        if reason is not None:
            raise AbilityError(reason)

    def _guesses(self, initial: ArrayLike | None, count: int) -> Array | None:
        """Initial guesses (count, dof) inside the limits, where there are any."""
        robot = self.robot
        if initial is None:
            return None
        limits = robot.lower, robot.upper, robot.endless
        return check_initial(initial, count, robot.home, *limits)

    def _nearest_turns(self, solution: Solution, initial: ArrayLike | None) -> Solution:
        """Turn joints that turn for ever to where they are nearest to the initial guess."""
        if not self.robot.endless.any():
            return solution
        near = None if initial is None else np.asarray(initial, dtype=np.float64)
        return replace(solution, joints=self.robot.nearest_turns(solution.joints, near))


def _one_pose(pose: ArrayLike) -> Array:
    target = as_floats(pose, "pose", PoseError)
    if target.shape != (7,) or not math.isfinite(float(target.sum())):
        raise PoseError(f"expected one finite pose of shape (7,), x y z qw qx qy qz, got {target}")
    return check_poses(target[None])[0]
