"""A guard around the physics engine: once it runs, nothing is glued, put or pushed by hand."""

from __future__ import annotations

from functools import partial
from typing import Any

import pybullet
import pytest
from pybullet_utils.bullet_client import BulletClient

from pipeline.grasping import scene as scene_module

FORBIDDEN = ("createConstraint", "resetBasePositionAndOrientation", "resetBaseVelocity")
LATE = ("resetJointState", "createMultiBody", "restoreState", "setCollisionFilterPair")
LATE += ("applyExternalForce", "applyExternalTorque", "changeDynamics", "loadURDF")


def guard(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Refuse calls that would move or hold an object by other means than joints and contacts.

    Args:
        monkeypatch: Of the test.

    Returns:
        A list that grows by one with every step of the simulation.
    """
    running: list[bool] = []

    def refuse(name: str, only_late: bool) -> None:
        original = getattr(pybullet, name)

        def call(*arguments: Any, **keywords: Any) -> Any:
            assert only_late and not running, f"{name} was called"
            return original(*arguments, **keywords)

        monkeypatch.setattr(pybullet, name, call)

    of_client = BulletClient.__getattr__

    def bound(self: BulletClient, name: str) -> Any:
        # A BulletClient binds its own number to PyBullet's builtins only, not to what stands in
        # for them here: unbound, a call would go to whichever client is number 0.
        found = of_client(self, name)
        watched = name in (*FORBIDDEN, *LATE)
        return partial(found, physicsClientId=self._client) if watched else found

    monkeypatch.setattr(BulletClient, "__getattr__", bound)
    for name in FORBIDDEN:
        refuse(name, only_late=False)
    for name in LATE:
        refuse(name, only_late=True)
    step = scene_module.Scene.step

    def first_step(self: scene_module.Scene) -> None:
        running.append(True)
        step(self)

    monkeypatch.setattr(scene_module.Scene, "step", first_step)
    return running
