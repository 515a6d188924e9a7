"""The shake after the lift: how far the hand sways, and what comes of what it loses."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pipeline.grasping.arm import MotionAborted
from pipeline.grasping.grasp import Grasp
from pipeline.grasping.outcome import SLIPPED, classify

TARGET = np.array([0.0, 0.5, 1.0])


class Scene:
    """A scene whose object hangs in the hand until the arm has been shaken, or for good."""

    def __init__(self, holds: bool) -> None:
        self.holds, self.shaken, self.phases = holds, False, [""]
        self.object_id = 7
        self.hand = SimpleNamespace(touching=lambda _: {1, 2} if self.is_held() else set())
        self.mark = self.phases.append

    def is_held(self) -> bool:
        return self.holds or not self.shaken

    def object_position(self) -> Any:
        return np.array([0.0, 0.0, 0.1 if self.is_held() else 0.0])


def grasp_in(scene: Scene, angle: float) -> tuple[Grasp, list[Any]]:
    """An attempt after the fingers have closed; and the waypoints that the arm follows."""
    followed: list[Any] = []

    def follow(waypoints: Any, speed: float) -> None:
        followed.append(waypoints)
        scene.shaken = True

    arm: Any = SimpleNamespace(
        begin=lambda: None,
        move=lambda *_: None,
        follow=follow,
        scene=scene,
        target=TARGET,
        robot=SimpleNamespace(dof=3, lower=np.full(3, -1.0), upper=np.full(3, 1.0)),
        config=SimpleNamespace(
            shake_after_lift=angle, lift_threshold=0.03, timing=SimpleNamespace(swing=1.0)
        ),
        grip=None,
        motions={},
        swung=[],
    )
    attempt = Grasp(arm)
    attempt._rest = 0.0
    return attempt, followed


def test_the_last_two_joints_sway_to_either_side_within_their_limits() -> None:
    scene = Scene(holds=True)
    attempt, followed = grasp_in(scene, 0.2)
    attempt._lift(TARGET)
    (waypoints,) = followed
    assert_allclose(waypoints[:, 0], 0.0)  # the others stay
    assert_allclose(waypoints[1] - waypoints[2], [0.0, 0.4, 0.4])
    assert waypoints.max() <= 1.0  # the last joint was at its limit
    assert_allclose(waypoints[[0, -1]], [TARGET, TARGET])
    assert attempt.report.lifted
    assert scene.phases[-1] == "shaken"


def test_what_is_lost_by_it_has_slipped() -> None:
    attempt, _ = grasp_in(Scene(holds=False), 0.2)
    with pytest.raises(MotionAborted, match="lost when the hand was shaken") as lost:
        attempt._lift(TARGET)
    attempt.report.stopped = str(lost.value)  # as `run` notes it
    assert classify(attempt.report) == (SLIPPED, "lost when the hand was shaken")


def test_without_an_angle_nobody_shakes() -> None:
    attempt, followed = grasp_in(Scene(holds=False), 0.0)
    attempt._lift(TARGET)
    assert followed == []
