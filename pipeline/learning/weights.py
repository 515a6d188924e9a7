"""Trained weights on disk: safetensors, with a card beside them that says what they are for."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from pipeline.data.files import sha256, write_sealed_json
from pipeline.data.tensors import write_tensors
from pipeline.learning.card import CARD, WeightsError, check_robot, read_card
from pipeline.learning.factory import build_network, model_config
from pipeline.learning.networks import IkNetwork
from robots import Robot

WEIGHTS = "weights.safetensors"
OTHER_WEIGHTS = "other.safetensors"  # best where the last is kept, last where the best is


def save_weights(
    folder: Path,
    network: nn.Module,
    card: dict[str, Any],
    other: dict[str, Tensor] | None = None,
    half: bool = False,
) -> None:
    """Write the weights and their card; the card holds their checksum and comes last.

    Args:
        folder: Folder of the weights.
        network: The network that solvers load.
        card: What the weights are for.
        other: Tensors of the same network at another step, to lie beside its weights.
        half: Keep the trained numbers in float16; scalings and cells stay as they are.
    """
    path = folder / WEIGHTS
    if other is not None:
        write_tensors(folder / OTHER_WEIGHTS, other)
    trained = {name for name, _ in network.named_parameters()} if half else set()
    state = network.state_dict().items()
    write_tensors(path, {name: t.half() if name in trained else t for name, t in state})
    write_sealed_json(folder / CARD, {**card, "weights_sha256": sha256(path)})


def load_network(folder: Path, robot: Robot, kinds: Collection[str] = ()) -> IkNetwork:
    """Rebuild the network that a card describes and load its weights.

    Args:
        folder: Holds weights.safetensors and card.json.
        robot: The robot that the weights must be for.
        kinds: Kinds of networks that will do; empty for any.

    Returns:
        The network in evaluation mode on the CPU.

    Raises:
        WeightsError: Files are missing or damaged, or the weights are of another robot, chain, kind
            of network or architecture.
    """
    card = read_card(folder)
    check_robot(folder, card, robot)
    path = folder / WEIGHTS
    if not path.exists() or sha256(path) != card.get("weights_sha256"):
        raise WeightsError(
            f"{path} is missing or not the file that its card speaks of; train again"
        )
    model = card["config"]["model"]
    if kinds and model["kind"] not in kinds:
        raise WeightsError(
            f"the weights in {folder} are of a network of kind '{model['kind']}', expected one of "
            f"{', '.join(kinds)}; train such a model, see conf/model"
        )
    network = build_network(robot, model_config(model))
    try:
        network.load_state_dict(load_file(path))
    except (SafetensorError, RuntimeError) as error:
        raise WeightsError(f"{path} does not fit the network of its card: {error}") from error
    return network.eval().requires_grad_(False)
