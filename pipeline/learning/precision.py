"""Precision of the matrix products of a training, and the library that computes them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import torch
from torch import Tensor, nn

from pipeline.learning.config import BFLOAT16, FLOAT32, TrainConfig
from pipeline.learning.networks import IkNetwork

# PyTorch's names. With "medium" it may round factors to bfloat16 before it multiplies.
HIGHEST, MEDIUM = "highest", "medium"
# Of a product, relative: float32 errs by some 1e-7, TensorFloat-32 by 3e-4, bfloat16 by 2e-3.
TOLERANCE = 1e-5


class MatmulPrecision:
    """How a training computes its float32 matrix products, forwards and backwards.

    On a processor PyTorch leaves them to MKL, which keeps to narrower instructions on processors of
    other makers than its own, unless bfloat16 would do: then they go to oneDNN, which rounds
    factors only where there are instructions that gain by it. Where it does not round, its
    products are float32 like MKL's and up to twice as fast (benchmarks/training.py). Whether it
    rounds the products of a network is tried out once, by their errors, never by time: the same
    machine decides the same, so that a training that is resumed ends with the same bits.

    With ``bfloat16_backward`` the backward pass may be rounded. Weights, activations and gradients
    stay float32, and so does the forward pass, in which three lost digits would be millimetres.
    While the learning rate is high, a network is further than that from what it will be: with
    ``bfloat16`` its hidden layers are rounded forwards too, until the last part of the run.

    Args:
        train: Its ``precision``, ``float32_from`` and ``batch_size``.
        network: Its parameters tell the shapes of the products.
        device: Where the network is.

    Attributes:
        forward: `matmul_precision` of the forward pass, ``highest`` or ``medium``.
        backward: The same of the backward pass.
    """

    def __init__(self, train: TrainConfig, network: nn.Module, device: torch.device) -> None:
        shapes = frozenset(tuple(p.shape) for p in network.parameters() if p.ndim > 1)
        spared = device.type == "cpu" and all(
            _is_exact(shape, train.batch_size) for shape in shapes
        )
        self.forward = MEDIUM if spared else HIGHEST
        self.backward = MEDIUM if spared or train.precision != FLOAT32 else HIGHEST
        self._rounded_until = train.float32_from if train.precision == BFLOAT16 else 0.0

    @contextmanager
    def forward_pass(self, network: nn.Module, done: float) -> Iterator[None]:
        """Compute a network's products as a step is to.

        Args:
            network: The network of the step.
            done: Steps done so far as a share of the run.
        """
        if isinstance(network, IkNetwork):
            network.rounded = done < self._rounded_until
        try:
            with matmul_precision(self.forward):
                yield
        finally:
            if isinstance(network, IkNetwork):
                network.rounded = False


@contextmanager
def matmul_precision(name: str) -> Iterator[None]:
    """Set PyTorch's precision of float32 products, and what it was before afterwards.

    Args:
        name: See `torch.set_float32_matmul_precision`.
    """
    before = torch.get_float32_matmul_precision()
    torch.set_float32_matmul_precision(name)
    try:
        yield
    finally:
        torch.set_float32_matmul_precision(before)


@cache
def _is_exact(shape: tuple[int, ...], batch: int) -> bool:
    """Whether products are float32 even with ``medium``.

    Args:
        shape: Of a weight, (..., rows, columns); leading axes are multiplied one by one.
        batch: Poses in a batch, shared out among those.
    """
    *groups, rows, columns = shape
    count = max(batch // int(torch.Size(groups).numel()), 1)
    generator = torch.Generator().manual_seed(0)

    def drawn(*size: int) -> Tensor:
        return torch.randn(*groups, *size, generator=generator)

    weight, inputs, outputs = drawn(rows, columns), drawn(count, rows), drawn(count, columns)
    factors = ((inputs, weight), (outputs, weight.mT), (inputs.mT, outputs))
    with matmul_precision(MEDIUM):
        products = [left @ right for left, right in factors]
    return all(
        _error(product, left.double() @ right.double()) < TOLERANCE
        for product, (left, right) in zip(products, factors, strict=True)
    )


def _error(product: Tensor, reference: Tensor) -> float:
    """Frobenius norm of the error of a product, as a share of the reference's."""
    return float((product - reference).norm() / reference.norm())
