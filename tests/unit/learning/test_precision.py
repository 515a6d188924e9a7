"""The precision switch: the backward pass alone, and everything as before afterwards."""

from __future__ import annotations

import pytest
import torch
from torch import nn

from pipeline.learning.precision import backward_precision


def gradient(precision: str) -> tuple[torch.Tensor, torch.Tensor]:
    """Output and first weight gradient of a network that is the same every time."""
    torch.manual_seed(0)
    network = nn.Sequential(nn.Linear(256, 512), nn.GELU(), nn.Linear(512, 256))
    output = network(torch.randn(128, 256))
    with backward_precision(precision):
        output.square().mean().backward()
    return output.detach(), network[0].weight.grad.flatten()


def test_gradients_keep_their_direction_and_outputs_their_bits() -> None:
    output, exact = gradient("float32")
    again, rounded = gradient("bfloat16_backward")
    assert torch.equal(output, again)
    assert torch.nn.functional.cosine_similarity(exact, rounded, dim=0) > 0.9999
    assert (rounded - exact).norm() < 0.01 * exact.norm()
    assert rounded.dtype == torch.float32


def test_the_precision_is_as_before_after_an_error() -> None:
    before = torch.get_float32_matmul_precision()
    with pytest.raises(KeyError), backward_precision("bfloat16_backward"):
        assert torch.get_float32_matmul_precision() == "medium"
        raise KeyError
    assert torch.get_float32_matmul_precision() == before
