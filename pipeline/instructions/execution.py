"""Instructions of the suite carried out: what is right as a plan may still fail as a deed.

An agent plans for what the suite says is in view. Then these things are laid on a robot's table,
the scene moved as a whole to the middle of its action area, and the body does what was planned, in
physics, at places that the simulator tells.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.agent import Agent, Turn
from pipeline.embodiment.body import Body
from pipeline.embodiment.perception import GroundTruthPerception
from pipeline.embodiment.row import resting_yaw
from pipeline.embodiment.scene_objects import SceneObjects
from pipeline.embodiment.session import Event, Session
from pipeline.grasping.config import GraspConfig, SceneConfig
from pipeline.grasping.hardware import Hardware
from pipeline.grasping.placements import Setup
from pipeline.grasping.scene import Scene
from pipeline.grasping.trial import required_scene
from pipeline.instructions.plans import SuiteError, done_of
from pipeline.instructions.suite import Instruction, row_of

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

RIGHT = "right"  # the class of a plan that fulfils its instruction


@dataclass(frozen=True)
class World:
    """A robot at its table.

    Attributes:
        robot: The robot.
        config: Of its grasps.
        solver: Inverse kinematics of its motions.
        repair: Solver that mends their waypoints, or None.
        seed: Root seed of the hardware's errors.
    """

    robot: Robot
    config: GraspConfig
    solver: Solver
    repair: Solver | None
    seed: int

    @property
    def solvers(self) -> list[Solver]:
        """The solvers of the motions."""
        return [self.solver] if self.repair is None else [self.solver, self.repair]

    def carry_out(self, instruction: Instruction, turn: Turn, agent: Agent) -> list[Event]:
        """Lay the things of an instruction, and do what an agent's reply to it says."""
        scene_config, config = required_scene(self.config, self.robot.name), self.config
        hardware = Hardware.drawn(config.hardware, self.robot, self.seed, instruction.number)
        with Scene(self.robot, scene_config, config.physics, config.gui, hardware) as scene:
            setups = laid_out(instruction, self.config, scene_config)
            objects = SceneObjects(scene, self.config, setups)
            scene.wait(self.config.physics.settle_s)
            body = Body(scene, self.config, self.solver, self.repair)
            located = self.config.protocol.located
            sight = GroundTruthPerception(self.config.protocol.bin_margin)
            session = Session(agent, body, sight, objects, located)
            return session.do(turn.actions, session.look())

    def check(self, instruction: Instruction) -> None:
        """Refuse an instruction whose scene does not fit on the robot's table.

        Raises:
            SuiteError: A bin stands where something is to lie.
        """
        laid_out(instruction, self.config, required_scene(self.config, self.robot.name))

    def row(self, instruction: Instruction, agent: Agent, name: str) -> dict[str, Any]:
        """Return the raw row of an instruction that an agent plans and the body carries out.

        Beside the columns of the plan: `executed`, whether the plan was right and every action of
        it was done; `failed`, the first action that was not, and why; `lasted_s` of simulated time.

        Args:
            instruction: Of the suite.
            agent: A conversation that begins.
            name: How the agent is called in the row.
        """
        turn = agent.instruct(instruction.says, instruction.seen)
        planned = row_of(instruction, turn, name)
        events = self.carry_out(instruction, turn, agent) if done_of(turn) else []
        failed = [event for event in events if not event.result.done]
        said = [
            f"{event.action.kind} {event.action.target}: {event.result.words}" for event in failed
        ]
        return planned | {
            "robot": self.robot.name,
            "solver": self.solver.name,
            "executed": planned["class"] == RIGHT and not failed,
            "failed": said[0] if said else "",
            "lasted_s": float(sum(event.lasted_s for event in events)),
        }


def laid_out(instruction: Instruction, config: GraspConfig, scene: SceneConfig) -> list[Setup]:
    """What to lay where for an instruction, in the middle of a scene's action area.

    Args:
        instruction: Says what is in view, and where in the suite's own frame.
        config: Has the objects.
        scene: Has the area and the bins.

    Raises:
        SuiteError: A bin stands where something is to lie.
    """
    if not instruction.seen:
        return []
    places = np.array([each.position for each in instruction.seen])
    area = np.array([scene.area.x, scene.area.y])
    moved = places + area.mean(axis=1) - 0.5 * (places.min(axis=0) + places.max(axis=0))
    for each, place in zip(instruction.seen, moved, strict=True):
        for side, box in scene.bins.items():
            reserved = 0.5 * np.array(box.size[:2]) + config.protocol.bin_margin
            if (np.abs(place - box.centre) < reserved).all():
                raise SuiteError(
                    f"the scene {instruction.scene} does not fit on this table: the {each.name} "
                    f"would lie in the {side} bin; choose another robot, such as robot=nicol"
                )
    return [
        Setup(
            number=number,
            row=0,
            name=each.name,
            place=(x, y),
            yaw=resting_yaw(config, scene, each.name, 0.0, (x, y)),
            error=np.zeros(2),
        )
        for number, (each, (x, y)) in enumerate(zip(instruction.seen, moved.tolist(), strict=True))
    ]
