"""Tables of hyperparameters (Table I of the paper), pose sets and training."""

from __future__ import annotations

from typing import Any

import pandas as pd

from pipeline.reporting.naming import (
    ordered_robots,
    robot_title,
)
from pipeline.reporting.published import Published
from pipeline.reporting.results import Results
from pipeline.reporting.table import Cell, Column, Table

SPLITS = ("train", "validation", "test")
RATE_UNIT = 1e4  # Table I gives the learning rate in units of 1e-4


def hyperparameters(results: Results, published: Published) -> Table:
    """Table I: what the paper's search found beside what was trained and found here."""
    table = Table(
        name="table1_hyperparameters",
        title="Table I: hyperparameters",
        caption="The paper's best of 200 trials a robot, the networks trained in this run, and the "
        "best trial of this run's search where there was one. Learning rate in units of 1e-4.",
        columns=[
            Column("robot", "Robot"),
            Column("source", "Source"),
            *hyperparameter_columns(),
        ],
    )
    for robot in ordered_robots([*results.robots, *published.robots("hyperparameters")]):
        if robot in published.robots("hyperparameters"):
            table.add(robot=robot_title(robot), source="paper", **published_row(published, robot))
        for (name, model), (card, _) in results.train.items():
            if name == robot:
                table.add(
                    robot=robot_title(robot), source=f"this run: {model}", **_trained_row(card)
                )
        if robot in results.tune:
            trials, best = results.tune[robot]
            label = f"this run: best of {len(trials)} trials"
            table.add(robot=robot_title(robot), source=label, **drawn_row(best))
    return table


def datasets(results: Results) -> Table:
    """Sizes, acceptance and seeds of the pose sets."""
    table = Table(
        name="datasets",
        title="Pose sets",
        caption="Uniform joint samples without self-collision; the paper: 1,000,000 / 100,000 / "
        "200,000 poses a robot. Acceptance is the share of samples that were kept.",
        columns=[
            Column("robot", "Robot"),
            Column("split", "Set"),
            Column("poses", "poses"),
            Column("acceptance", "acceptance [%]", percent=1),
            Column("in_collision", "in collision"),
            Column("outside_workspace", "outside the box"),
            Column("seed", "seed"),
        ],
    )
    for robot in ordered_robots(results.dataset):
        splits = results.dataset[robot].get("splits") or {}
        for split in [*(s for s in SPLITS if s in splits), *(s for s in splits if s not in SPLITS)]:
            facts = splits[split]
            named = {k: facts.get(k) for k in ("poses", "acceptance", "in_collision")}
            named |= {"outside_workspace": facts.get("outside_workspace")}
            seed = facts.get("seed")
            table.add(
                robot=robot_title(robot),
                split=split,
                seed=None if seed is None else str(seed),
                **named,
            )
    return table


def training(results: Results) -> Table:
    """What was trained, for how long, and how well it did on the validation set."""
    group = "validation set, Euclidean and geodesic"
    table = Table(
        name="training",
        title="Training",
        caption="Networks of this run and their mean errors on the validation set at the end.",
        columns=[
            Column("robot", "Robot"),
            Column("model", "Model"),
            Column("parameters", "parameters"),
            Column("steps", "steps"),
            Column("samples", "poses seen"),
            Column("loss", "loss"),
            Column("position_error_mm", "position [mm]", group, 3),
            Column("rotation_error_deg", "rotation [deg]", group, 3),
            Column("success_10mm_20deg", "within 10 mm, 20 deg [%]", group, percent=1),
            Column("skipped_steps", "steps skipped"),
            Column("device", "device"),
        ],
    )
    for robot in ordered_robots(robot for robot, _ in results.train):
        for (name, model), (card, curve) in results.train.items():
            if name != robot:
                continue
            metrics = card.get("validation") or {}
            table.add(
                robot=robot_title(robot),
                model=model,
                parameters=card.get("parameters"),
                steps=_last(curve, "step"),
                samples=_last(curve, "samples"),
                loss=_loss(card),
                position_error_mm=metrics.get("position_error_mm"),
                rotation_error_deg=metrics.get("rotation_error_deg"),
                success_10mm_20deg=metrics.get("success_10mm_20deg"),
                skipped_steps=metrics.get("skipped_steps"),
                device=card.get("device"),
            )
    return table


def hyperparameter_columns() -> list[Column]:
    """Return the columns of Table I, after those that name a row."""
    return [
        Column("batch_size", "Batch size"),
        Column("learning_rate", "Lr", digits=3),
        Column("hidden_layers", "No. layers"),
        Column("tanh_layers", "No. tanh"),
        Column("position_weight", "w pos", digits=3),
        Column("rotation_weight", "w rot", digits=3),
        Column("neurons_per_layer", "Neurons per layer"),
        Column("parameters", "Parameters [1e6]", digits=5),
    ]


def published_row(published: Published, robot: str) -> dict[str, Cell]:
    """Return the row of Table I of a robot."""

    def number(metric: str) -> float | None:
        return published.number("hyperparameters", robot, "cycleik", metric)

    rate, parameters = number("learning_rate"), number("parameters")
    integers = ("batch_size", "hidden_layers", "tanh_layers")
    return {
        **{name: _whole(number(name)) for name in integers},
        "learning_rate": None if rate is None else rate * RATE_UNIT,
        "position_weight": number("position_weight"),
        "rotation_weight": number("rotation_weight"),
        "neurons_per_layer": published.text(
            "hyperparameters", robot, "cycleik", "neurons_per_layer"
        ),
        "parameters": None if parameters is None else parameters / 1e6,
    }


def _trained_row(card: dict[str, Any]) -> dict[str, Cell]:
    parameters = card.get("parameters")
    row = drawn_row(card.get("config") or {})
    return {**row, "parameters": None if parameters is None else parameters / 1e6}


def drawn_row(config: dict[str, Any]) -> dict[str, Cell]:
    """Return a row of Table I for the groups train and model of a configuration."""
    train, model = config.get("train") or {}, config.get("model") or {}
    hidden = model.get("hidden") or []
    rate = train.get("learning_rate")
    return {
        "batch_size": _whole(train.get("batch_size")),
        "learning_rate": None if rate is None else float(rate) * RATE_UNIT,
        "hidden_layers": len(hidden) or None,
        "tanh_layers": _whole(model.get("tanh_layers")),
        "position_weight": train.get("position_weight"),
        "rotation_weight": train.get("rotation_weight"),
        "neurons_per_layer": " ".join(str(n) for n in hidden) or None,
    }


def _whole(value: float | None) -> int | None:
    return None if value is None else int(value)


def _last(curve: pd.DataFrame, column: str) -> int | None:
    return int(curve[column].iloc[-1]) if column in curve and len(curve) else None


def _at(content: dict[str, Any], *keys: str) -> Any:
    for key in keys:
        content = (content or {}).get(key)  # type: ignore[assignment]
    return content


def _loss(card: dict[str, Any]) -> Cell:
    """Name of the loss: flows are trained for likelihood, whatever `train.loss` says."""
    if _at(card, "config", "model", "kind") == "flow":
        return "likelihood"
    loss: Cell = _at(card, "config", "train", "loss")
    return loss
