"""A whole run of the graph as units: what each needs, how long it will take, whether it is done."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline import provenance
from pipeline.closure import source_tree
from pipeline.containers import to_dict
from pipeline.data.files import read_json, write_json
from pipeline.engine.scheduler import Command, duration
from pipeline.reporting.results import LEFT_OUT
from pipeline.stages.code_files import roots
from pipeline.stages.forecast import core_seconds
from pipeline.stages.graph import STAGES, Step, runs
from pipeline.stages.parameters import read_groups

if TYPE_CHECKING:
    from pipeline.settings import Config

STAMPS = "whole_run"  # folder below the results: a stamp for each unit that is done
REPORT = "report"  # step that is run whatever is there, and whenever something may be new
SECONDS_PER_HOUR = 3600.0


@dataclass(frozen=True)
class Unit:
    """One run of a step.

    Attributes:
        step: The step.
        axes: Value of each of its axes.
        overrides: Of its command.
        config: That these compose to.
        seconds: What it is expected to take, of one core.
        key: Digest of what shapes its outputs: values, code, and the keys of what it reads.
        needs: Names of the units that it reads.
        outputs: Files and folders that it leaves.
    """

    step: Step
    axes: Mapping[str, str]
    overrides: tuple[str, ...]
    config: Config
    seconds: float
    key: str
    needs: tuple[str, ...]
    outputs: tuple[Path, ...]

    @property
    def name(self) -> str:
        """Step and values of its axes."""
        return name_of(self.step.name, self.axes)

    @property
    def stamp(self) -> Path:
        """File that says that it is done."""
        return Path(self.config.results_dir) / STAMPS / f"{self.name}.json"

    @property
    def is_done(self) -> bool:
        """Whether it has run with these values and this code, and its outputs are there."""
        if self.step.name == REPORT:
            return False
        if not self.stamp.exists() or not all(path.exists() for path in self.outputs):
            return False
        return bool(read_json(self.stamp).get("key") == self.key)

    def sign(self, seconds: float) -> None:
        """Say that it is done, and how long it took."""
        signed = provenance.signature(self.config.profile)
        machine = provenance.machine()["processor"]
        write_json(
            self.stamp, {"key": self.key, "seconds": seconds, "processor": machine, **signed}
        )


class UnitTasks:
    """Units as tasks that may run side by side.

    Attributes:
        needs: Names of the units that each unit reads.
    """

    def __init__(self, every: Sequence[Unit], side_by_side: int) -> None:
        """Run nothing yet.

        Args:
            every: All units.
            side_by_side: How many run at a time, for the record of those that are timed.
        """
        self._units = {unit.name: unit for unit in every}
        self._beside = f"evaluate.side_by_side={side_by_side}"
        self.needs: Mapping[str, frozenset[str]] = {
            unit.name: frozenset(unit.needs) for unit in every
        }

    def is_stale(self, name: str) -> bool:
        """Whether a unit is not done."""
        return not self._units[name].is_done

    def begin(self, name: str) -> bool:
        """Prepare nothing: a stage takes up what it left itself."""
        return True

    def command(self, name: str) -> Command:
        """Return the command of a unit."""
        unit = self._units[name]
        beside = [self._beside] if unit.step.stage == "evaluate" else []
        stage = [sys.executable, "-m", "pipeline", unit.step.stage]
        return Command([*stage, *unit.overrides, *beside])

    def finish(self, name: str, seconds: float) -> None:
        """Sign a unit."""
        self._units[name].sign(seconds)

    def seconds(self, name: str) -> float:
        """Return what a unit takes by rates, which follow sizes as no record of a run does [s]."""
        return self._units[name].seconds


def name_of(step: str, axes: Mapping[str, str]) -> str:
    """Return the name of a unit, which is that of its stamp and log too."""
    return "-".join([step, *axes.values()])


def units(
    lists: Mapping[str, list[str]],
    overrides: Callable[[Step, dict[str, str]], Sequence[str]],
    compose: Callable[[Sequence[str]], Config],
) -> list[Unit]:
    """Return the units of a whole run, each after those that it reads.

    Args:
        lists: Lists of conf/bench.yaml.
        overrides: Gives the overrides of a step for values of its axes.
        compose: Makes a configuration of overrides.
    """
    found: dict[str, Unit] = {}
    for step, axes in runs(lists):
        words = tuple(overrides(step, axes))
        config = compose(words)
        needs = _needs(step, axes, found)
        outputs = tuple(_output(output.path, axes, config) for output in step.outputs)
        unread = [found[name].key for name in needs]
        key = provenance.digest([_values(step, config), _code(step, axes, config), unread])
        seconds = core_seconds(step.stage, config)
        unit = Unit(step, axes, words, config, seconds, key, needs, outputs)
        found[unit.name] = unit
    return list(found.values())


def left_out(every: Sequence[Unit], most_hours: float) -> dict[str, str]:
    """Return the units that are not run, by name, and why.

    Args:
        every: Each after those that it reads.
        most_hours: Of one core: a unit that takes longer is left out, and what reads it as well.
    """
    reasons: dict[str, str] = {}
    for unit in every:
        missing = [name for name in unit.needs if name in reasons]
        if unit.is_done or unit.step.name == REPORT:
            continue
        if unit.seconds > most_hours * SECONDS_PER_HOUR:
            reasons[unit.name] = f"would take {duration(unit.seconds)} of one core"
        elif missing:
            reasons[unit.name] = f"needs {missing[0]}, which is left out"
    return reasons


def write_left_out(folder: Path, every: Sequence[Unit], reasons: Mapping[str, str]) -> None:
    """Write down what is not run, for the report."""
    rows: list[dict[str, Any]] = [
        {"step": unit.step.name, **unit.axes, "hours": unit.seconds / SECONDS_PER_HOUR, "why": why}
        for unit in every
        if (why := reasons.get(unit.name))
    ]
    signed = provenance.signature(every[0].config.profile)
    facts = {**signed, "seed": every[0].config.seed, **provenance.made_by()}
    write_json(folder / LEFT_OUT, {"left_out": rows, **facts})


def _needs(step: Step, axes: Mapping[str, str], before: Mapping[str, Unit]) -> tuple[str, ...]:
    """Units of earlier steps with the same robot; all of them for a step without a robot."""
    robot = axes.get("robot")
    return tuple(
        name
        for name, unit in before.items()
        if unit.step.name in step.inputs and robot in (None, unit.axes.get("robot"))
    )


def _output(path: str, axes: Mapping[str, str], config: Config) -> Path:
    names = {**axes, "model": config.model.name}
    return Path(config.results_dir) / re.sub(r"\{(\w+)\}", lambda m: names[m[1]], path)


def _values(step: Step, config: Config) -> Any:
    """The values that shape what a step leaves."""
    whole = to_dict(config)
    found: dict[str, Any] = {"seed": config.seed}
    for group in read_groups(step):
        part: Any = whole
        for name in group.split("."):
            part = part[name]
        if group == "solver":
            names = {*STAGES[step.stage].solver_names(config), *step.settings}
            part = {name: part[name] for name in sorted(names)}
        found[group] = part
    return found


def _code(step: Step, axes: Mapping[str, str], config: Config) -> str:
    return source_tree().digest(*roots(step, axes.get("solver", ""), config))
