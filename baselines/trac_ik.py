"""TRAC-IK through pytracik: a Newton descent and a sequential quadratic program race each other.

Beeson and Ames, "TRAC-IK: an open-source library for improved solving of generic inverse
kinematics", Humanoids 2015. The library runs its two methods on two threads of its own and stops by
the wall clock, so its answers are not the same twice.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from baselines.chain_urdf import chain_urdf
from baselines.checks import positive_settings
from baselines.errors import SettingError, SolverError
from baselines.timed import LONGEST_S, Array, TimedSolver
from robots.serial_urdf import BASE, TIP

if TYPE_CHECKING:
    from robots import Robot

# A library's own slack, m or rad, when its limits are compared with the robot's.
LIMIT_TOLERANCE = 1e-6
SOLVE_TYPES = ("Speed", "Distance", "Manip1", "Manip2")
# One of its two methods refuses chains of one joint, aloud, and takes the other with it; so every
# chain stands on a joint more, which has no room to speak of [rad].
MOUNT, MOUNT_ROOM = "chain_mount", 1e-12


class TracIk(TimedSolver):
    """TRAC-IK with its random restarts, until a solution or the time limit.

    Args:
        robot: The robot to solve for.
        epsilon: Largest error of any component of the tip's twist [m or rad].
        solve_type: "Speed" for the first solution, "Distance" for the one nearest the initial
            guess, "Manip1" or "Manip2" for manipulability; all but "Speed" use up the time.
        time_s: Wall-clock budget per pose where `solve` gets none [s].
    """

    requires: ClassVar[tuple[str, ...]] = ("pytracik",)

    def __init__(self, robot: Robot, *, epsilon: float, solve_type: str, time_s: float) -> None:
        super().__init__(robot, time_s=time_s)
        if solve_type not in SOLVE_TYPES:
            raise SettingError(
                f"expected solve_type of {', '.join(SOLVE_TYPES)}, got {solve_type!r}"
            )
        self.epsilon = positive_settings({"epsilon": epsilon})["epsilon"]
        self.tolerances = (math.sqrt(3.0) * self.epsilon,) * 2
        self.solve_type = solve_type
        self._urdf = _with_mount(chain_urdf(robot))
        # The time limit is fixed when the library's solver is made: one for each.
        self._solvers: dict[float, Any] = {}
        self._library(min(time_s, LONGEST_S))

    def _library(self, time_s: float) -> Any:
        if time_s not in self._solvers:
            import pytracik

            kind = getattr(pytracik.SolveType, self.solve_type)
            solver = pytracik.TRAC_IK(MOUNT, TIP, self._urdf, time_s, self.epsilon, kind)
            lower = np.array(pytracik.get_joint_lower_bounds(solver))[1:]
            upper = np.array(pytracik.get_joint_upper_bounds(solver))[1:]
            chain = self.robot.chain
            if lower.shape != self.lower.shape or not (
                np.allclose(lower, chain.lower, atol=LIMIT_TOLERANCE)
                and np.allclose(upper, chain.upper, atol=LIMIT_TOLERANCE)
            ):
                raise SolverError(
                    f"pytracik read the limits of {self.robot.name} as {lower} to {upper}, "
                    f"expected {chain.lower} to {chain.upper}"
                )
            self._solvers[time_s] = solver
        return self._solvers[time_s]

    def _set_time(self, time_s: float) -> None:
        self._current = self._library(time_s)

    def _search(self, pose: Array, initial: Array) -> Array | None:
        import pytracik

        x, y, z, qw, qx, qy, qz = pose.tolist()
        start = np.concatenate([[0.0], initial])
        answer = pytracik.ik(self._current, start, x, y, z, qx, qy, qz, qw)
        return np.asarray(answer[2:]) if answer[0] >= 0 else None


def _with_mount(urdf: str) -> str:
    """The chain on a joint that hardly moves, for the library's sake."""
    document = ElementTree.fromstring(urdf)
    ElementTree.SubElement(document, "link", name=MOUNT)
    joint = ElementTree.SubElement(document, "joint", name="chain_mounting", type="revolute")
    ElementTree.SubElement(joint, "parent", link=MOUNT)
    ElementTree.SubElement(joint, "child", link=BASE)
    ElementTree.SubElement(joint, "axis", xyz="0 0 1")
    room = {"lower": repr(-MOUNT_ROOM), "upper": repr(MOUNT_ROOM), "effort": "1", "velocity": "1"}
    ElementTree.SubElement(joint, "limit", room)
    return ElementTree.tostring(document, encoding="unicode")
