"""A grasp trial run once more, its states recorded."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pipeline.embodiment.series import AgentSeries
from pipeline.grasping.series import Series
from pipeline.viewing.errors import ViewError
from pipeline.viewing.recording import Frame, Recording, StateRecorder


def run_again(
    runner: Any,
    number: int,
    rate: float,
    film: Path | None,
    shown: Callable[[Recording, Frame], object] = lambda recording, frame: None,
) -> tuple[Recording, dict[str, Any]]:
    """Simulate a trial as the stage `grasp` does.

    With an agent all of the row of objects is simulated and recorded: one instruction is one
    episode, and the trial's own part lies somewhere in it.

    Args:
        runner: The trials of a run, with or without an agent.
        number: Number of the trial.
        rate: Frames a second of simulated time [Hz].
        film: File of a film that is written as well; None for no film.
        shown: Called with each frame as it comes.

    Returns:
        What happened, and the raw row.

    Raises:
        ViewError: The runner has no trials of that kind.
    """
    if isinstance(runner, AgentSeries):
        experiment = replace(runner.experiment, folder=None)
        series = experiment.series
        recorder = StateRecorder(series.config.recording, rate, film is not None, shown)
        width = experiment.per_row
        row = experiment.row(number // width, recorder.attach)[number % width]
    elif isinstance(runner, Series):
        recorder = StateRecorder(runner.config.recording, rate, film is not None, shown)
        row = runner.trial(number, recorder)
    else:
        raise ViewError("a study has no trials of its own to watch: set its values instead")
    if film is not None:
        recorder.write(film)
    return recorder.recording, row
