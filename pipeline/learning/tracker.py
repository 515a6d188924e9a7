"""Curves of trainings and trials for the trackers that people already use; off by default.

A tracker is told what `curve.csv` gets, at the same steps, also of a training that goes on from a
checkpoint. It writes to a folder of this machine.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from omegaconf import MISSING

from pipeline.artifacts import exclusive
from pipeline.errors import MissingPackageError

NONE, TENSORBOARD, MLFLOW = "none", "tensorboard", "mlflow"
AXES = ("step", "samples")  # of the curve, which are no measurements
EXTRA = "pip install -e '.[trackers]'"
PROJECT = "cycleik-bench"
Reporter = Callable[[int, Mapping[str, float]], None]  # takes a step and its row, by column


@dataclass
class TrackerConfig:
    """Which tracker."""

    kind: str = MISSING

    def __post_init__(self) -> None:
        """Refuse trackers that there are not."""
        if self.kind not in TRACKERS:
            raise ValueError(
                f"tracker.kind must be one of {', '.join(TRACKERS)}, got {self.kind!r}"
            )


@contextmanager
def _silent(folder: Path, name: str, settings: Mapping[str, Any]) -> Iterator[Reporter]:
    """Keep nothing."""
    yield lambda step, row: None


@contextmanager
def _tensorboard(folder: Path, name: str, settings: Mapping[str, Any]) -> Iterator[Reporter]:
    """Write a run's event file, in place of an earlier one of the same name."""
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ImportError as error:
        raise MissingPackageError(f"tracker=tensorboard needs tensorboard: {EXTRA}") from error
    writer: Any = SummaryWriter(str(folder / name.replace(" ", "/")), purge_step=0)

    def report(step: int, row: Mapping[str, float]) -> None:
        for key, value in _measured(row).items():
            writer.add_scalar(key, value, step)

    with writer:
        writer.add_text("settings", _markdown(settings))
        yield report


@contextmanager
def _mlflow(folder: Path, name: str, settings: Mapping[str, Any]) -> Iterator[Reporter]:
    """Log a run to a database of the folder; one that does not reach its end is marked killed."""
    os.environ.setdefault("MLFLOW_DISABLE_TELEMETRY", "true")
    try:
        from mlflow import MlflowClient
    except ImportError as error:
        raise MissingPackageError(f"tracker=mlflow needs mlflow: {EXTRA}") from error
    database = folder.absolute() / "mlflow.db"
    with exclusive(database):  # workers of a search come at once, and one must make its tables
        client: Any = MlflowClient(f"sqlite:///{database}")
        known = client.get_experiment_by_name(PROJECT)
        experiment = known.experiment_id if known else client.create_experiment(PROJECT)
    run = client.create_run(experiment, run_name=name).info.run_id

    def report(step: int, row: Mapping[str, float]) -> None:
        for key, value in _measured(row).items():
            client.log_metric(run, key, value, step=step)

    status = "KILLED"
    try:
        for key, value in settings.items():
            client.log_param(run, key, value)
        yield report
        status = "FINISHED"
    finally:
        client.set_terminated(run, status)


Tracker = Callable[[Path, str, Mapping[str, Any]], AbstractContextManager[Reporter]]
TRACKERS: Mapping[str, Tracker] = {
    NONE: _silent,
    TENSORBOARD: _tensorboard,
    MLFLOW: _mlflow,
}


def tracked(
    config: TrackerConfig, folder: Path, name: str, settings: Mapping[str, Any]
) -> AbstractContextManager[Reporter]:
    """Give what a run reports to, and close it whatever ends the run.

    Args:
        config: Which tracker.
        folder: Where it writes.
        name: Of the run, such as ``train panda compact``.
        settings: Of the run, nested as in the configuration: numbers, texts and lists.

    Raises:
        MissingPackageError: The tracker's package is not there.
    """
    return TRACKERS[config.kind](folder, name, dict(_flat(settings)))


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
