"""The body of an agent: actions become motions in the simulator or events of the log."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.grasping.arm import Arm
from pipeline.grasping.config import GraspConfig
from pipeline.grasping.grasp import Grasp
from pipeline.grasping.outcome import SUCCESS, ActionResult, GraspReport, classify
from pipeline.grasping.point import Point
from pipeline.grasping.push import Push
from pipeline.grasping.scene import Scene

if TYPE_CHECKING:
    from baselines import Solver

Array = NDArray[np.float64]


class Body:
    """An arm that carries out one action after another; a failure is a deed with a reason.

    Attributes:
        report: What happened in the last grasp.
    """

    def __init__(
        self, scene: Scene, config: GraspConfig, solver: Solver, repair: Solver | None = None
    ) -> None:
        """Take the scene, in which the arm is at idle."""
        self.scene, self.config = scene, config
        self.arm = Arm(scene, config, solver, repair)
        self.report = GraspReport()

    def act(self, kind: str, place: Array, name: str, object_id: int) -> ActionResult:
        """Grasp, push or point at what is believed to be at a place.

        Args:
            kind: `grasp`, `push` or `point`.
            place: Believed centre, base frame [m], shape (3,).
            name: What is believed to be there, which says how high it is.
            object_id: PyBullet's number of the body that the outcome is judged by.

        Returns:
            Its result; the arm is at idle again.
        """
        self.scene.object_id = object_id
        if kind == "grasp":
            result = self._grasp(grip_point(self.config, self.scene, place, name))
        elif kind == "push":
            result = Push(self.arm).run(place)
        else:
            result = Point(self.arm).run(place)
        self.arm.retreat()
        return result

    def _grasp(self, place: Array) -> ActionResult:
        self.report = Grasp(self.arm).run(place)
        outcome, reason = classify(self.report)
        return ActionResult(outcome == SUCCESS, reason)


def grip_point(config: GraspConfig, scene: Scene, place: Array, name: str) -> Array:
    """The point to grasp an object around: its centre, or higher where the hand goes less deep."""
    point = place.copy()
    top = point[2] + 0.5 * config.objects[name].height
    point[2] = max(point[2], top - scene.config.grip.depth)
    return point
