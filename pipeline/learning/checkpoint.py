"""The state of an unfinished training in one safetensors file: nothing is pickled."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from torch.optim import Optimizer

from pipeline.data.tensors import TensorsError, read_sealed_tensors, write_sealed_tensors
from pipeline.progress import LOGGER

State = dict[str, Tensor]


@dataclass
class Progress:
    """How far a training is.

    Batches are drawn from generators seeded by the epoch, so the step is all the random state
    there is.

    Attributes:
        step: Steps done.
        skipped: Steps whose gradient was not finite and that changed nothing.
        loss_sum: Sum of the losses since the last validation.
        loss_steps: Number of losses in that sum.
        curve: One row for each validation so far.
        best_step: Step of the validation with the smallest error; 0 before there was one.
        best_error: That error, in units of `trainer.error_score`.
        processor_s: Processor time of the run so far, over its resumptions [s].
    """

    step: int = 0
    skipped: int = 0
    loss_sum: float = 0.0
    loss_steps: int = 0
    curve: list[dict[str, float]] = field(default_factory=list)
    best_step: int = 0
    best_error: float = math.inf
    processor_s: float = 0.0


def save(
    path: Path,
    digest: str,
    progress: Progress,
    network: nn.Module,
    optimizer: Optimizer,
    best: State,
) -> None:
    """Write network, optimiser state, best network so far and progress, atomically.

    Args:
        path: Checkpoint file.
        digest: Names configuration and data; only a run with the same one may resume.
        progress: How far the training is.
        network: Its parameters and buffers are kept.
        optimizer: Adam's moments are kept.
        best: The network's tensors at the best validation so far; empty before there was one.
    """
    tensors = {f"network.{name}": value for name, value in network.state_dict().items()}
    tensors |= {f"best.{name}": value for name, value in best.items()}
    for index, state in optimizer.state_dict()["state"].items():
        for name, value in state.items():
            tensors[f"optimizer.{index}.{name}"] = torch.as_tensor(value)
    header = {"digest": digest, "progress": json.dumps(asdict(progress))}
    write_sealed_tensors(path, tensors, header)


def restore(
    path: Path, digest: str, network: nn.Module, optimizer: Optimizer
) -> tuple[Progress, State] | None:
    """Bring network and optimiser to where a killed run stood.

    Returns:
        The progress of that run and its best network so far; None where there is no checkpoint, or
        one of another configuration or a damaged one, in which case nothing is changed.
    """
    if not path.exists():
        return None
    try:
        tensors, header = read_sealed_tensors(path)
    except TensorsError as error:
        LOGGER.warning("%s: the training begins anew", error)
        return None
    if header.get("digest") != digest:
        return None
    network.load_state_dict(_part(tensors, "network."))
    state: dict[int, dict[str, Any]] = {}
    for name, value in _part(tensors, "optimizer.").items():
        index, key = name.split(".", 1)
        state.setdefault(int(index), {})[key] = value
    optimizer.load_state_dict({**optimizer.state_dict(), "state": state})
    return Progress(**json.loads(header["progress"])), _part(tensors, "best.")


def _part(tensors: State, prefix: str) -> State:
    return {name.removeprefix(prefix): t for name, t in tensors.items() if name.startswith(prefix)}
