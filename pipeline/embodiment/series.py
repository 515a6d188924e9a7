"""A series of rows with an agent: resumable, and filmed where the configuration asks for it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.data.rows import Resumable
from pipeline.embodiment.trials import Experiment
from pipeline.grasping.series import STILLS, clear_films, film_name, filmed_trials
from pipeline.grasping.video import Recorder

REPEATABLE = ("none", "policy", "local")  # agents that answer the same again: a film shows the row


@dataclass(frozen=True)
class AgentSeries(Resumable):
    """The trials of an experiment with an agent.

    Attributes:
        experiment: What all rows share.
    """

    experiment: Experiment

    def units(self) -> dict[int, list[tuple[object, ...]]]:
        """Return the numbers of all rows of objects, each with the keys of its trials.

        The last row may have more objects than trials are wanted: it is run completely, and the raw
        rows beyond the wanted number are left out.
        """
        wanted, width = self.experiment.series.config.trials, self.experiment.per_row
        return {
            start // width: [(trial,) for trial in range(start, min(start + width, wanted))]
            for start in range(0, wanted, width)
        }

    def unit(self, number: int) -> list[dict[str, Any]]:
        """Run one row and return the raw rows of the trials that are wanted of it."""
        return self.experiment.row(number)[: len(self.units()[number])]

    def film(self, rows: pd.DataFrame, folder: Path) -> list[Path]:
        """Run the rows once more whose trials are to be filmed, the camera on during those.

        Only with agents that answer the same again; others are not filmed.

        Returns:
            The videos; beside each lies a contact sheet of stills as PNG.
        """
        clear_films(folder)
        if self.experiment.facts["agent"] not in REPEATABLE:
            return []
        attempted = rows[rows["order"] > 0]
        wanted = filmed_trials(self.experiment.series.config.video, attempted)
        return [
            self._film_trial(row, folder)
            for row in attempted[attempted["trial"].isin(wanted)].to_dict("records")
        ]

    def _film_trial(self, row: dict[Any, Any], folder: Path) -> Path:
        experiment, number = replace(self.experiment, folder=None), int(row["trial"])
        recorder = Recorder(experiment.series.config.recording)
        begin, end = float(row["began_s"]), float(row["began_s"] + row["simulated_s"])
        experiment.row(
            number // experiment.per_row, lambda scene: recorder.attach(scene, begin, end)
        )
        path = folder / film_name(number, str(row["class"]))
        recorder.write(path)
        recorder.stills(STILLS).save(path.with_suffix(".png"))
        return path
