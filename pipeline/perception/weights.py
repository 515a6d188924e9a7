"""Weights of the embedded detector on disk: safetensors in half precision, and a card."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor

import robots
from pipeline.data.files import read_json, sha256, write_sealed_json
from pipeline.data.tensors import write_tensors
from pipeline.errors import PerceptionError
from pipeline.perception.config import NetworkConfig
from pipeline.perception.network import CentreNetwork

WEIGHTS = "weights.safetensors"
CARD = "card.json"
LARGEST_BYTES = 2_000_000  # what is shipped with the project
ROBOTS = Path(robots.__file__).parent


def halved(network: CentreNetwork) -> CentreNetwork:
    """Round a network's numbers to what float16 keeps, in place."""
    rounded = {name: _half(value).to(value.dtype) for name, value in network.state_dict().items()}
    network.load_state_dict(rounded)
    return network


def save_detector(folder: Path, network: CentreNetwork, card: dict[str, Any]) -> None:
    """Write the weights and their card; the card holds their checksum and comes last."""
    path = folder / WEIGHTS
    write_tensors(path, {name: _half(value) for name, value in network.state_dict().items()})
    write_sealed_json(folder / CARD, {**card, "weights_sha256": sha256(path)})


def load_centre_network(
    folder: Path, robot: str, names: Collection[str] | None = None
) -> CentreNetwork:
    """Rebuild the network that a card describes and load its weights.

    Args:
        folder: Holds weights.safetensors and card.json.
        robot: Name of the robot that it must be for.
        names: The classes that it must know; those of its card if not given.

    Returns:
        The network in evaluation mode.

    Raises:
        PerceptionError: Files are missing or damaged, or the weights are of another robot, of other
            classes or of another shape.
    """
    card = read_detector_card(folder, robot)
    again = f"train one with: python -m pipeline detector robot={robot}"
    if card.get("robot") != robot:
        raise PerceptionError(
            f"the detector in {folder} is for the robot '{card.get('robot')}', not for '{robot}'; "
            f"{again}"
        )
    known = tuple(card.get("names", ()))
    if names is not None and sorted(known) != sorted(names):
        raise PerceptionError(
            f"the detector in {folder} knows {', '.join(known)}, expected {', '.join(names)}; "
            f"{again}"
        )
    path = folder / WEIGHTS
    if not path.exists() or sha256(path) != card.get("weights_sha256"):
        raise PerceptionError(f"{path} is missing or not the file that its card speaks of; {again}")
    network = CentreNetwork(known, NetworkConfig(**card["config"]["detector"]["network"]))
    _fill(network, path)
    return network.eval().requires_grad_(False)


def shipped_detector(robot: str) -> Path:
    """Folder of the detector that comes with this project for a robot."""
    return ROBOTS / robot / "detector"


def read_detector_card(folder: Path, robot: str) -> dict[str, Any]:
    """Return the card of a trained detector, whatever robot it is for.

    Args:
        folder: Of the weights.
        robot: Name of the robot that a detector is wanted for.

    Raises:
        PerceptionError: There is none.
    """
    if not (folder / CARD).exists():
        raise PerceptionError(
            f"there is no trained detector in {folder}; train one with: python -m pipeline "
            f"detector robot={robot}"
        )
    return dict(read_json(folder / CARD))


def _fill(network: CentreNetwork, path: Path) -> None:
    wanted = network.state_dict()
    try:
        stored = load_file(path)
    except SafetensorError as error:
        raise PerceptionError(f"{path} is not readable as safetensors: {error}") from error
    for name in sorted(wanted.keys() | stored.keys()):
        shapes = [tuple(each[name].shape) if name in each else None for each in (wanted, stored)]
        if shapes[0] != shapes[1]:
            raise PerceptionError(
                f"{path} does not fit the network of its card: {name} has shape {shapes[1]}, "
                f"expected {shapes[0]}"
            )
    network.load_state_dict({name: stored[name].to(wanted[name].dtype) for name in wanted})


def _half(value: Tensor) -> Tensor:
    return value.half() if value.is_floating_point() else value
