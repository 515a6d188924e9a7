"""`export-weights`: put trained compact weights or a detector beside a robot's description."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import torch

from pipeline.commands.arguments import command_parser
from pipeline.commands.model_card import write_model_card
from pipeline.config import compose
from pipeline.data.dataset import read_split
from pipeline.errors import PipelineError
from pipeline.learning.card import read_card, shipped_weights
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.learning.networks import IkNetwork
from pipeline.learning.weights import load_network, save_weights
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts, robot_of
from robots import Robot

LARGEST_BYTES = 3_000_000  # what a repository bears for each robot
RUN_ONLY = ("run", "machine", "weights_sha256", "files")
DESCRIPTION = """\
export-weights robot=panda [model=compact] [results_dir=results/quick]

Copies the weights that `train` made to robots/<name>/weights, where a solver finds them right after
installation. Numbers are kept in half precision; the errors on the test poses are measured with
them as they are kept, and go into the card and into the model card (README.md) beside it.

export-weights detector robot=nicol [results_dir=results/quick]

Copies the detector that the stage `detector` trained to robots/<name>/detector likewise.
"""


def export_weights(arguments: list[str]) -> int:
    """Export the weights of one robot; a run's own weights keep their precedence."""
    parser = command_parser("export-weights", DESCRIPTION).takes_overrides()
    overrides = parser.parse(arguments).overrides
    if overrides[:1] == ["detector"]:
        return _export_detector(compose(overrides[1:]))
    config = compose(overrides)
    robot = robot_of(config)
    folders = artifacts(config)
    source = folders.train(robot.name, config.model.name)
    card = read_card(source)
    network = load_network(source, robot).half().float()
    target = shipped_weights(robot.name)
    size = 2 * sum(parameter.numel() for parameter in network.parameters())
    if size > LARGEST_BYTES:
        raise PipelineError(
            f"the weights in {source} would take {size:,} bytes, at most {LARGEST_BYTES:,} are "
            "shipped: take a smaller model"
        )
    test = _errors(robot, network, config, folders.dataset(robot.name))
    save_weights(target, network, _card(card, test), half=True)
    write_model_card(target)
    errors = f"{test['position_error_mm']:.2f} mm, {test['rotation_error_deg']:.2f} deg"
    print(f"{target}: {errors} on {test['poses']} test poses")
    return 0


def _export_detector(config: Config) -> int:
    """Export a detector; its numbers are in half precision already, and so were judged."""
    from pipeline.perception.weights import (
        LARGEST_BYTES,
        WEIGHTS,
        load_centre_network,
        read_detector_card,
        save_detector,
        shipped_detector,
    )

    robot = robot_of(config)
    source = artifacts(config).detector(robot.name)
    network = load_centre_network(source, robot.name)
    size = (source / WEIGHTS).stat().st_size
    if size > LARGEST_BYTES:
        raise PipelineError(
            f"the detector in {source} takes {size:,} bytes, at most {LARGEST_BYTES:,} are "
            "shipped: take smaller detector.network.channels"
        )
    card = read_detector_card(source, robot.name)
    target = shipped_detector(robot.name)
    save_detector(target, network, {k: v for k, v in card.items() if k not in RUN_ONLY})
    write_model_card(target)
    quality = card["held_out"]
    print(
        f"{target}: mAP50 {quality['map50']:.3f}, {quality['position_error_mm']:.1f} mm on "
        f"{quality['pictures']} held-out pictures"
    )
    return 0


def _errors(robot: Robot, network: IkNetwork, config: Config, data: Path) -> dict[str, float]:
    """Mean Euclidean and geodesic errors on the test poses."""
    poses = torch.as_tensor(read_split(data, "test", robot).poses, dtype=torch.float32)
    objective = CycleObjective(robot, network, config.train, torch.device("cpu"))
    position, rotation = objective.errors(poses)
    return {
        "poses": len(poses),
        "position_error_mm": float(position.mean()),
        "rotation_error_deg": float(rotation.mean()),
        "success_10mm_20deg": float(((position < 10) & (rotation < 20)).double().mean()),
    }


def _card(card: dict[str, Any], test: dict[str, float]) -> dict[str, Any]:
    """The card of the run, without what belongs to one run and one machine."""
    kept = {key: value for key, value in card.items() if key not in RUN_ONLY}
    return {**kept, "stored": "float16", "test": test}
