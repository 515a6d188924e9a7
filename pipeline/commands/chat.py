"""`chat`: talk to a robot at its table in the simulator, by text or by speech."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from pipeline.config import compose
from pipeline.errors import PipelineError

HELP = """\
python -m pipeline chat robot=nicol [agent=policy|endpoint] [perception=camera|perfect] [key=value]

A robot stands at its table with all things of its set on a row. Type what it is to do, the name of
a WAV file with a spoken instruction, or `listen` for the microphone; `quit` ends. It answers with
what it says and does, and a transcript is kept in chat/<robot> of the results folder. Headless
unless grasp.gui=true; another seed= lays another row.
"""


def chat(arguments: list[str]) -> int:
    """Run one conversation on standard input and output."""
    if any(flag in arguments for flag in ("-h", "--help")):
        print(HELP, end="")
        return 0
    for argument in arguments:
        if argument.startswith("-"):
            raise PipelineError(f"there is no option {argument}; overrides read key=value")
    config = compose(with_defaults(arguments))
    from pipeline.commands.conversation import converse  # the simulator takes seconds to load
    from pipeline.stages.inputs import robot_of

    robot = robot_of(config)
    if config.perception.source == "camera" and robot.description.camera is None:
        if any(argument.startswith("perception=") for argument in arguments):
            raise PipelineError(f"robot '{robot.name}' has no camera: choose perception=perfect")
        config = replace(config, perception=replace(config.perception, source="perfect"))
        print(f"{robot.name} has no camera: the simulator tells it what lies where.")
    converse(config, robot)
    return 0


def with_defaults(arguments: Sequence[str]) -> list[str]:
    """The overrides, with a camera and the embedded policy where they choose nothing else."""
    chosen = {argument.partition("=")[0] for argument in arguments}
    wanted = {"perception": "camera", "agent": "policy", "robot": "nicol"}
    return [*(f"{k}={v}" for k, v in wanted.items() if k not in chosen), *arguments]
