"""Mink: one quadratic program with joint limits per step, on MuJoCo."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from baselines.chain_urdf import chain_urdf
from baselines.checks import damping_settings, positive_settings
from baselines.descent import DescentSolver
from robots.serial_urdf import TIP

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# A step is a displacement rather than a velocity over some time.
STEP_S = 1.0
# MuJoCo would merge the tip into the last moving link, and balance our made-up inertias.
COMPILER = '<mujoco><compiler fusestatic="false" balanceinertia="false"/></mujoco>'


class Mink(DescentSolver):
    """Steps of `mink.solve_ik` with a frame task, restarted when they stall.

    Args:
        robot: The robot to solve for.
        qp_solver: Name of the quadratic-program solver (of qpsolvers).
        lm_damping: Mink's damping of the task per squared error.
        limit_gain: Share of the way to a joint limit that one step may take, in (0, 1].
        **descent: Tolerances, restarts and budget, see `DescentSolver`.
    """

    requires: ClassVar[tuple[str, ...]] = ("mink", "mujoco", "qpsolvers")
    mimics: ClassVar[bool] = False

    def __init__(
        self, robot: Robot, *, qp_solver: str, lm_damping: float, limit_gain: float, **descent: Any
    ) -> None:
        import mink
        import mujoco

        super().__init__(robot, **descent)
        self.qp_solver = qp_solver
        limit_gain = positive_settings({"limit_gain": limit_gain})["limit_gain"]
        lm_damping = damping_settings(lm_damping, 1.0)[0]
        self._mink = mink
        xml = chain_urdf(robot).replace("</robot>", COMPILER + "</robot>")
        self._model = mujoco.MjModel.from_xml_string(xml)
        self._configuration = mink.Configuration(self._model)
        self._task = mink.FrameTask(
            TIP, "body", position_cost=1.0, orientation_cost=1.0, lm_damping=lm_damping
        )
        self._limits = [mink.ConfigurationLimit(self._model, gain=limit_gain)]

    def _aim(self, pose: Array) -> None:
        # Both are scalar first: w x y z, then the position.
        self._task.set_target(self._mink.SE3(wxyz_xyz=np.concatenate([pose[3:], pose[:3]])))
        self._goal = pose[:3]

    def _place(self, joints: Array) -> None:
        self._configuration.update(joints)

    def _joints(self) -> Array:
        return np.array(self._configuration.q)

    def _errors(self) -> tuple[float, float]:
        error = self._task.compute_error(self._configuration)
        # The error is the logarithm of a transform, whose linear part is not the distance.
        tip = self._configuration.get_transform_frame_to_world(TIP, "body")
        distance = tip.translation() - self._goal
        return math.sqrt(distance @ distance), math.sqrt(error[3:] @ error[3:])

    def _step(self) -> None:
        try:
            velocity = self._mink.solve_ik(
                self._configuration,
                [self._task],
                STEP_S,
                solver=self.qp_solver,
                limits=self._limits,
            )
        except self._mink.MinkError:
            # Rounding left a joint outside its limit: no step is feasible from there.
            self._place(np.clip(self._joints(), self.lower, self.upper))
            return
        self._configuration.integrate_inplace(velocity, STEP_S)
