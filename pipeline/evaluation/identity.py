"""What a solver is, beyond its name: settings and weights, so that old rows are told from new."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

import torch

if TYPE_CHECKING:
    from baselines import Solver

SIMPLE = (bool, int, float, str)


def solver_identity(solver: Solver) -> dict[str, Any]:
    """Describe a solver by its class, its plain settings and the checksum of its networks.

    Args:
        solver: As it was made, before it has solved anything.

    Returns:
        JSON-ready facts; solvers that may answer differently have different ones.
    """
    facts: dict[str, Any] = {"class": f"{type(solver).__module__}.{type(solver).__qualname__}"}
    for name, value in sorted(vars(solver).items()):
        if value is None or isinstance(value, SIMPLE):
            facts[name] = value
        elif isinstance(value, torch.nn.Module):
            facts[name] = network_checksum(value)
    return facts


def network_checksum(network: torch.nn.Module) -> str:
    """Return the SHA-256 of a network's parameters and buffers, names included."""
    digest = hashlib.sha256()
    for name, tensor in network.state_dict().items():
        digest.update(f"{name}:{tensor.dtype}:{tuple(tensor.shape)}".encode())
        values = tensor.detach().cpu().contiguous().reshape(-1)
        digest.update(values.view(torch.uint8).numpy().tobytes())
    return digest.hexdigest()
