"""A series of trials: resumable row by row, filmed where the configuration asks for it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from pipeline.data.rows import Resumable
from pipeline.grasping.config import GraspConfig
from pipeline.grasping.outcome import CLASSES
from pipeline.grasping.trial import run_trial
from pipeline.grasping.video import Recorder

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

KEY = ("trial",)  # what tells one row from another
FILMED = (".mp4", ".gif", ".png")  # what a film leaves
STILLS = 4  # columns of a contact sheet


@dataclass(frozen=True)
class Series(Resumable):
    """What all trials of a series share.

    Attributes:
        config: The experiment.
        robot: The robot.
        solver: Inverse kinematics of its motions.
        repair: Solver that repairs waypoints, or None.
        seed: Root seed.
    """

    config: GraspConfig
    robot: Robot
    solver: Solver
    repair: Solver | None
    seed: int

    def units(self) -> dict[int, list[tuple[object, ...]]]:
        """Return the numbers of all trials, each with its key by `KEY`."""
        return {number: [(number,)] for number in range(self.config.trials)}

    def unit(self, number: int) -> list[dict[str, Any]]:
        """Run one unit of work and return its raw rows."""
        return [self.trial(number)]

    def trial(self, number: int, recorder: Recorder | None = None) -> dict[str, Any]:
        """Run one trial; its number and the seed fix everything."""
        return run_trial(
            self.config, self.robot, self.solver, number, self.seed, self.repair, recorder
        )

    def film(self, rows: pd.DataFrame, folder: Path) -> list[Path]:
        """Run the trials that are to be filmed once more, now with the camera on.

        A trial is a function of its number, so the film shows what the row says. Films that an
        earlier run left in the folder are removed.

        Returns:
            The videos; beside each lies a contact sheet of stills as PNG.
        """
        clear_films(folder)
        numbers = filmed_trials(self.config.video, rows)
        return [self.film_trial(number, folder) for number in numbers]

    def film_trial(self, number: int, folder: Path, prefix: str = "") -> Path:
        """Run one trial with the camera on; stills and a GIF lie beside the MP4 it returns."""
        recorder = Recorder(self.config.recording)
        path = folder / film_name(number, str(self.trial(number, recorder)["class"]), prefix)
        recorder.write(path)
        recorder.stills(STILLS).save(path.with_suffix(".png"))
        return path


def film_name(number: int, outcome: str, prefix: str = "") -> str:
    """Name of the film of a trial."""
    return f"{prefix}trial{number:03d}_{outcome.lower().replace(' ', '_')}.mp4"


def clear_films(folder: Path) -> None:
    """Remove the films that an earlier run left in a folder."""
    for old in folder.glob("trial*_*"):
        if old.suffix in FILMED:
            old.unlink()


def filmed_trials(video: str, rows: pd.DataFrame) -> list[int]:
    """Numbers of the trials to film: all, the first of each class, the first, or none."""
    if video == "all":
        return [int(number) for number in rows["trial"]]
    if video == "classes":
        firsts = [rows.loc[rows["class"] == name, "trial"].head(1) for name in CLASSES]
        return sorted(int(number) for first in firsts for number in first)
    return [int(number) for number in rows["trial"].head(1)] if video == "first" else []
