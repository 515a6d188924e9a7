"""Mink: one quadratic program with joint limits per step, on MuJoCo."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from baselines.chain_urdf import chain_urdf
from baselines.task_descent import STEP_S, Array, TaskDescent
from robots.serial_urdf import TIP

# MuJoCo would merge the tip into the last moving link, and balance our made-up inertias.
COMPILER = '<mujoco><compiler fusestatic="false" balanceinertia="false"/></mujoco>'


class Mink(TaskDescent):
    """Steps of `mink.solve_ik` with a frame task, restarted when they stall."""

    requires: ClassVar[tuple[str, ...]] = ("mink", "mujoco", "qpsolvers")

    def _set_up(self, task: dict[str, float], limit_gain: float) -> None:
        import mink
        import mujoco

        self._mink, self._infeasible = mink, mink.MinkError
        xml = chain_urdf(self.robot).replace("</robot>", COMPILER + "</robot>")
        model = mujoco.MjModel.from_xml_string(xml)
        self._configuration = mink.Configuration(model)
        self._task = mink.FrameTask(TIP, "body", **task)
        self._limits = [mink.ConfigurationLimit(model, gain=limit_gain)]

    def _aim(self, pose: Array) -> None:
        # Both are scalar first: w x y z, then the position.
        self._task.set_target(self._mink.SE3(wxyz_xyz=np.concatenate([pose[3:], pose[:3]])))
        self._goal = pose[:3]

    def _errors(self) -> tuple[float, float]:
        error = self._task.compute_error(self._configuration)
        # The error is the logarithm of a transform, whose linear part is not the distance.
        tip = self._configuration.get_transform_frame_to_world(TIP, "body")
        distance = tip.translation() - self._goal
        return math.sqrt(distance @ distance), math.sqrt(error[3:] @ error[3:])

    def _velocity(self) -> Any:
        return self._mink.solve_ik(
            self._configuration,
            [self._task],
            STEP_S,
            solver=self.qp_solver,
            limits=self._limits,
        )
