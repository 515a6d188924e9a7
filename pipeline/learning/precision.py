"""Precision of the matrix products of a backward pass."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import torch

PRECISIONS = ("float32", "bfloat16_backward")


@contextmanager
def backward_precision(name: str) -> Iterator[None]:
    """Compute float32 matrix products as ``train.precision`` names, for as long as this lasts.

    With ``bfloat16_backward`` factors are rounded to bfloat16 (on an accelerator to TensorFloat-32)
    and summed up in float32. Weights, activations and gradients stay float32, and so does the
    forward pass that surrounds this, in which three lost digits would be millimetres. A processor
    without bfloat16 instructions computes in float32 all the same.

    Args:
        name: One of `PRECISIONS`.
    """
    if name == "float32":
        yield
        return
    before = torch.get_float32_matmul_precision()
    torch.set_float32_matmul_precision("medium")
    try:
        yield
    finally:
        torch.set_float32_matmul_precision(before)
