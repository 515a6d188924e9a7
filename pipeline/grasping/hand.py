"""Hands that close by force: two-finger grippers and tendon-driven fingers.

A tendon is modelled by what it does at the joints: one tension T pulls all joints of a finger, each
with the torque T times its pulley's radius. A joint that is blocked saturates at that torque while
the others go on closing, so the finger wraps around what it meets.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet

from pipeline.grasping.config import HandConfig
from pipeline.grasping.errors import GraspError

KINDS = ("gripper", "tendon")


class Hand:
    """The hand of a robot in the simulation.

    Attributes:
        links: Links of the hand that may touch an object, by PyBullet's index.
        fingers: Joints of each finger from the palm outward, by PyBullet's index.
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
            self.fingers = [[joints[name]] for name in description["joints"]]
            self.held: dict[int, float] = {}
        else:
            self.fingers = [
                [joints[name] for name in names]
                for names in description["tendons"].values()
                if not set(names) & set(config.preshape)
            ]
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

    def close(self) -> None:
        """Pull the tendons: joints run towards closed with no more than the tension's torque."""
        sign = float(np.sign(self.closed - self.open))
        force = self.config.tension * self.pulley
        for finger in self.fingers:
            for joint, ratio in zip(finger, self.config.ratios, strict=False):
                self.client.setJointMotorControl2(
                    self.body,
                    joint,
                    pybullet.VELOCITY_CONTROL,
                    targetVelocity=sign * self.config.speed * ratio,
                    force=force,
                )

    def speed(self) -> float:
        """Speed of the fastest finger joint [rad/s or m/s]."""
        states = self.client.getJointStates(self.body, self.moving)
        return float(max(abs(state[1]) for state in states))

    def touching(self, thing: int) -> set[int]:
        """Links of the hand that touch a body."""
        contacts = self.client.getContactPoints(bodyA=self.body, bodyB=thing)
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
