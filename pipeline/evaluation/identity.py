"""What a solver is, beyond its name: settings and weights, so that old rows are told from new."""

from __future__ import annotations

import hashlib
from typing import Any

import torch

from baselines import Solver

SIMPLE = (bool, int, float, str)
PATHS = ("weights",)  # a folder may hold other weights tomorrow: networks go by checksum


def solver_identity(solver: Solver) -> dict[str, Any]:
    """Describe a solver by its class, its settings and the checksum of its networks.

    Settings are those that the registry loaded it with, plus every plain attribute for solvers that
    were made by hand; a solver inside another one is described in the same way.

    Args:
        solver: As it was made, before it has solved anything.

    Returns:
        JSON-ready facts; solvers that may answer differently have different ones.
    """
    facts: dict[str, Any] = {"class": f"{type(solver).__module__}.{type(solver).__qualname__}"}
    facts["settings"] = {k: v for k, v in solver.settings.items() if k not in PATHS}
    for name, value in sorted(vars(solver).items()):
        if value is None or isinstance(value, SIMPLE):
            facts[name] = value
        elif isinstance(value, Solver):
            facts[name] = solver_identity(value)
    return facts | network_checksums(solver)


def network_checksums(owner: object) -> dict[str, str]:
    """Return the checksum of each network that is an attribute of a solver or a detector."""
    values = sorted(vars(owner).items())
    return {name: network_checksum(v) for name, v in values if isinstance(v, torch.nn.Module)}


def network_checksum(network: torch.nn.Module) -> str:
    """Return the SHA-256 of a network's parameters and buffers, names included."""
    digest = hashlib.sha256()
    for name, tensor in network.state_dict().items():
        digest.update(f"{name}:{tensor.dtype}:{tuple(tensor.shape)}".encode())
        values = tensor.detach().cpu().contiguous().reshape(-1)
        digest.update(values.view(torch.uint8).numpy().tobytes())
    return digest.hexdigest()
