"""`export`: a network or solver as one file for programs that do without this project."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from pipeline.commands.arguments import command_parser, split_keys
from pipeline.config import compose
from pipeline.errors import PipelineError
from pipeline.learning.card import CARD, WeightsError, read_card, shipped_weights
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts, robot_of
from robots.suggestions import unknown_name

KEYS = ("to", "out", "weights")  # of the command, not of conf/
NO_MODEL = "model=none"
PLAIN = re.compile(r"[\w. -]+")  # of a header, which an #include names
DESCRIPTION = """\
export robot=panda to=onnx|torchscript|c [model=compact|paper|none] [out=FILE] [weights=FOLDER]

onnx, torchscript: poses (N, 7) to joints (N, dof), with scaling, limits, forward kinematics and the
ranking of hypotheses inside, and a card as metadata.
c: one header of C99 with forward kinematics, network and Levenberg-Marquardt, and a program beside
it that times and checks them; model=none leaves the network out, for any robot. Tolerances and
steps of the descent are those of solver.lm of the run.

Weights are those of weights=FOLDER, else those that `train` made in results_dir, else those of the
project. The file is checked against the network on export.poses random poses; see conf/export.
"""


def export(arguments: list[str]) -> int:
    """Export the solver of one robot."""
    overrides = command_parser("export", DESCRIPTION).takes_overrides().parse(arguments).overrides
    own, rest = split_keys(overrides, KEYS)
    config = compose([item for item in rest if item != NO_MODEL])
    to = _target(own)
    if NO_MODEL in rest and "weights" in own:
        raise PipelineError(f"{NO_MODEL} takes no network: leave it or weights=... out")
    folder = None if NO_MODEL in rest else find_folder(config, own.get("weights"))
    from baselines.registry import using
    from pipeline.exporting.export import default_path, export_source
    from pipeline.exporting.source import load_source

    with using(config.solver):  # the header descends as `lm` of this run does
        source = load_source(robot_of(config), folder)
        path = Path(own.get("out") or default_path(source, to))
        if path.is_dir() or (to == "c" and not PLAIN.fullmatch(path.name)):
            raise PipelineError(f"out={path} names no file that could be written; expected FILE")
        command = shlex.join(["python", "-m", "pipeline", "export", *arguments])
        for line in export_source(source, to, path, config.export, command, config.seed):
            print(line)
    return 0


def _target(own: dict[str, str]) -> str:
    from pipeline.exporting.targets import TARGETS

    to = own.get("to", "")
    if not to:
        raise PipelineError(f"to=... is missing; expected to={' or to='.join(TARGETS)}")
    if to not in TARGETS:
        raise PipelineError(unknown_name("target", to, TARGETS))
    return to


def find_folder(config: Config, named: str | None) -> Path:
    """Return the folder of the weights that are exported.

    Args:
        config: Robot, model and results folder of the run.
        named: Folder that was named, or a file in it.

    Raises:
        WeightsError: There are none.
    """
    if named:
        path = Path(named)
        return path.parent if path.is_file() else path
    robot, model = robot_of(config), config.model.name
    own, shipped = artifacts(config).train(robot.name, model), shipped_weights(robot.name)
    if (own / CARD).exists():
        return own
    if (shipped / CARD).exists() and read_card(shipped)["config"]["model"]["name"] == model:
        return shipped
    raise WeightsError(
        f"there are no weights of model={model} for {robot.name}: none in {own}, and none with the "
        f"project; train with: python -m pipeline train robot={robot.name} model={model} "
        f"profile={config.profile}, name a folder with weights=..., or take the descent alone: "
        f"to=c model=none"
    )
