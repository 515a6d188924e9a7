"""Studies of what a grasp depends on: the same trials again, with one or two settings varied."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from pipeline.data.rows import Resumable
from pipeline.grasping.config import GraspConfig
from pipeline.grasping.outcome import CLASSES
from pipeline.grasping.series import Series

if TYPE_CHECKING:
    from baselines import Solver

KEY = ("variant", "trial")  # what tells one row of a study from another
PHYSICS = ("rate", "iterations", "noise_seed")  # settings that are the engine's
HARDWARE = ("zero_offset", "backlash", "mass_spread")  # and those of the robot's errors


@dataclass(frozen=True)
class Study(Resumable):
    """A study of one robot.

    Attributes:
        series: The trials with the settings that are not varied.
        solver_of: Loads a solver by its name.
    """

    series: Series
    solver_of: Callable[[str], Solver]

    @property
    def trials(self) -> int:
        """Trials of all variants together."""
        return len(self.units())

    def units(self) -> dict[tuple[int, int], list[tuple[object, ...]]]:
        """Return variant and number of all trials, each with its key by `KEY`."""
        trials = range(self.series.config.trials)
        return {(v, n): [(v, n)] for v in range(len(self._settings)) for n in trials}

    def unit(self, unit: tuple[int, int]) -> list[dict[str, Any]]:
        """Run one trial of a variant and return its raw row."""
        variant, number = unit
        values = self._settings[variant]
        if variant not in self._loaded:
            self._loaded.clear()
            self._loaded[variant] = self.varied(values)
        row = {"study": self._name, "axes": ",".join(values), "variant": variant}
        return [row | self._loaded[variant].trial(number)]

    def varied(self, values: dict[str, Any]) -> Series:
        """The trials with some settings changed."""
        config = changed(self.series.config, values)
        solver = self.solver_of(config.solver) if "solver" in values else self.series.solver
        return replace(self.series, config=config, solver=solver)

    def film(self, rows: pd.DataFrame, folder: Path) -> list[Path]:
        """Film the first trial of each class of outcome, if the configuration asks for classes."""
        if self.series.config.video != "classes":
            return []
        films = []
        for name in CLASSES:
            for row in rows[rows["class"] == name].head(1).to_dict("records"):
                series = self.varied(self._settings[row["variant"]])
                films.append(series.film_trial(int(row["trial"]), folder, f"{self._name}_"))
        return films

    @cached_property
    def _settings(self) -> list[dict[str, Any]]:
        return list(variants(self.series.config))

    @cached_property
    def _loaded(self) -> dict[int, Series]:
        """The variant that ran last, its solver loaded."""
        return {}

    @property
    def _name(self) -> str:
        ablation = self.series.config.ablation
        assert ablation is not None
        return ablation.study


def variants(config: GraspConfig) -> Iterator[dict[str, Any]]:
    """Every combination of the values that a study varies, in order; none without a study."""
    if config.ablation is None:
        return
    axes = config.ablation.vary
    for values in product(*axes.values()):
        yield dict(zip(axes, values, strict=True))


def changed(config: GraspConfig, values: dict[str, Any]) -> GraspConfig:
    """The experiment with some settings changed.

    Raises:
        ValueError: A value that the setting cannot have.
    """
    physics = {name: value for name, value in values.items() if name in PHYSICS}
    hardware = {name: value for name, value in values.items() if name in HARDWARE}
    others = {name: value for name, value in values.items() if name not in PHYSICS + HARDWARE}
    timing = replace(config.timing, rate=physics["rate"]) if "rate" in physics else config.timing
    return replace(
        config,
        physics=replace(config.physics, **physics),
        hardware=replace(config.hardware, **hardware),
        timing=timing,
        **others,
    )
