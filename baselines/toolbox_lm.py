"""Levenberg-Marquardt of the Robotics Toolbox for Python (its compiled solver)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.checks import count_settings, positive_settings
from baselines.errors import SettingError, SolverError
from baselines.protocol import Answer, Clock, QuerySolver
from baselines.restarts import restart_configurations
from baselines.transforms import pose_matrix

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


class ToolboxLm(QuerySolver):
    """`ETS.ik_LM`, one search at a time, so that restarts are ours and budgets are kept.

    Corke and Haviland, "Not your grandmother's toolbox", ICRA 2021.

    Args:
        robot: The robot to solve for.
        tolerance: Half the squared error (m² + rad²) below which a solution is claimed.
        method: Rule of its damping: "chan", "wampler" or "sugihara".
        gain: Weight of its damping.
        search_iterations: Iterations of one search, after which it starts again at random.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
        iterations: Iteration budget per pose where `solve` gets none.
    """

    requires: ClassVar[tuple[str, ...]] = ("roboticstoolbox",)
    mimics: ClassVar[bool] = False

    def __init__(
        self,
        robot: Robot,
        *,
        tolerance: float,
        method: str,
        gain: float,
        search_iterations: int,
        time_s: float | None,
        iterations: int | None,
    ) -> None:
        super().__init__(robot, time_s=time_s, iterations=iterations)
        if method not in ("chan", "wampler", "sugihara"):
            raise SettingError(f"expected method chan, wampler or sugihara, got {method!r}")
        counts = count_settings({"search_iterations": search_iterations})
        sizes = positive_settings({"tolerance": tolerance, "gain": gain})
        self.search_iterations = counts["search_iterations"]
        self.tolerances = (math.sqrt(2.0 * sizes["tolerance"]),) * 2
        self._settings = {
            "tol": sizes["tolerance"],
            "method": method,
            "k": sizes["gain"],
            "slimit": 1,
        }
        self._transforms = _transforms(robot)

    def _solve_one(self, pose: Array, initial: Array, clock: Clock) -> Answer:
        target = pose_matrix(pose)
        fresh = restart_configurations(pose, self.lower, self.upper)
        start = initial
        while True:
            limit = self.search_iterations
            if clock.limit is not None:
                limit = min(limit, clock.limit - clock.iterations)
            answer = self._transforms.ik_LM(target, q0=start, ilimit=limit, **self._settings)
            clock.iterations += min(int(answer.iterations), limit)
            if answer.success:
                return Answer(answer.q, "")
            reason = clock.expired()
            if reason:
                # A failed search leaves a random configuration in `answer.q`.
                return Answer(initial, reason)
            start = next(fresh)


def _transforms(robot: Robot) -> Any:
    """The chain as the toolbox's sequence of elementary transforms."""
    from roboticstoolbox import ET, ETS

    chain = robot.chain
    if len(chain.variable) != robot.dof:
        raise SolverError(f"{robot.name}: the toolbox has no joint that mimics another one")
    parts = []
    for k, (rotation, translation) in enumerate(
        zip(chain.rotations, chain.translations, strict=True)
    ):
        constant = np.eye(4)
        constant[:3, :3], constant[:3, 3] = rotation, translation
        parts.append(ET.SE3(constant))
        if k < robot.dof:
            joint = ET.tz if chain.prismatic[k] else ET.Rz
            limits = np.array([chain.lower[k], chain.upper[k]])
            parts.append(joint(jindex=k, qlim=limits))
    return ETS(parts)
