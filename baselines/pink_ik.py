"""Pink: one quadratic program with joint limits per step, on Pinocchio."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.chain_urdf import chain_urdf
from baselines.checks import damping_settings, positive_settings
from baselines.descent import DescentSolver
from baselines.transforms import pose_matrix
from robots.serial_urdf import TIP

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# A step is a displacement rather than a velocity over some time.
STEP_S = 1.0


class Pink(DescentSolver):
    """Steps of `pink.solve_ik` with a frame task, restarted when they stall.

    Args:
        robot: The robot to solve for.
        qp_solver: Name of the quadratic-program solver (of qpsolvers).
        lm_damping: Pink's damping of the task per squared error.
        limit_gain: Share of the way to a joint limit that one step may take, in (0, 1].
        **descent: Tolerances, restarts and budget, see `DescentSolver`.
    """

    requires: ClassVar[tuple[str, ...]] = ("pink", "qpsolvers")
    mimics: ClassVar[bool] = False

    def __init__(
        self, robot: Robot, *, qp_solver: str, lm_damping: float, limit_gain: float, **descent: Any
    ) -> None:
        import pink
        import pinocchio

        super().__init__(robot, **descent)
        self.qp_solver = qp_solver
        limit_gain = positive_settings({"limit_gain": limit_gain})["limit_gain"]
        lm_damping = damping_settings(lm_damping, 1.0)[0]
        self._pink, self._se3 = pink, pinocchio.SE3
        self._model = pinocchio.buildModelFromXML(chain_urdf(robot))
        self._configuration = pink.Configuration(
            self._model, self._model.createData(), np.asarray(robot.home, dtype=np.float64)
        )
        self._task = pink.tasks.FrameTask(
            TIP, position_cost=1.0, orientation_cost=1.0, lm_damping=lm_damping
        )
        # Velocity limits do not belong to a static problem.
        self._limits = [pink.limits.ConfigurationLimit(self._model, config_limit_gain=limit_gain)]

    def _aim(self, pose: Array) -> None:
        self._task.set_target(self._se3(pose_matrix(pose)))

    def _place(self, joints: Array) -> None:
        self._configuration.update(joints)

    def _joints(self) -> Array:
        return np.array(self._configuration.q)

    def _errors(self) -> tuple[float, float]:
        error = self._task.compute_error(self._configuration)
        # The error is the logarithm of a transform, whose linear part is not the distance.
        tip = self._configuration.get_transform_frame_to_world(self._task.frame)
        distance = tip.translation - self._task.transform_target_to_world.translation
        return math.sqrt(distance @ distance), math.sqrt(error[3:] @ error[3:])

    def _step(self) -> None:
        try:
            velocity = self._pink.solve_ik(
                self._configuration,
                [self._task],
                STEP_S,
                solver=self.qp_solver,
                limits=self._limits,
                safety_break=False,
            )
        except self._pink.exceptions.PinkError:
            # Rounding left a joint outside its limit: no step is feasible from there.
            self._place(np.clip(self._joints(), self.lower, self.upper))
            return
        self._configuration.integrate_inplace(velocity, STEP_S)
