"""Every published number beside ours, with its interval, or with the reason why there is none."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import pairwise
from typing import Any

from pipeline.errors import PipelineError
from pipeline.presentation.columns import ROBOT, Column, number, text
from pipeline.presentation.naming import OUTCOMES, robot_title, solver_title
from pipeline.presentation.published import Published
from pipeline.presentation.table import Table
from pipeline.reporting.evidence import Evidence, Measured

POSE = 7  # numbers that a network is given: position and quaternion
SETTINGS = "hyperparameters"  # the table of numbers that are chosen, not measured
FRACTION_EQUAL = 1e-3  # a setting that was taken over is the published one but for its rounding


@dataclass(frozen=True)
class Setting:
    """What Table I's network of a robot is configured with here.

    Attributes:
        values: Hyperparameters by their name in the published numbers.
        hidden: Neurons of each hidden layer.
        joints: Joints of the robot.
    """

    values: Mapping[str, float]
    hidden: Sequence[int]
    joints: int

    def get(self, metric: str) -> float | str | None:
        """Return the setting behind a published hyperparameter, None where there is none."""
        sizes = [POSE, *self.hidden, self.joints]
        derived: dict[str, float | str] = {
            "hidden_layers": float(len(self.hidden)),
            "neurons_per_layer": " ".join(str(n) for n in self.hidden),
            "parameters": float(sum((a + 1) * b for a, b in pairwise(sizes))),
            "degrees_of_freedom": float(self.joints),
        }
        return derived.get(metric, self.values.get(metric))


@dataclass(frozen=True)
class Line:
    """A published number and what there is of ours.

    Attributes:
        table: Of the published numbers.
        robot: Name of the robot.
        method: Name of the solver.
        metric: Name of the metric.
        unit: Its unit, empty where it has none.
        published: The number as it stands in the file.
        measured: Ours, None where there is none.
        why: Why ours is missing or differs.
    """

    table: str
    robot: str
    method: str
    metric: str
    unit: str
    published: str
    measured: Measured | None
    why: str

    @property
    def ours(self) -> float | str | None:
        """Ours; a setting with all its digits, which are not those of a measurement."""
        value = None if self.measured is None else self.measured.value
        if self.table == SETTINGS and isinstance(value, float):
            return f"{value:.12g}"
        return value

    @property
    def difference(self) -> float | None:
        """Ours minus the published number, where both are one number."""
        if self.measured is None or isinstance(self.measured.value, str):
            return None
        return self.measured.value - float(self.published)

    @property
    def agrees(self) -> bool:
        """Whether ours is the published number, or its interval holds it."""
        found, difference = self.measured, self.difference
        if found is None or difference is None:
            return found is not None and found.value == self.published
        if found.low is not None and found.high is not None:
            return found.low <= float(self.published) <= found.high
        return abs(difference) <= FRACTION_EQUAL * abs(float(self.published))


def _of_measured(name: str) -> Any:
    return lambda line: None if line.measured is None else getattr(line.measured, name)


COLUMNS = (
    text("table", "table"),
    ROBOT,
    text("method", "method", convert=solver_title),
    text("metric", "metric"),
    text("unit", "unit"),
    text("published", "published"),
    Column("ours", "ours", source=lambda line: line.ours, digits=3),
    number("ours_low", "from", _of_measured("low")),
    number("ours_high", "to", _of_measured("high")),
    number("difference", "difference", signed=True),
    text("why", "why"),
    text("rows", "rows", lambda line: line.measured.rows or None if line.measured else None),
)


def every_number(
    published: Published,
    evidence: Evidence,
    settings: Mapping[str, Setting],
    reasons: Sequence[Mapping[str, str]],
) -> list[Line]:
    """Set every published number beside ours.

    Args:
        published: The paper's numbers.
        evidence: Tables on disk.
        settings: What Table I's networks are configured with here, by robot.
        reasons: Each a text ``why`` under patterns of table, robot, method and metric, and
            optionally ``ours: measured`` or ``missing``; the first that fits is taken.

    Returns:
        A line a number, in the order of the file.

    Raises:
        PipelineError: A number has neither agreement nor a reason.
    """
    lines = []
    for row in published.rows.to_dict("records"):
        key = {name: str(row[name]) for name in ("table", "robot", "method", "metric")}
        measured = _measure(key, evidence, settings)
        why = _reason(reasons, {**key, "ours": "measured" if measured else "missing"})
        line = Line(**key, unit=row["unit"], published=row["value"], measured=measured, why=why)
        if not (line.why or line.agrees):
            raise PipelineError(
                f"{' '.join(key.values())} is published as {line.published} and ours "
                f"{'differs' if measured else 'is missing'}: results/claims.yaml gives no reason"
            )
        lines.append(line)
    return lines


def numbers_table(lines: Sequence[Line]) -> Table:
    """The table of every published number."""
    ours = sum(line.measured is not None for line in lines)
    return Table.of(
        lines,
        COLUMNS,
        name="every_number",
        title="Every published number",
        caption=f"All {len(lines)} numbers of the paper; {ours} have one of ours beside them, the "
        "others the reason why not. Intervals are 95 %: normal for means, Wilson for rates.",
    )


def _measure(
    key: Mapping[str, str], evidence: Evidence, settings: Mapping[str, Setting]
) -> Measured | None:
    table, robot, method, metric = (key[k] for k in ("table", "robot", "method", "metric"))
    if table == SETTINGS:
        setting = settings[robot].get(metric) if robot in settings else None
        return None if setting is None else Measured(setting)
    if table == "numerical_comparison":
        return evidence.precision(robot, method, metric)
    if table == "neural_comparison" and method == "cycleik":
        if metric == "time_per_batch_of_100":
            named = {"robot": robot_title(robot), "solver": solver_title(method)}
            return evidence.number("table3_neural_comparison", metric, **named)
        return evidence.precision(robot, method, metric)  # the same network on the same poses
    if table == "grasping":
        return evidence.outcome(robot, OUTCOMES[metric])
    if table == "planner":
        # NICO's network has few of the random pairs in reach as a whole.
        return evidence.number("planner", "time_median_ms", robot="NICOL", solver="CycleIK")
    return None


def _reason(reasons: Sequence[Mapping[str, str]], facts: Mapping[str, str]) -> str:
    for reason in reasons:
        patterns = {name: pattern for name, pattern in reason.items() if name != "why"}
        if all(fnmatchcase(facts[name], pattern) for name, pattern in patterns.items()):
            return reason["why"]
    return ""
