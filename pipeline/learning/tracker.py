"""Curves of trainings and trials for the trackers that people already use; off by default.

A tracker is told what `curve.csv` gets, at the same steps. It writes to a folder of this machine.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omegaconf import MISSING

from pipeline.errors import MissingPackageError

NONE, TENSORBOARD, MLFLOW = "none", "tensorboard", "mlflow"
AXES = ("step", "samples")  # of the curve, which are no measurements
EXTRA = "pip install -e '.[trackers]'"


@dataclass
class TrackerConfig:
    """Which tracker."""

    kind: str = MISSING

    def __post_init__(self) -> None:
        """Refuse trackers that there are not."""
        if self.kind not in WRITERS:
            raise ValueError(f"tracker.kind must be one of {', '.join(WRITERS)}, got {self.kind!r}")


class Writer(ABC):
    """What a tracker is told of one run.

    Args:
        folder: Where it writes.
        name: Of the run, such as ``train panda compact``.
        settings: Of the run, by key; numbers, texts and lists.
    """

    @abstractmethod
    def __init__(self, folder: Path, name: str, settings: Mapping[str, Any]) -> None: ...

    @abstractmethod
    def report(self, step: int, row: Mapping[str, float]) -> None:
        """Take a row of the curve, by column."""

    @abstractmethod
    def close(self) -> None:
        """Write what is held back."""


class _Silent(Writer):
    def __init__(self, folder: Path, name: str, settings: Mapping[str, Any]) -> None:
        """Keep nothing."""

    def report(self, step: int, row: Mapping[str, float]) -> None:
        """Keep nothing."""

    def close(self) -> None:
        """Keep nothing."""


class _TensorBoard(Writer):
    def __init__(self, folder: Path, name: str, settings: Mapping[str, Any]) -> None:
        """Begin a run's event file, or go on beside an earlier one of the same name."""
        try:
            from torch.utils.tensorboard import SummaryWriter
        except ImportError as error:
            raise MissingPackageError(f"tracker=tensorboard needs tensorboard: {EXTRA}") from error
        self._writer: Any = SummaryWriter(str(folder / name.replace(" ", "/")))
        self._writer.add_text("settings", _markdown(settings))

    def report(self, step: int, row: Mapping[str, float]) -> None:
        """Add a scalar for each column."""
        for key, value in _measured(row).items():
            self._writer.add_scalar(key, value, step)

    def close(self) -> None:
        """Write what is held back."""
        self._writer.close()


class _MlFlow(Writer):
    def __init__(self, folder: Path, name: str, settings: Mapping[str, Any]) -> None:
        """Begin a run in a database of the folder."""
        os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
        try:
            from mlflow import MlflowClient
        except ImportError as error:
            raise MissingPackageError(f"tracker=mlflow needs mlflow: {EXTRA}") from error
        folder.mkdir(parents=True, exist_ok=True)
        self._client: Any = MlflowClient(f"sqlite:///{folder.absolute()}/mlflow.db")
        experiment = self._client.get_experiment_by_name(PROJECT)
        number = experiment.experiment_id if experiment else self._client.create_experiment(PROJECT)
        self._run = self._client.create_run(number, run_name=name).info.run_id
        for key, value in settings.items():
            self._client.log_param(self._run, key, value)

    def report(self, step: int, row: Mapping[str, float]) -> None:
        """Log a metric for each column."""
        for key, value in _measured(row).items():
            self._client.log_metric(self._run, key, value, step=step)

    def close(self) -> None:
        """Mark the run as finished."""
        self._client.set_terminated(self._run)


PROJECT = "cycleik-bench"
WRITERS: Mapping[str, type[Writer]] = {
    NONE: _Silent,
    TENSORBOARD: _TensorBoard,
    MLFLOW: _MlFlow,
}


@contextmanager
def tracked(
    config: TrackerConfig, folder: Path, name: str, settings: Mapping[str, Any]
) -> Iterator[Writer]:
    """Give what a run reports to, and close it whatever ends the run.

    Args:
        config: Which tracker.
        folder: Where it writes.
        name: Of the run.
        settings: Of the run, nested as in the configuration.

    Raises:
        MissingPackageError: The tracker's package is not there.
    """
    writer = WRITERS[config.kind](folder, name, dict(_flat(settings)))
    try:
        yield writer
    finally:
        writer.close()


def _measured(row: Mapping[str, float]) -> dict[str, float]:
    return {key: value for key, value in row.items() if key not in AXES}


def _flat(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value


def _markdown(settings: Mapping[str, Any]) -> str:
    rows = [f"| {key} | {value} |" for key, value in settings.items()]
    return "\n".join(["| key | value |", "| --- | --- |", *rows])
