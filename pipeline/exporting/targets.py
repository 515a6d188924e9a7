"""What a network or solver can be exported to: one function writes each, another one reads it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from pipeline.errors import PipelineError
from pipeline.exporting.c_compiler import CompiledHeader, find_compiler
from pipeline.exporting.c_header import header_text
from pipeline.exporting.config import ExportConfig
from pipeline.exporting.source import Source
from pipeline.exporting.tracing import INPUT, TYPES, write_onnx, write_torchscript
from pipeline.packages import missing_parts, optional_package

Array = NDArray[np.float64]
Answers = Callable[[Array], Array]
ONNX_CHECK = "the check of to=onnx"


class ExportError(PipelineError):
    """What cannot be exported, or a file whose answers are not those of the network."""


@dataclass(frozen=True)
class Target:
    """A kind of file.

    Attributes:
        suffix: Of the file.
        write: Writes it: path, source, configuration, card.
        unreadable: Why a file cannot be checked here; empty where it can.
        read: Returns what answers poses (N, 7) with joints (N, dof): source, path, configuration.
    """

    suffix: str
    write: Callable[[Path, Source, ExportConfig, Mapping[str, str]], None]
    unreadable: Callable[[], str]
    read: Callable[[Source, Path, ExportConfig], Answers]


def read_onnx(source: Source, path: Path, config: ExportConfig) -> Answers:
    """Return what answers by onnxruntime on one thread of the processor."""
    runtime = optional_package(ONNX_CHECK)
    options = runtime.SessionOptions()
    options.intra_op_num_threads = 1
    session = runtime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    return lambda poses: session.run(None, {INPUT: poses.astype(config.precision)})[0]


def read_torchscript(source: Source, path: Path, config: ExportConfig) -> Answers:
    """Return what answers by torch alone."""
    program = torch.jit.load(str(path))
    dtype = TYPES[config.precision]

    def answer(poses: Array) -> Array:
        with torch.inference_mode():
            joints: Array = program(torch.as_tensor(poses, dtype=dtype))[0].numpy()
        return joints

    return answer


def read_header(source: Source, path: Path, config: ExportConfig) -> Answers:
    """Return what answers by the compiled header."""
    compiled = CompiledHeader(source, path)
    return lambda poses: compiled.network(poses)[0]


def write_header(path: Path, source: Source, config: ExportConfig, card: Mapping[str, str]) -> None:
    """Write the header of C; see `header_text`."""
    path.write_text(header_text(source, card, card["file"]), encoding="utf-8")


TARGETS = {
    "onnx": Target(".onnx", write_onnx, lambda: missing_parts().get(ONNX_CHECK, ""), read_onnx),
    "torchscript": Target(".pt", write_torchscript, lambda: "", read_torchscript),
    "c": Target(
        ".h",
        write_header,
        lambda: "" if find_compiler() else "there is no compiler of C",
        read_header,
    ),
}
