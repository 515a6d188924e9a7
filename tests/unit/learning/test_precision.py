"""Precision of products: what is taken for float32 is float32, and nothing stays switched."""

from __future__ import annotations

import pytest
import torch
from torch import nn

from pipeline.config import compose
from pipeline.learning import precision
from pipeline.learning.checkpoint import Progress
from pipeline.learning.config import TrainConfig
from pipeline.learning.factory import build_network
from pipeline.learning.precision import HIGHEST, MEDIUM, MatmulPrecision, matmul_precision
from pipeline.learning.trainer import Trainer, TrainingError, TrainingRun
from robots import load_robot

CPU = torch.device("cpu")
BATCH = 128


def recipe(precision: str) -> TrainConfig:
    return compose([f"train.precision={precision}", f"train.batch_size={BATCH}"]).train


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
    products = MatmulPrecision(recipe("float32"), network(), CPU)
    for value, exact in zip(gradient(products), reference(), strict=True):
        assert away(value, exact) < 2e-6


def test_a_rounded_backward_pass_leaves_the_output_alone() -> None:
    products = MatmulPrecision(recipe("bfloat16_backward"), network(), CPU)
    assert products.backward == MEDIUM
    (output, slope), (exact, straight) = gradient(products), reference()
    assert away(output, exact) < 2e-6
    assert away(slope, straight) < 0.01


def test_a_machine_that_rounds_is_reported_not_to(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(precision, "_is_exact", lambda shape, batch: shape != (512, 256))
    products = MatmulPrecision(recipe("float32"), network(), CPU)
    assert (products.forward, products.backward) == (HIGHEST, HIGHEST)
    products = MatmulPrecision(recipe("bfloat16_backward"), network(), CPU)
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


def test_a_forward_pass_is_rounded_until_the_last_part_of_the_run() -> None:
    panda = load_robot("panda")
    config = compose(
        [
            "robot=panda",
            "model=paper",
            "model.hidden=[64, 64]",
            "train.precision=bfloat16",
            "train.float32_from=0.5",
            "train.batch_size=8",
            "train.device=cpu",
        ]
    )
    torch.manual_seed(0)
    trainer = Trainer(
        panda, build_network(panda, config.model), config.train, TrainingRun(0, "", "test")
    )
    made_from = panda.sample(8, seed=0)
    poses, joints = trainer.tensor(panda.forward_kinematics(made_from)), trainer.tensor(made_from)
    seen = []

    def note(layer: nn.Module, given: object, output: torch.Tensor) -> None:
        seen.append(output.dtype)

    for layer in trainer.network.layers:
        layer.register_forward_hook(note)
    progress = Progress()
    for _ in range(4):
        trainer.step(poses, joints, progress, total=4)
    half, full = torch.bfloat16, torch.float32
    assert seen == [half, half, full] * 2 + [full] * 6
    assert not trainer.network.rounded
    assert progress.skipped == 0


def test_networks_that_cannot_be_rounded_are_refused() -> None:
    panda = load_robot("panda")
    config = compose(["robot=panda", "model=compact", "train.precision=bfloat16"])
    network = build_network(panda, config.model)
    with pytest.raises(TrainingError, match="use float32 or bfloat16_backward"):
        Trainer(panda, network, config.train, TrainingRun(0, "", "test"))
