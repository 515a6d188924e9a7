"""What networks learned from, how they were trained, and with which settings (Table I)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.learning.registry import kinds, method_of
from pipeline.presentation.columns import ROBOT, Cell, count, number, share, text, under
from pipeline.presentation.naming import ordered_robots, robot_title
from pipeline.presentation.published import Published
from pipeline.presentation.style import legend_below, logarithmic, looks, panels
from pipeline.presentation.table import Table
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.results import Results
from pipeline.tuning.hyperparameters import (
    COLUMNS,
    SOURCE,
    TABLE,
    Hyperparameters,
    published_hyperparameters,
)

SPLITS = ("train", "validation", "test")
SMOOTHING = 25  # points of a moving median over the noisy batch errors
KINDS = (("position_error_mm", "position [mm]"), ("rotation_error_deg", "rotation [deg]"))
Trained = Mapping[tuple[str, str], tuple[dict[str, Any], pd.DataFrame]]


def origin(card: Mapping[str, Any]) -> str:
    """Say where a network of the results comes from: from this run or with the project."""
    return "with the project" if card.get("shipped") else "this run"


def hyperparameters(results: Results, published: Published) -> Table:
    """Table I: what the paper's search found beside what was trained and found here."""
    rows: list[Hyperparameters] = []
    for robot in ordered_robots([*results.robots, *published.robots(TABLE)]):
        rows += published_hyperparameters(published, robot)
        for (name, model), (card, _) in results.train.items():
            if name == robot:
                config, parameters = card.get("config") or {}, card.get("parameters")
                source = f"{origin(card)}: {model}"
                rows.append(Hyperparameters.of(robot, source, config, parameters=parameters))
        if robot in results.tune:
            trials, best = results.tune[robot]
            rows.append(Hyperparameters.of(robot, f"this run: best of {len(trials)} trials", best))
    return Table.of(
        rows,
        (ROBOT, SOURCE, *COLUMNS),
        name="table1_hyperparameters",
        title="Table I: hyperparameters",
        caption="The paper's best of 200 trials a robot, the networks of this run, trained in it "
        "or as they come with the project, and the best trial of this run's search where there was "
        "one. Learning rate in units of 1e-4.",
    )


def datasets(results: Results) -> Table:
    """Sizes, acceptance and seeds of the pose sets."""
    lines = []
    for robot in ordered_robots(results.dataset):
        splits = results.dataset[robot].get("splits") or {}
        order = [*(s for s in SPLITS if s in splits), *(s for s in splits if s not in SPLITS)]
        lines += [{"robot": robot, "split": split, "facts": splits[split]} for split in order]

    def fact(name: str) -> Any:
        return lambda line: line["facts"].get(name)

    return Table.of(
        lines,
        (
            ROBOT,
            text("split", "Set"),
            count("poses", "poses", fact("poses")),
            share("acceptance", "acceptance [%]", fact("acceptance")),
            count("in_collision", "in collision", fact("in_collision")),
            count("outside_workspace", "outside the box", fact("outside_workspace")),
            text("seed", "seed", fact("seed"), convert=str),
        ),
        name="datasets",
        title="Pose sets",
        caption="Uniform joint samples without self-collision; the paper: 1,000,000 / 100,000 / "
        "200,000 poses a robot. Acceptance is the share of samples that were kept.",
    )


@dataclass(frozen=True)
class Training:
    """One network of this run: its names, the card of its weights and its curve."""

    robot: str
    model: str
    card: dict[str, Any]
    curve: pd.DataFrame

    def last(self, column: str) -> int | None:
        """Return the last value of a column of the curve, None where there is none."""
        known = column in self.curve and len(self.curve)
        return int(self.curve[column].iloc[-1]) if known else None

    def error(self, name: str) -> Any:
        """Return a figure of the validation set at the end."""
        return (self.card.get("validation") or {}).get(name)

    @property
    def loss(self) -> Cell:
        """Name of the loss: that of the method where it has one, whatever `train.loss` says."""
        config = self.card.get("config") or {}
        kind = (config.get("model") or {}).get("kind")
        own = method_of(kind).trained_for if kind in kinds() else ""
        loss: Cell = own or (config.get("train") or {}).get("loss")
        return loss


def _error(name: str) -> Any:
    return lambda line: line.error(name)


TRAINING = (
    ROBOT,
    text("model", "Model"),
    text("trained", "trained", lambda line: origin(line.card)),
    count("parameters", "parameters", lambda line: line.card.get("parameters")),
    count("steps", "steps", lambda line: line.last("step")),
    count("samples", "poses seen", lambda line: line.last("samples")),
    text("loss", "loss"),
    *under(
        "validation set, Euclidean and geodesic",
        number("position_error_mm", "position [mm]", _error("position_error_mm")),
        number("rotation_error_deg", "rotation [deg]", _error("rotation_error_deg")),
        share("success_10mm_20deg", "within 10 mm, 20 deg [%]", _error("success_10mm_20deg")),
    ),
    count("skipped_steps", "steps skipped", _error("skipped_steps")),
    text("device", "device", lambda line: line.card.get("device")),
)


def training(results: Results) -> Table:
    """What was trained, for how long, and how well it did on the validation set."""
    return Table.of(
        [
            Training(robot, model, card, curve)
            for robot in ordered_robots(robot for robot, _ in results.train)
            for (name, model), (card, curve) in results.train.items()
            if name == robot
        ],
        TRAINING,
        name="training",
        title="Training",
        caption="Networks of this run and their mean errors on its validation set. Those that come "
        "with the project were trained before, by the recipe on the model's name, and are judged "
        "here: no steps, poses or curves of theirs belong to this run (`networks: default` in "
        "conf/bench.yaml trains them again).",
    )


def training_curves(trained: Trained) -> Figure:
    """Errors on the validation set and on the batches while each network was trained."""
    drawn = {key: curve for key, (_, curve) in trained.items() if len(curve)}
    robots = ordered_robots(robot for robot, _ in drawn)
    look = looks(model for _, model in drawn)
    figure, axes = panels(len(robots) * len(KINDS), 3.7, 2.3, columns=len(KINDS))
    places = [(robot, kind) for robot in robots for kind in KINDS]
    for axis, (robot, (column, label)) in zip(axes, places, strict=True):
        for (name, model), curve in drawn.items():
            if name == robot:
                _curve(axis, curve, column, look[model].colour, model)
        axis.set(ylabel=label, xlabel="poses seen [million]", title=robot_title(robot))
        logarithmic(axis, "y")
    legend_below(figure, axes)
    return figure


def _curve(axis: Axes, curve: pd.DataFrame, column: str, colour: str, model: str) -> None:
    millions = curve["samples"] / 1e6
    if column in curve:
        smooth = curve[column].rolling(SMOOTHING, min_periods=1, center=True).median()
        axis.plot(millions, smooth, color=colour, alpha=0.35, label=f"{model}, batches")
    validation = f"validation_{column}"
    if validation in curve:
        kept = curve[validation].notna()
        axis.plot(
            millions[kept],
            curve[validation][kept],
            "o-",
            color=colour,
            markersize=3.5,
            label=f"{model}, validation",
        )


TOPIC = Topic(
    stages=("train",),
    tables=(
        lambda data: hyperparameters(data.results, data.published),
        lambda data: datasets(data.results),
        lambda data: training(data.results),
    ),
    plots=(
        Plot(
            "training_curves",
            "Mean Euclidean and geodesic errors while training; batches smoothed by a moving "
            "median.",
            lambda data: any(len(curve) for _, curve in data.results.train.values()),
            lambda data: training_curves(data.results.train),
        ),
    ),
)
