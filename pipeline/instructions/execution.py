"""Instructions of the suite carried out: what is right as a plan may still fail as a deed.

An agent plans for what the suite says is in view. Then these things are laid on a robot's table,
the scene moved as a whole to the middle of its action area, and the body does what was planned, in
physics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.agent import Agent, Turn
from pipeline.embodiment.body import Body
from pipeline.embodiment.perception import Perception
from pipeline.embodiment.row import resting_yaw
from pipeline.embodiment.scene_objects import SceneObjects
from pipeline.embodiment.session import Event, Session
from pipeline.grasping.config import GraspConfig, SceneConfig
from pipeline.grasping.placements import Setup
from pipeline.grasping.scene import Scene
from pipeline.grasping.trial import required_scene
from pipeline.instructions.plans import done_of
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
        perception: How the table is seen.
    """

    robot: Robot
    config: GraspConfig
    solver: Solver
    repair: Solver | None
    perception: Perception

    @property
    def solvers(self) -> list[Solver]:
        """The solvers of the motions."""
        return [self.solver] if self.repair is None else [self.solver, self.repair]

    def carry_out(self, instruction: Instruction, turn: Turn, agent: Agent) -> list[Event]:
        """Lay the things of an instruction, and do what an agent's reply to it says."""
        scene_config = required_scene(self.config, self.robot.name)
        with Scene(self.robot, scene_config, self.config.physics, self.config.gui) as scene:
            setups = laid_out(instruction, self.config, scene_config)
            objects = SceneObjects(scene, self.config, setups)
            scene.wait(self.config.physics.settle_s)
            body = Body(scene, self.config, self.solver, self.repair)
            located = self.config.protocol.located
            session = Session(agent, body, self.perception, objects, located)
            return session.do(turn.actions, session.look())


def laid_out(instruction: Instruction, config: GraspConfig, scene: SceneConfig) -> list[Setup]:
    """What to lay where for an instruction, in the middle of a scene's action area.

    Args:
        instruction: Says what is in view, and where in the suite's own frame.
        config: Has the objects.
        scene: Has the area.
    """
    if not instruction.seen:
        return []
    places = np.array([each.position for each in instruction.seen])
    area = np.array([scene.area.x, scene.area.y])
    moved = places + area.mean(axis=1) - 0.5 * (places.min(axis=0) + places.max(axis=0))
    return [
        Setup(
            number=number,
            row=0,
            name=each.name,
            place=(float(place[0]), float(place[1])),
            yaw=resting_yaw(config, scene, each.name, 0.0, (float(place[0]), float(place[1]))),
            error=np.zeros(2),
        )
        for number, (each, place) in enumerate(zip(instruction.seen, moved, strict=True))
    ]


def executed_rows(
    instructions: list[Instruction], agent: Callable[[], Agent], name: str, world: World
) -> Iterator[dict[str, Any]]:
    """Yield one raw row for each instruction, carried out.

    Beside the columns of the plan: `executed`, whether the plan was right and every action of it
    was done; `failed`, the first action that was not, and why; `lasted_s` of simulated time.

    Args:
        instructions: Of the suite.
        agent: Begins a conversation, one an instruction.
        name: How the agent is called in the rows.
        world: Where it acts.
    """
    for each in instructions:
        speaker = agent()
        turn = speaker.instruct(each.says, each.seen)
        row = row_of(each, turn, name)
        events = world.carry_out(each, turn, speaker) if done_of(turn) else []
        failed = [event for event in events if not event.result.done]
        said = [
            f"{event.action.kind} {event.action.target}: {event.result.words}" for event in failed
        ]
        yield row | {
            "robot": world.robot.name,
            "solver": world.solver.name,
            "executed": row["class"] == RIGHT and not failed,
            "failed": said[0] if said else "",
            "lasted_s": float(sum(event.lasted_s for event in events)),
        }
