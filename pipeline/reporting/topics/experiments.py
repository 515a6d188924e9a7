"""Experiments on demand: secondary goals of training, many solutions of one pose."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from pipeline.evaluation.sampling import drawn_rows, spread
from pipeline.presentation.columns import ROBOT, SOLVER, count, number, share, text, under
from pipeline.presentation.naming import ordered_robots
from pipeline.presentation.table import Table
from pipeline.reporting.data import Topic
from pipeline.reporting.results import Results
from pipeline.reporting.sweeps import SweptRun, alike
from robots import load_robot
from robots.kinematics import forward_kinematics

ANSWERING = "cycleik"  # the solver whose answers show what a secondary goal does
WIDE_RAD = 0.2  # a joint whose solutions spread by that much moves visibly


@dataclass(frozen=True)
class Constrained:
    """A training with secondary goals: its run, its answers, and the run without them."""

    run: SweptRun
    rows: pd.DataFrame
    free: Constrained | None = None

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return self.run.robot

    @property
    def scale(self) -> float:
        """Factor of all secondary goals."""
        scale: float = self.run.train["constraint_scale"]
        return scale

    def mean(self, error: str) -> float:
        """Return the mean of an error over the test poses."""
        return float(self.rows[error].mean())

    def cost(self, error: str) -> float | None:
        """Return how much larger an error is than without the goals."""
        return None if self.free is None else self.mean(error) - self.free.mean(error)

    @property
    def goal(self) -> str:
        """The goals in words."""
        return "; ".join(_goal(goal) for goal in self.run.train["constraints"])

    @property
    def distance(self) -> float | None:
        """Mean distance of all joints with a goal from their posture; None where none has one."""
        names, distances = list(self.run.card["joint_names"]), []
        for goal in self.run.train["constraints"]:
            if goal.get("joints") is None:
                continue
            columns = [f"q{names.index(j) if j in names else int(j)}" for j in goal["joints"]]
            posture = np.asarray(goal["posture"], dtype=float)
            distances.append(np.abs(self.rows[columns].to_numpy(dtype=float) - posture).ravel())
        return float(np.concatenate(distances).mean()) if distances else None

    @property
    def reduction(self) -> float | None:
        """How many times nearer to the goal the joints are than without it."""
        free = None if self.free is None else self.free.distance
        return free / self.distance if self.distance and free is not None else None

    @cached_property
    def link_distance(self) -> float | None:
        """Mean distance of all links with a goal from its position [mm]; None where none has."""
        goals = [goal for goal in self.run.train["constraints"] if goal.get("link") is not None]
        if not goals:
            return None
        robot, distances = load_robot(self.robot), []
        joints = self.rows[[f"q{number}" for number in range(robot.dof)]].to_numpy(dtype=float)
        for goal in goals:
            place = goal["position"] if goal.get("pose") is None else goal["pose"][:3]
            reached = forward_kinematics(robot.chain_to(goal["link"]), joints)[:, :3]
            distances.append(np.linalg.norm(reached - np.asarray(place, dtype=float), axis=1))
        return float(1e3 * np.concatenate(distances).mean())

    @property
    def colliding(self) -> float | None:
        """Share of answers in which the robot hits itself; None where nothing tells."""
        if "self_collision" not in self.rows:  # older rows
            return None
        told = self.rows["self_collision"].dropna()
        return float(told.astype(bool).mean()) if len(told) else None

    @property
    def link_reduction(self) -> float | None:
        """How many times nearer to the goal the links are than without it."""
        free = None if self.free is None else self.free.link_distance
        return free / self.link_distance if self.link_distance and free is not None else None


def _mean(error: str) -> Callable[[Constrained | Drawn], float]:
    return lambda line: line.mean(error)


def _cost(error: str) -> Callable[[Constrained], float | None]:
    return lambda line: line.cost(error)


CONSTRAINTS = (
    ROBOT,
    text("model", "Model", lambda line: line.run.model),
    text("goal", "Goal"),
    text("scale", "Scale"),
    *under(
        "distance from the goal [rad]",
        number("distance_rad", "mean", "distance"),
        number("reduction", "times smaller"),
    ),
    *under(
        "distance of links from the goal [mm]",
        number("link_distance_mm", "mean", "link_distance"),
        number("link_reduction", "times smaller"),
    ),
    share("colliding", "answers in self-collision [%]", decimals=2),
    *under(
        "position error [mm]",
        number("position_error_mm", "mean", _mean("position_error_mm")),
        number("position_cost_mm", "Δ", _cost("position_error_mm"), signed=True),
    ),
    *under(
        "rotation error [deg]",
        number("rotation_error_deg", "mean", _mean("rotation_error_deg")),
        number("rotation_cost_deg", "Δ", _cost("rotation_error_deg"), signed=True),
    ),
)


def constraints(results: Results) -> Table:
    """What secondary goals of training do to the joints, and what they cost in precision."""
    return Table.of(
        _constrained(results),
        CONSTRAINTS,
        name="constraints",
        title="Secondary goals of training",
        caption="The same network trained with goals for joints or links beside the pose, or for a "
        "clearance of its links from each other, and without (scale 0). Distance: mean over test "
        "poses and chosen joints or links of the distance from the goal. Errors: Euclidean and "
        "geodesic mean on the test set, without refinement.",
    )


@dataclass(frozen=True)
class Drawn:
    """Solutions that a solver drew of test poses, as drawn or after refinement."""

    robot: str
    solver: str
    refined: bool
    rows: pd.DataFrame

    @cached_property
    def spreads(self) -> pd.DataFrame:
        """Standard deviation of each joint [rad], a row a pose."""
        return spread(self.rows)

    @property
    def spread_rad(self) -> str:
        """Mean of the spread over the poses, joint by joint."""
        return " ".join(f"{width:.2f}" for width in self.spreads.mean())

    @property
    def wide(self) -> pd.Series:
        """Number of wide joints, by pose."""
        return (self.spreads >= WIDE_RAD).sum(axis=1)

    def mean(self, column: str) -> float:
        """Return the mean of a column."""
        return float(self.rows[column].mean())


def _refined(cell: Callable[[Drawn], float]) -> Callable[[Drawn], float | None]:
    return lambda line: cell(line) if line.refined else None


SOLUTIONS = (
    ROBOT,
    SOLVER,
    text("refined", "Stage", lambda line: "refined" if line.refined else "drawn"),
    count("poses", "poses", lambda line: line.rows.pose.nunique()),
    count("samples", "solutions of each", lambda line: line.rows["sample"].nunique()),
    *under(
        "wide joints of a pose",
        number("wide_median", "median", lambda line: line.wide.median(), None),
        count("wide_least", "least", lambda line: line.wide.min()),
        share(
            "three_wide", "poses with three or more [%]", lambda line: (line.wide >= 3).mean(), 0
        ),
    ),
    text("spread_rad", "spread by joint [rad]"),
    number("position_error_mm", "position error [mm]", _mean("position_error_mm")),
    number("rotation_error_deg", "rotation error [deg]", _mean("rotation_error_deg")),
    share("found", "found [%]", _refined(lambda line: line.mean("found"))),
    share("left", "restarted [%]", _refined(lambda line: float((line.rows.starts > 1).mean()))),
)


def solutions(results: Results) -> Table:
    """Spread and precision of many solutions of one pose, before and after refinement."""
    return Table.of(
        [
            Drawn(robot, solver, refined, drawn_rows(rows, refined))
            for robot in ordered_robots(robot for robot, _ in results.sample)
            for (name, solver), rows in results.sample.items()
            if name == robot
            for refined in (False, True)
        ],
        SOLUTIONS,
        name="many_solutions",
        title="Many solutions of one pose",
        caption="Solutions that a solver draws of test poses, as drawn and after each was refined "
        "by the compiled Levenberg-Marquardt kernel. Spread: standard deviation of a joint over "
        "the solutions of a pose, mean over poses. Wide joints: those that spread by "
        f"{WIDE_RAD:g} rad or more. Restarted: share of refinements that ended on another start.",
    )


def _constrained(results: Results) -> Iterator[Constrained]:
    """Trainings with secondary goals that left answers, each beside the one without."""
    runs = [run for run in results.swept if run.train.get("constraints")]
    for group in alike(runs, ("constraint_scale",)):
        answers = [(run, run.answers(ANSWERING)) for run in group]
        lines = [Constrained(run, rows) for run, rows in answers if rows is not None]
        free = next((line for line in lines if line.scale == 0), None)
        for line in sorted(lines, key=lambda line: float(line.scale)):
            yield line if line is free else replace(line, free=free)


def _goal(goal: dict[str, Any]) -> str:
    if goal.get("clearance") is not None:
        return f"clearance {goal['clearance']:g} m, weight {goal['weight']:g}"
    if goal.get("joints") is not None:
        names = ", ".join(str(joint) for joint in goal["joints"])
        return f"{names} at {goal['posture']}, weight {goal['weight']:g}"
    place = goal["position"] if goal.get("pose") is None else goal["pose"]
    return f"{goal['link']} at {place}, weight {goal['weight']:g}"


TOPIC = Topic(
    tables=(lambda data: constraints(data.results), lambda data: solutions(data.results)),
    stages=("sweep", "sample"),
)
