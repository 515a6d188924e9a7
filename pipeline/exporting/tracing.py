"""A network as a program of torch: TorchScript, and ONNX made of it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import torch

from pipeline.exporting.answering import OUTPUTS, answering
from pipeline.exporting.config import ExportConfig
from pipeline.exporting.source import Source
from pipeline.packages import optional_package

TYPES = {"float64": torch.float64, "float32": torch.float32}
INPUT, BATCH = "poses", "batch"
# Enough poses that the trace has a batch; any other number of them goes through the file as well.
TRACED = 2
CARD = "card.json"  # entry of a TorchScript file


def write_torchscript(
    path: Path, source: Source, config: ExportConfig, card: Mapping[str, str]
) -> None:
    """Write a file for `torch.jit.load`, with its card as the extra file `card.json`.

    Args:
        path: The file.
        source: The robot and its network.
        config: Precision.
        card: What the file says of itself.
    """
    import json

    files = {CARD: json.dumps(dict(card), indent=2)}
    with _quiet():
        torch.jit.save(_program(source, config), path, _extra_files=files)


def write_onnx(path: Path, source: Source, config: ExportConfig, card: Mapping[str, str]) -> None:
    """Write a file of ONNX with a batch of any size, and its card as metadata.

    Arguments as of `write_torchscript`.

    Raises:
        PipelineError: The package onnx is missing.
    """
    onnx = optional_package("export to=onnx")
    names = (INPUT, *OUTPUTS)
    with _quiet():
        torch.onnx.export(
            _program(source, config),
            (_poses(source, config),),
            str(path),
            dynamo=False,
            opset_version=config.opset,
            do_constant_folding=False,  # runtimes fold as they load; the file keeps half precision
            input_names=[INPUT],
            output_names=list(OUTPUTS),
            dynamic_axes={name: {0: BATCH} for name in names},
        )
    model = onnx.load(str(path))
    onnx.helper.set_model_props(model, dict(card))
    model.doc_string = f"Inverse kinematics of {source.robot.name}: {card['pose']}, to joints"
    onnx.checker.check_model(model)
    onnx.save(model, str(path))


def _program(source: Source, config: ExportConfig) -> Any:
    dtype = TYPES[config.precision]
    module = answering(source.robot, source.network, source.ranking, dtype)
    return torch.jit.trace(module, _poses(source, config), check_trace=False)


def _poses(source: Source, config: ExportConfig) -> torch.Tensor:
    joints = source.robot.sample(TRACED, seed=0, collision_free=False)
    poses = source.robot.forward_kinematics(joints)
    return torch.as_tensor(poses, dtype=TYPES[config.precision])


@contextmanager
def _quiet() -> Iterator[None]:
    """Without advice on torch's newer exporter, which knows no batch of any size in our grid."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield
