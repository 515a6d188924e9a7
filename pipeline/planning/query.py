"""The batched query: all poses of a path, one answer each, on as few branches as it allows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from baselines.refine import refine
from pipeline.planning.bezier import path_parameter
from pipeline.planning.continuity import Answers, Ends, kernel_options
from pipeline.planning.search_kernel import cheapest_path

if TYPE_CHECKING:
    from baselines import Solver
    from pipeline.learning.solver import Hypotheses
    from robots import Robot

Array = NDArray[np.float64]

# A hypothesis that misses its pose has to be corrected; joints that far out along the arm move the
# tip by the miss, so it costs the square of the miss over this lever.
LEVER_M = 0.5


@runtime_checkable
class Hypothesising(Protocol):
    """A solver whose network gives several answers to a pose."""

    position_tolerance_mm: float
    rotation_tolerance_deg: float

    def hypotheses(self, poses: NDArray[np.float64]) -> Hypotheses:
        """Return answers to poses (N, 7), best first."""


def solve_waypoints(robot: Robot, solver: Solver, poses: Array, ends: Ends) -> Answers:
    """Ask a solver for all waypoints of a path.

    A network with several hypotheses is queried once. Of each waypoint's hypotheses that one is
    taken with which the joints travel least along the path; a refined solver then refines it, and
    falls back on the waypoint's others. Other solvers are queried for the two ends first, and the
    batch is seeded with the straight line between their joints: neighbouring seeds keep an
    iterative solver on one branch of solutions. The same holds where the joints at the target are
    given.

    Args:
        robot: The robot.
        solver: The solver.
        poses: Waypoints, base frame [m, unit quaternion], shape (S, 7).
        ends: Joints that the path has to start and end with.
    """
    if not isinstance(solver, Hypothesising) or (ends.last is not None and kernel_options(solver)):
        return _seeded(robot, solver, poses, ends)
    answers = solver.hypotheses(poses)
    candidates, chosen = answers.joints, np.zeros(len(poses), dtype=np.int64)
    position, rotation = answers.position_mm, answers.rotation_deg
    prices = (1e-3 * position / LEVER_M) ** 2 + np.deg2rad(rotation) ** 2
    considered = candidates.copy()
    for i, known in zip((0, -1), ends, strict=True):
        if known is not None:
            considered[i], prices[i] = known, 0.0
    cheapest_path(considered, prices, chosen)
    rows = np.arange(len(poses))
    joints, options = considered[rows, chosen], kernel_options(solver)
    if options is None:
        found = (position[rows, chosen] <= solver.position_tolerance_mm) & (
            rotation[rows, chosen] <= solver.rotation_tolerance_deg
        )
        return Answers(*ends.pin(joints, found), candidates)
    seeds = np.concatenate([joints[:, None], candidates], axis=1)
    refined = refine(robot, poses, seeds, options._replace(starts=seeds.shape[1]))
    return Answers(*ends.pin(refined.joints, refined.found), candidates)


def _seeded(robot: Robot, solver: Solver, poses: Array, ends: Ends) -> Answers:
    """Seed the batch with the straight line between the joints at its ends."""
    seed = robot.home if ends.first is None else ends.first
    edge = np.array(solver.solve(poses[[0, -1]], initial=seed).joints)
    edge, _ = ends.pin(edge, np.ones(2, dtype=bool))
    k = path_parameter(len(poses))[:, None]
    solution = solver.solve(poses, initial=(1.0 - k) * edge[0] + k * edge[1])
    return Answers(*ends.pin(np.array(solution.joints), np.array(solution.found)))
