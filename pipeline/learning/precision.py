"""Precision of the matrix products of a training, and the library that computes them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import torch
from torch import Tensor, nn

PRECISIONS = ("float32", "bfloat16_backward")
# PyTorch's words. Told "medium", it may round factors to bfloat16 before it multiplies.
EXACT, ROUNDED = "highest", "medium"
# Of a product, relative: float32 errs by some 1e-7, TensorFloat-32 by 3e-4, bfloat16 by 2e-3.
TOLERANCE = 1e-5


class Products:
    """How a training computes its float32 matrix products, forwards and backwards.

    On a processor PyTorch leaves them to MKL, which keeps to narrower instructions on processors of
    other makers than its own, unless bfloat16 would do: then they go to oneDNN, which rounds
    factors only where there are instructions that gain by it. Where it does not round, its
    products are float32 like MKL's and up to twice as fast (benchmarks/training.py). Whether it
    rounds the products of a network is tried out once, by their errors, never by time: the same
    machine decides the same, so that a training that is resumed ends with the same bits.

    With ``bfloat16_backward`` the backward pass may be rounded. Weights, activations and gradients
    stay float32, and so does the forward pass, in which three lost digits would be millimetres.

    Args:
        precision: One of `PRECISIONS`, see ``train.precision``.
        network: Its parameters tell the shapes of the products.
        batch: Poses in a batch.
        device: Where the network is.

    Attributes:
        forward: What PyTorch is told for the forward pass.
        backward: And for the backward pass.
    """

    def __init__(
        self, precision: str, network: nn.Module, batch: int, device: torch.device
    ) -> None:
        shapes = frozenset(tuple(p.shape) for p in network.parameters() if p.ndim > 1)
        spared = device.type == "cpu" and all(_is_exact(shape, batch) for shape in shapes)
        self.forward = ROUNDED if spared else EXACT
        self.backward = ROUNDED if spared or precision == "bfloat16_backward" else EXACT


@contextmanager
def told(how: str) -> Iterator[None]:
    """Tell PyTorch how float32 products may be computed, for as long as this lasts.

    Args:
        how: See `torch.set_float32_matmul_precision`.
    """
    before = torch.get_float32_matmul_precision()
    torch.set_float32_matmul_precision(how)
    try:
        yield
    finally:
        torch.set_float32_matmul_precision(before)


@cache
def _is_exact(shape: tuple[int, ...], batch: int) -> bool:
    """Whether products with a weight of this shape are float32, whatever PyTorch is told."""
    *groups, rows, columns = shape
    count = max(batch // int(torch.Size(groups).numel()), 1)
    generator = torch.Generator().manual_seed(0)

    def drawn(*size: int) -> Tensor:
        return torch.randn(*groups, *size, generator=generator)

    weight, inputs, outputs = drawn(rows, columns), drawn(count, rows), drawn(count, columns)
    factors = ((inputs, weight), (outputs, weight.mT), (inputs.mT, outputs))
    with told(ROUNDED):
        products = [left @ right for left, right in factors]
    return all(
        _error(product, left.double() @ right.double()) < TOLERANCE
        for product, (left, right) in zip(products, factors, strict=True)
    )


def _error(product: Tensor, reference: Tensor) -> float:
    return float((product - reference).norm() / reference.norm())
