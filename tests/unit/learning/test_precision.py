"""Precision of products: what is taken for float32 is float32, and nothing stays switched."""

from __future__ import annotations

import pytest
import torch
from torch import nn

from pipeline.learning import precision
from pipeline.learning.precision import HIGHEST, MEDIUM, MatmulPrecision, matmul_precision

CPU = torch.device("cpu")
BATCH = 128


def network() -> nn.Sequential:
    torch.manual_seed(0)
    return nn.Sequential(nn.Linear(256, 512), nn.GELU(), nn.Linear(512, 256))


def gradient(products: MatmulPrecision) -> tuple[torch.Tensor, torch.Tensor]:
    """Output and first weight gradient of a network that is the same every time."""
    layers = network()
    values = torch.randn(BATCH, 256)
    with matmul_precision(products.forward):
        output = layers(values)
    with matmul_precision(products.backward):
        output.square().mean().backward()
    return output.detach(), layers[0].weight.grad.flatten()


def reference() -> tuple[torch.Tensor, torch.Tensor]:
    layers = network()
    values = torch.randn(BATCH, 256).double()
    layers.double()
    output = layers(values)
    output.square().mean().backward()
    return output.detach(), layers[0].weight.grad.flatten()


def away(value: torch.Tensor, exact: torch.Tensor) -> float:
    return float((value - exact).norm() / exact.norm())


def test_float32_products_err_like_float32_whoever_computes_them() -> None:
    products = MatmulPrecision("float32", network(), BATCH, CPU)
    for value, exact in zip(gradient(products), reference(), strict=True):
        assert away(value, exact) < 2e-6


def test_a_rounded_backward_pass_leaves_the_output_alone() -> None:
    products = MatmulPrecision("bfloat16_backward", network(), BATCH, CPU)
    assert products.backward == MEDIUM
    (output, slope), (exact, straight) = gradient(products), reference()
    assert away(output, exact) < 2e-6
    assert away(slope, straight) < 0.01


def test_a_machine_that_rounds_is_reported_not_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(precision, "_is_exact", lambda shape, batch: shape != (512, 256))
    products = MatmulPrecision("float32", network(), BATCH, CPU)
    assert (products.forward, products.backward) == (HIGHEST, HIGHEST)
    products = MatmulPrecision("bfloat16_backward", network(), BATCH, CPU)
    assert (products.forward, products.backward) == (HIGHEST, MEDIUM)


def test_rounding_is_noticed() -> None:
    values = torch.randn(64, 64, generator=torch.Generator().manual_seed(1))
    rounded = values.bfloat16().float() @ values.bfloat16().float()
    assert precision._error(rounded, values.double() @ values.double()) > precision.TOLERANCE
    assert precision._error(values @ values, values.double() @ values.double()) < 1e-6


def test_the_precision_is_as_before_after_an_error() -> None:
    before = torch.get_float32_matmul_precision()
    with pytest.raises(KeyError), matmul_precision(MEDIUM):
        assert torch.get_float32_matmul_precision() == MEDIUM
        raise KeyError
    assert torch.get_float32_matmul_precision() == before
