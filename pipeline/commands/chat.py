"""`chat`: talk to a robot at its table in the simulator, by text or by speech."""

from __future__ import annotations

from dataclasses import replace

from pipeline.commands.arguments import command_parser, with_defaults
from pipeline.config import compose
from pipeline.errors import PipelineError

DESCRIPTION = """\
chat robot=nicol [agent=policy|endpoint|local] [perception=camera|perfect] [key=value ...]

A robot stands at its table with all objects of its set on a row. Type what it is to do, the name of
a WAV file with a recorded instruction, or `listen` for the microphone; `quit` ends. It answers with
what it says and does, and a transcript is kept in chat/<robot> of the results folder. Headless
unless grasp.gui=true; another seed= lays another row.
"""
DEFAULTS = {"perception": "camera", "agent": "policy", "robot": "nicol"}


def chat(arguments: list[str]) -> int:
    """Run one conversation on standard input and output."""
    overrides = command_parser("chat", DESCRIPTION).takes_overrides().parse(arguments).overrides
    config = compose(with_defaults(overrides, DEFAULTS))
    from pipeline.commands.conversation import converse  # the simulator takes seconds to load
    from pipeline.stages.inputs import robot_of

    robot = robot_of(config)
    if config.perception.source == "camera" and robot.description.camera is None:
        if any(override.startswith("perception=") for override in overrides):
            raise PipelineError(f"robot '{robot.name}' has no camera: choose perception=perfect")
        config = replace(config, perception=replace(config.perception, source="perfect"))
        print(f"{robot.name} has no camera: the simulator gives it the places of the objects.")
    converse(config, robot)
    return 0
