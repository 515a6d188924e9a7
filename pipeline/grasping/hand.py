"""Hands that close by force: two-finger grippers and tendon-driven fingers.

A tendon is modelled by what it does at the joints: one tension T pulls all joints of a finger, each
with the torque T times its pulley's radius. A joint that is blocked saturates at that torque while
the others keep closing, so the finger wraps around what it meets.

The segments of a finger weigh a few grams, and bodies that light under such a torque are thrown
through joint limits and objects within one step. What keeps a real finger from that is the inertia
of its drive, seen through the gear; it is added to every segment as `drive_inertia`.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np
import pybullet
from numpy.typing import NDArray

from pipeline.errors import GraspError
from pipeline.grasping.config import HandConfig

KINDS = ("gripper", "tendon")


class Hand:
    """The hand of a robot in the simulation.

    Attributes:
        links: Links of the hand that may touch an object, by PyBullet's index.
        fingers: Joints of each finger from the palm outward, by PyBullet's index.
        names: Name of each finger, in the order of `fingers`: that of its tendon or joint.
    """

    def __init__(
        self,
        client: Any,
        body: int,
        joints: dict[str, int],
        description: dict[str, Any],
        config: HandConfig,
    ) -> None:
        """Find the hand's joints and links and give its skin friction.

        Args:
            client: PyBullet client.
            body: The robot.
            joints: PyBullet's index of every joint by its name; a link has its joint's index.
            description: `hand` of the robot's description.
            config: Tension, speeds, friction.

        Raises:
            GraspError: If the description names no known kind of hand.
        """
        if description.get("kind") not in KINDS:
            raise GraspError(
                f"hand.kind must be one of {', '.join(KINDS)} to grasp, got "
                f"'{description.get('kind')}' in robot.yaml"
            )
        self.client, self.body, self.config = client, body, config
        self.gripper = description["kind"] == "gripper"
        if self.gripper:
            self.names = [*description["joints"]]
            self.fingers = [[joints[name]] for name in self.names]
            self.held: dict[int, float] = {}
        else:
            pulled = {
                finger: names
                for finger, names in description["tendons"].items()
                if not set(names) & set(config.preshape)
            }
            self.names = [*pulled]
            self.fingers = [[joints[name] for name in names] for names in pulled.values()]
            self.held = {joints[name]: angle for name, angle in config.preshape.items()}
        self.open, self.closed = float(description["open"]), float(description["closed"])
        self.pulley = 1.0 if self.gripper else float(description["pulley_radius"])
        self.links = self._links(description["links"])
        for link in self.links:
            client.changeDynamics(
                body,
                link,
                lateralFriction=config.friction,
                spinningFriction=1e-3,
                rollingFriction=1e-4,
                frictionAnchor=1,
            )
        self.moving = [joint for finger in self.fingers for joint in finger]
        for joint in self.moving:
            inertia = np.array(client.getDynamicsInfo(body, joint)[2]) + config.drive_inertia
            client.changeDynamics(body, joint, localInertiaDiagonal=inertia.tolist())

    def reset_open(self) -> None:
        """Start with open fingers; only before the simulation runs."""
        for joint in self.moving:
            self.client.resetJointState(self.body, joint, self.open)
        for joint, angle in self.held.items():
            self.client.resetJointState(self.body, joint, angle)
        self.let_go()

    def let_go(self) -> None:
        """Drive every finger to its open position."""
        for joint in self.moving:
            self._hold(joint, self.open)
        for joint, angle in self.held.items():
            self._hold(joint, angle)

    def close(self, stretched: Collection[str] = ()) -> None:
        """Pull the tendons: joints run towards closed with no more than the tension's torque.

        Args:
            stretched: Names of fingers that are left open, to point with.
        """
        force = self.config.tension * self.pulley
        for name, finger in zip(self.names, self.fingers, strict=True):
            if name in stretched:
                continue
            for joint, ratio in zip(finger, self.config.ratios, strict=False):
                self.client.setJointMotorControl2(
                    self.body,
                    joint,
                    pybullet.POSITION_CONTROL,
                    targetPosition=self.closed,
                    force=force,
                    maxVelocity=self.config.speed * ratio,
                )

    def positions(self) -> NDArray[np.float64]:
        """Where the finger joints are [rad or m], in the order of `moving`."""
        states = self.client.getJointStates(self.body, self.moving)
        return np.array([state[0] for state in states])

    def touching(self, object_id: int) -> set[int]:
        """Links of the hand that touch a body."""
        contacts = self.client.getContactPoints(bodyA=self.body, bodyB=object_id)
        return {contact[3] for contact in contacts} & set(self.links)

    def _hold(self, joint: int, angle: float) -> None:
        self.client.setJointMotorControl2(
            self.body,
            joint,
            pybullet.POSITION_CONTROL,
            targetPosition=angle,
            force=max(self.config.tension * self.pulley, 1e-3) * 2.0,
            maxVelocity=2.0 * self.config.speed,
        )

    def _links(self, names: list[str]) -> list[int]:
        wanted, found = set(names), []
        for index in range(self.client.getNumJoints(self.body)):
            if self.client.getJointInfo(self.body, index)[12].decode() in wanted:
                found.append(index)
        return found
