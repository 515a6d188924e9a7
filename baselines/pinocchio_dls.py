"""Damped least squares on Pinocchio's kinematics, restarted when it stalls.

With `damping_gain` 0 this is damped least squares (Buss, "Introduction to inverse kinematics with
Jacobian transpose, pseudoinverse and damped least squares methods", 2004, eq. 11); with a positive
gain the damping follows the squared error, which makes it the Levenberg-Marquardt method of
Sugihara, "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method", 2011.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import pinocchio
from numpy.typing import NDArray

from baselines.checks import damping_settings
from baselines.descent import DescentSolver

if TYPE_CHECKING:
    from robots import Robot


class PinocchioDls(DescentSolver):
    """Damped least squares in Python, one query at a time, joints clamped to their limits.

    Args:
        robot: The robot to solve for.
        damping: Constant part of the damping, added to the diagonal of J Jᵀ [m² and rad²].
        damping_gain: Damping per squared error (m² + rad²).
        **descent: Tolerances, restarts and budget, see `DescentSolver`.
    """

    mimics: ClassVar[bool] = False

    def __init__(
        self, robot: Robot, *, damping: float, damping_gain: float, **descent: Any
    ) -> None:
        super().__init__(robot, **descent)
        self.damping, self.damping_gain = damping_settings(damping, damping_gain)
        self._model, self._frame = robot.pinocchio()
        self._data = self._model.createData()
        self._error = np.empty(6)
        self._distance, self._rotation = self._error[:3], self._error[3:]

    def _aim(self, pose: NDArray[np.float64]) -> None:
        w, x, y, z = pose[3:]
        self._target = pinocchio.SE3(pinocchio.Quaternion(w, x, y, z), pose[:3])

    def _place(self, joints: NDArray[np.float64]) -> None:
        self._q = joints

    def _joints(self) -> NDArray[np.float64]:
        return self._q

    def _errors(self) -> tuple[float, float]:
        pinocchio.forwardKinematics(self._model, self._data, self._q)
        pinocchio.updateFramePlacement(self._model, self._data, self._frame)
        difference = self._data.oMf[self._frame].actInv(self._target)
        # Axes of the tip, as in Pinocchio's local frame Jacobian.
        self._distance[:] = difference.translation
        self._rotation[:] = pinocchio.log3(difference.rotation)
        return (
            math.sqrt(self._distance.dot(self._distance)),
            math.sqrt(self._rotation.dot(self._rotation)),
        )

    def _step(self) -> None:
        """Jᵀ (J Jᵀ + λ I)⁻¹ e, clamped to the limits."""
        jacobian = pinocchio.computeFrameJacobian(self._model, self._data, self._q, self._frame)
        jacobian = jacobian.reshape(6, -1)  # the library gives a vector for a single joint
        normal = jacobian @ jacobian.T
        normal.flat[::7] += self.damping + self.damping_gain * (self._error @ self._error)
        step = jacobian.T @ np.linalg.solve(normal, self._error)
        self._q = np.minimum(np.maximum(self._q + step, self.lower), self.upper)
