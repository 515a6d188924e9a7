"""The numbers of a network as the template of the header takes them."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from pipeline.errors import PipelineError
from pipeline.exporting.answering import linear, smallest
from pipeline.learning.cycleik.experts import Experts, host
from pipeline.learning.cycleik.mlp import CycleIkMlp
from pipeline.learning.networks import IkNetwork

A_LINE = 16  # numbers
GELU_SLOPE, GELU_CUBE = float(np.sqrt(2 / np.pi)), 0.044715  # Hendrycks and Gimpel, 1606.08415

Layers = list[tuple[NDArray[np.float32], NDArray[np.float32]]]


def network_values(network: IkNetwork, ranking: NDArray[np.float64]) -> dict[str, Any]:
    """Return what the template needs of a network.

    Args:
        network: Of kind experts or mlp.
        ranking: (2,) what an error of 1 m and of 1 rad counts when hypotheses are compared.

    Raises:
        PipelineError: A network of another kind.
    """
    if isinstance(network, Experts):
        layers, more = _of_experts(network)
    elif isinstance(network, CycleIkMlp):
        layers, more = _of_mlp(network)
    else:
        raise PipelineError(
            f"a {type(network).__name__} cannot be written in C: expected a network of kind "
            "experts or mlp, such as model=compact; model=none writes the descent alone"
        )
    flat = np.concatenate([part.reshape(len(part), -1) for pair in layers for part in pair], 1)
    half = smallest(torch.as_tensor(flat)).dtype == torch.float16
    sizes = [layers[0][0].shape[1], *(weight.shape[2] for weight, _ in layers)]
    each = 2 if half else 4
    return {
        "experts": isinstance(network, Experts),
        "heads": network.heads,
        "parameters": flat.size,
        "bytes_each": each,
        "bytes": each * flat.size,
        "box_centre": _row(host(network.position_centre)),
        "box_half": _row(host(network.position_scale)),
        "joint_centre": _row(host(network.joint_centre)),
        "joint_scale": _row(host(network.joint_scale)),
        "cells": len(flat),
        "layers": len(layers),
        "widest": max(sizes),
        "sizes": _row(np.array(sizes)),
        "numbers": flat.shape[1],
        "trained": [_lines(row, half) for row in flat],
        "of_distance": repr(float(ranking[0])),
        "of_angle": repr(float(ranking[1])),
        **more,
    }


def _of_experts(network: Experts) -> tuple[Layers, dict[str, Any]]:
    """Weights (E, in, out) and biases (E, 1, out), and what chooses an expert."""
    layers = [
        (weight.detach().numpy(), bias.detach().numpy())
        for weight, bias in zip(network.weights, network.biases, strict=True)
    ]
    tables = {name: host(getattr(network, name)) for name in ("centres", "mean", "scale")}
    more: dict[str, Any] = {name: [_row(row) for row in table] for name, table in tables.items()}
    more |= {"metric": _row(host(network.metric))}
    return layers, more | {"gelu_slope": repr(GELU_SLOPE), "gelu_cube": repr(GELU_CUBE)}


def _of_mlp(network: CycleIkMlp) -> tuple[Layers, dict[str, Any]]:
    """Weights (1, in, out) and biases (1, 1, out), and where its layers of tanh begin."""
    layers = [
        (layer.weight.detach().numpy().T[None], layer.bias.detach().numpy()[None, None])
        for layer in linear(network)
    ]
    return layers, {"first_tanh": network.layers.first_tanh}


def _lines(row: NDArray[np.float32], half: bool) -> list[str]:
    """Numbers as lines of C: bits of float16, or float32 to nine digits, which are exact."""
    if half:
        texts = [str(bits) for bits in row.astype(np.float16).view(np.uint16).tolist()]
    else:
        texts = [f"{value:.8e}f" for value in row.tolist()]
    return [",".join(texts[k : k + A_LINE]) + "," for k in range(0, len(texts), A_LINE)]


def _row(values: NDArray[Any]) -> str:
    return ", ".join(repr(value) for value in values.tolist())
