"""The simulated world: table, bins, robot and the objects to grasp."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pybullet
from numpy.typing import ArrayLike, NDArray
from pybullet_utils.bullet_client import BulletClient

from pipeline.errors import GraspError
from pipeline.grasping.config import BinConfig, ObjectConfig, PhysicsConfig, SceneConfig
from pipeline.grasping.hand import Hand
from pipeline.grasping.hardware import Hardware
from pipeline.grasping.idle_joints import fix_idle_joints
from pipeline.grasping.shapes import make_bin, make_object, make_table
from pipeline.seeding import derive_seed
from robots.native_output import stdout_elsewhere

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
GRAVITY = 9.81  # m/s^2
GOAL_GAIN = 0.2  # share of the position error removed in a step; higher gains ring


class Scene:
    """A robot at its table.

    The world frame is the robot's base frame. After `settle` nothing is put anywhere any more:
    everything moves by forces of joints and contacts alone.

    Attributes:
        client: PyBullet client.
        hand: The robot's hand.
        object_id: PyBullet's number of the body that is to be grasped, pushed or pointed at now.
        time_s: Simulated time [s].
        on_step: Called after every step, for cameras.
        on_phase: Called with the name of each phase of a trial that has ended, for cameras.
    """

    def __init__(
        self,
        robot: Robot,
        config: SceneConfig,
        physics: PhysicsConfig,
        gui: bool = False,
        hardware: Hardware | None = None,
    ) -> None:
        """Build the world without the object to grasp.

        Args:
            robot: The robot.
            config: Its table, bins and hand.
            physics: The engine's accuracy.
            gui: Whether to open a window.
            hardware: Errors of the arm and of the objects' masses; None for none.

        Raises:
            GraspError: If the robot has no hand or its base does not carry its whole body.
        """
        if robot.description.hand is None:
            raise GraspError(f"robot '{robot.name}' has no hand in its robot.yaml: it cannot grasp")
        self.robot, self.config, self.physics = robot, config, physics
        self._hardware = Hardware.perfect(robot.dof) if hardware is None else hardware
        self.client: Any = _connect(gui)
        try:
            self._build()
        except BaseException:
            self.client.disconnect()
            raise
        self._noise = np.random.default_rng(derive_seed(physics.noise_seed, "placement noise"))
        self.object_id = -1
        self.time_s = 0.0
        self.on_step: Callable[[], None] | None = None
        self.on_phase: Callable[[str], None] | None = None

    def __enter__(self) -> Scene:
        return self

    def __exit__(self, *_: object) -> None:
        self.client.disconnect()

    def lay(self, obj: ObjectConfig, place: ArrayLike, yaw: float) -> int:
        """Lay an object on the table; it is then the one that the scene is about.

        Args:
            obj: What to lay.
            place: x and y, base frame [m]; the noise of the physics is added.
            yaw: Rotation about the vertical [rad].

        Returns:
            PyBullet's number of the body.
        """
        angle = self._noise.uniform(0.0, 2.0 * np.pi)
        off = self.physics.placement_noise * np.array([np.cos(angle), np.sin(angle)])
        there = np.asarray(place, dtype=np.float64)[:2] + off
        weighed = replace(obj, mass=self._hardware.weigh(obj.mass))
        self.object_id = make_object(self.client, weighed, there, yaw, self.config.table.height)
        return self.object_id

    def step(self) -> None:
        """Advance the simulation by one step."""
        self.client.stepSimulation()
        self.time_s += 1.0 / self.physics.rate
        if self.on_step is not None:
            self.on_step()

    def wait(self, seconds: float) -> None:
        """Let time go by."""
        for _ in range(round(seconds * self.physics.rate)):
            self.step()

    def mark(self, phase: str) -> None:
        """Mark that a phase of the trial has ended."""
        if self.on_phase is not None:
            self.on_phase(phase)

    def command(self, joints: Array, velocities: Array | None = None) -> None:
        """Drive the arm towards joint positions with no more than its rated efforts.

        Args:
            joints: Positions [rad or m], shape (dof,).
            velocities: Speeds to have there [rad/s or m/s], shape (dof,); none is rest.
        """
        joints, velocities = self._hardware.follow(joints, velocities)
        self.client.setJointMotorControlArray(
            self.body,
            self.arm,
            pybullet.POSITION_CONTROL,
            targetPositions=joints,
            targetVelocities=np.zeros(len(joints)) if velocities is None else velocities,
            forces=self.effort,
            positionGains=[GOAL_GAIN] * len(joints),
            velocityGains=[1.0] * len(joints),
        )

    def joints(self) -> Array:
        """Where the arm's joints are [rad or m], shape (dof,)."""
        return np.array([state[0] for state in self.client.getJointStates(self.body, self.arm)])

    def tip_position(self) -> Array:
        """Where the arm's tip is, base frame [m], shape (3,)."""
        position: Array = self.robot.forward_kinematics(self.joints()[None])[0, :3]
        return position

    def object_position(self) -> Array:
        """Centre of the object, base frame [m], shape (3,)."""
        return np.array(self.client.getBasePositionAndOrientation(self.object_id)[0])

    def object_velocity(self) -> float:
        """Speed of the object [m/s]."""
        return float(np.linalg.norm(self.client.getBaseVelocity(self.object_id)[0]))

    def bin_of_object(self) -> str | None:
        """Name of the bin that the object lies in, if any."""
        position = self.object_position()
        for name, box in self.config.bins.items():
            if inside(box, position):
                return name
        return None

    def _build(self) -> None:
        self.client.setGravity(0.0, 0.0, -GRAVITY)
        self.client.setPhysicsEngineParameter(
            fixedTimeStep=1.0 / self.physics.rate,
            numSolverIterations=self.physics.iterations,
            deterministicOverlappingPairs=1,
        )
        make_table(self.client, self.config.table)
        for box in self.config.bins.values():
            make_bin(self.client, box)
        self._load_robot()

    def _load_robot(self) -> None:
        robot = self.robot
        with fix_idle_joints(robot) as path:
            self.body = self.client.loadURDF(str(path), useFixedBase=True)
        joints: dict[str, int] = {}
        efforts: dict[int, float] = {}
        for index in range(self.client.getNumJoints(self.body)):
            info = self.client.getJointInfo(self.body, index)
            joints[info[1].decode()] = index
            efforts[index] = info[10]
        root = self.client.getBodyInfo(self.body)[0].decode()
        if root != robot.base:
            raise GraspError(
                f"the grasp scene expects the base of '{robot.name}' to be the URDF's root "
                f"'{root}', got '{robot.base}'"
            )
        self.arm = [joints[name] for name in robot.joint_names]
        self.effort = [efforts[index] for index in self.arm]
        self._pose_body(joints, efforts)
        description = robot.description.hand
        assert description is not None
        self.hand = Hand(self.client, self.body, joints, description, self.config.hand)
        self.hand.reset_open()
        self._roughen_table()
        self.command(robot.home)

    def _roughen_table(self) -> None:
        """Where the table is part of the robot's description: a ball on it comes to rest again.

        Bullet adds the products of each body's rolling friction with the other's lateral one; with
        none on the table's side a nudged ball rolls on for ever.
        """
        rolling = self.config.table.rolling_friction
        if rolling is None:
            return
        for link in range(-1, self.client.getNumJoints(self.body)):
            if link not in self.hand.links:
                self.client.changeDynamics(self.body, link, rollingFriction=rolling)

    def _pose_body(self, joints: dict[str, int], efforts: dict[int, float]) -> None:
        """Start at home, the joints of the hand at the description's posture."""
        home = dict(zip(self.arm, self.robot.home, strict=True))
        posture = {joints[name]: at for name, at in self.robot.description.posture.items()}
        for index in joints.values():
            if self.client.getJointInfo(self.body, index)[2] == pybullet.JOINT_FIXED:
                continue
            position = home.get(index, posture.get(index, 0.0))
            self.client.resetJointState(self.body, index, position)
            self.client.setJointMotorControl2(
                self.body,
                index,
                pybullet.POSITION_CONTROL,
                targetPosition=position,
                force=efforts[index],
            )


def _connect(gui: bool) -> Any:
    """Start the engine, which prints its arguments; what a window complains of is shown."""
    with stdout_elsewhere(shown=gui):
        return BulletClient(pybullet.GUI if gui else pybullet.DIRECT)


def inside(box: BinConfig, position: ArrayLike) -> bool:
    """Whether a point is within the walls and not above the rim of a bin."""
    offset = np.asarray(position, dtype=np.float64) - [*box.centre, box.floor]
    length, width, height = box.size
    return bool(
        abs(offset[0]) < 0.5 * length and abs(offset[1]) < 0.5 * width and 0 < offset[2] < height
    )
