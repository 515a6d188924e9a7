"""Pink: one quadratic program with joint limits per step, on Pinocchio."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from baselines.chain_urdf import chain_urdf
from baselines.task_descent import STEP_S, Array, TaskDescent
from baselines.transforms import pose_matrix
from robots.serial_urdf import TIP


class Pink(TaskDescent):
    """Steps of `pink.solve_ik` with a frame task, restarted when they stall."""

    requires: ClassVar[tuple[str, ...]] = ("pink", "qpsolvers")

    def _set_up(self, task: dict[str, float], limit_gain: float) -> None:
        import pink
        import pinocchio

        self._pink, self._se3 = pink, pinocchio.SE3
        self._infeasible = pink.exceptions.PinkError
        model = pinocchio.buildModelFromXML(chain_urdf(self.robot))
        home = np.asarray(self.robot.home, dtype=np.float64)
        self._configuration = pink.Configuration(model, model.createData(), home)
        self._task = pink.tasks.FrameTask(TIP, **task)
        # Velocity limits do not belong to a static problem.
        self._limits = [pink.limits.ConfigurationLimit(model, config_limit_gain=limit_gain)]

    def _aim(self, pose: Array) -> None:
        self._task.set_target(self._se3(pose_matrix(pose)))

    def _errors(self) -> tuple[float, float]:
        error = self._task.compute_error(self._configuration)
        # The error is the logarithm of a transform, whose linear part is not the distance.
        tip = self._configuration.get_transform_frame_to_world(self._task.frame)
        distance = tip.translation - self._task.transform_target_to_world.translation
        return math.sqrt(distance @ distance), math.sqrt(error[3:] @ error[3:])

    def _velocity(self) -> Any:
        return self._pink.solve_ik(
            self._configuration,
            [self._task],
            STEP_S,
            solver=self.qp_solver,
            limits=self._limits,
            safety_break=False,
        )
