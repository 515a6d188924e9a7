"""A conversation on standard input and output with a robot in the simulator."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

from pipeline.agent.loading import load_agent
from pipeline.embodiment.body import Body
from pipeline.embodiment.chat import Chat
from pipeline.embodiment.perception import make_perception
from pipeline.embodiment.row import row_setup
from pipeline.embodiment.scene_objects import SceneObjects
from pipeline.embodiment.session import Session
from pipeline.grasping.hardware import Hardware
from pipeline.grasping.scene import Scene
from pipeline.grasping.trial import required_scene
from pipeline.settings import Config
from pipeline.solvers import check_solvers
from pipeline.speech import load_recogniser, load_synthesiser
from pipeline.speech.microphone import record
from pipeline.stages.eyes import detector_of
from pipeline.stages.graph import STAGES
from pipeline.stages.inputs import artifacts
from pipeline.stages.running import with_weights
from pipeline.stages.solvers import solver_of
from robots import Robot

PROMPT = "> "


def converse(config: Config, robot: Robot) -> None:
    """Lay the table, and answer line after line until the person says goodbye.

    Args:
        config: Scene, senses, agent and speech.
        robot: The robot of the conversation.

    Raises:
        PipelineError: The robot has no scene, or its detector or its agent is missing.
    """
    grasp = config.grasp
    scene_config = required_scene(grasp, robot.name)
    check_solvers({"grasp.solver": [grasp.solver]}, robot)
    config = with_weights(config, STAGES["grasp"].solver_names(config))
    solver = solver_of(grasp.solver, robot, config)
    repair = solver_of(grasp.repair, robot, config) if grasp.repair else None
    detector = detector_of(robot, config) if config.perception.source == "camera" else None
    perception = make_perception(config.perception, grasp, robot, detector, config.seed)
    agent = load_agent(config.agent, robot.name)
    hardware = Hardware.drawn(grasp.hardware, robot, config.seed, 0)
    with Scene(robot, scene_config, grasp.physics, grasp.gui, hardware) as scene:
        objects = SceneObjects(scene, grasp, row_setup(grasp, robot.name, 0, config.seed))
        scene.wait(grasp.physics.settle_s)
        body = Body(scene, grasp, solver, repair)
        session = Session(agent, body, perception, objects, grasp.protocol.located)
        conversation = Chat(
            session,
            robot.name.upper(),
            _transcript(config),
            lambda text: print(text, flush=True),
            lambda: load_recogniser(
                config.speech, config.agent.vocabulary, scene_config.objects, [robot.name]
            ),
            lambda: load_synthesiser(config.speech),
            lambda wav: record(config.speech.microphone, wav),
        )
        conversation.show_table()
        print("`help` says what can be said, `quit` ends.", flush=True)
        try:
            while conversation.line(_ask()):
                pass
        finally:
            conversation.keep()
            print(conversation.transcript)


def _ask() -> str:
    """One line of the person's; the end of the input is a goodbye, what is no text is nothing."""
    try:
        return input(PROMPT)
    except UnicodeDecodeError:
        return ""
    except EOFError:
        print()
        return "quit"


def _transcript(config: Config) -> Path:
    stamp = datetime.now(UTC).strftime("%Y%m%d-%H%M%S-%f")  # two in one second are two
    return artifacts(config).chat(config.robot.name) / f"{stamp}.jsonl"
