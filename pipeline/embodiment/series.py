"""A series of rows with an agent: resumable, and filmed where the configuration asks for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.data.rows import RowCheckpoint
from pipeline.embodiment.trials import Experiment
from pipeline.grasping.series import STILLS, clear_films, film_name, filmed_trials
from pipeline.grasping.video import Recorder

REPEATABLE = ("none", "policy")  # agents that answer the same again, so that a film shows the row


@dataclass(frozen=True)
class AgentSeries:
    """The trials of an experiment with an agent.

    Attributes:
        experiment: What all rows share.
    """

    experiment: Experiment

    def run(
        self, kept: RowCheckpoint, progress: Callable[[dict[str, Any]], object]
    ) -> pd.DataFrame:
        """Run the rows whose trials are not yet kept, and return one raw row a trial.

        The last row may have more objects than trials are wanted: it is run whole, and the raw rows
        beyond the wanted number are left out.

        Args:
            kept: Finished trials; a killed series goes on with the row that was cut off.
            progress: Called with each raw row, also with those that were kept.
        """
        rows: list[dict[str, Any]] = []
        for number, trials in self._trials_of_rows().items():
            found = [row for trial in trials if (row := kept.get(trial)) is not None]
            if len(found) < len(trials):
                found = self.unit(number)
                for row in found:
                    kept.put(row)
            for row in found:
                rows.append(row)
                progress(row)
        return pd.DataFrame(rows)

    def pending(self, kept: RowCheckpoint) -> list[int]:
        """Numbers of the rows that are not yet kept whole: units of work that need no other."""
        rows = self._trials_of_rows().items()
        return [number for number, trials in rows if any(kept.get(one) is None for one in trials)]

    def unit(self, number: int) -> list[dict[str, Any]]:
        """Run one row and return the raw rows of the trials that are wanted of it."""
        return self.experiment.row(number)[: len(self._trials_of_rows()[number])]

    def _trials_of_rows(self) -> dict[int, range]:
        wanted, width = self.experiment.series.config.trials, self.experiment.per_row
        starts = enumerate(range(0, wanted, width))
        return {number: range(start, min(start + width, wanted)) for number, start in starts}

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
