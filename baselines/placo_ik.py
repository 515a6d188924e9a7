"""Placo's task-space kinematics solver: a quadratic program with joint limits per step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.chain_urdf import chain_urdf_file
from baselines.checks import positive_settings
from baselines.descent import DescentSolver
from baselines.transforms import pose_matrix
from robots.serial_urdf import JOINT, TIP

if TYPE_CHECKING:
    from robots import Robot


class Placo(DescentSolver):
    """Gauss-Newton steps of placo's `KinematicsSolver`, restarted when they stall.

    Args:
        robot: The robot to solve for.
        regularization: Weight of placo's task that keeps steps small.
        **descent: Tolerances, restarts and budget, see `DescentSolver`.
    """

    requires: ClassVar[tuple[str, ...]] = ("placo",)
    mimics: ClassVar[bool] = False

    def __init__(self, robot: Robot, *, regularization: float, **descent: Any) -> None:
        import placo

        super().__init__(robot, **descent)
        regularization = positive_settings({"regularization": regularization})["regularization"]
        with chain_urdf_file(robot) as urdf:
            self._robot = placo.RobotWrapper(str(urdf), placo.Flags.ignore_collisions)
        first = self._robot.get_joint_offset(JOINT.format(0))
        self._slice = slice(first, first + robot.dof)
        self._solver = placo.KinematicsSolver(self._robot)
        self._solver.mask_fbase(True)
        self._solver.enable_velocity_limits(False)
        self._task = self._solver.add_frame_task(TIP, np.eye(4))
        self._task.configure("tip", "soft", 1.0, 1.0)
        self._position = self._task.position()
        self._rotation = self._task.orientation()
        self._solver.add_regularization_task(regularization)

    def _aim(self, pose: NDArray[np.float64]) -> None:
        self._task.T_world_frame = pose_matrix(pose)

    def _place(self, joints: NDArray[np.float64]) -> None:
        self._robot.state.q[self._slice] = joints
        self._robot.update_kinematics()

    def _joints(self) -> NDArray[np.float64]:
        return np.array(self._robot.state.q[self._slice])

    def _errors(self) -> tuple[float, float]:
        # Placo computes them in the next solve only, from where that one starts.
        self._position.update()
        self._rotation.update()
        return self._position.error_norm(), self._rotation.error_norm()

    def _step(self) -> None:
        try:
            self._solver.solve(True)
        except RuntimeError:
            # The quadratic program has no solution: rounding left a joint outside its limit.
            self._place(np.clip(self._joints(), self.lower, self.upper))
            return
        self._robot.update_kinematics()
