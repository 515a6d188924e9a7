"""Table I of the paper: hyperparameters of a network and of its training, one row each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pipeline.presentation.columns import Column, count, number, text
from pipeline.presentation.naming import robot_title
from pipeline.presentation.published import Published
from pipeline.presentation.table import Table

TABLE = "hyperparameters"  # of the published numbers
RATE_UNIT = 1e4  # Table I gives the learning rate in units of 1e-4


@dataclass(frozen=True)
class Hyperparameters:
    """A row of Table I.

    Attributes:
        robot: Name of the robot.
        source: What found or trained it.
        train: Group `train` of its configuration, or the keys of it that are known.
        model: Group `model` likewise.
        parameters: Number of parameters, where known.
        objective: Of the trial that found it, where there is one.
    """

    robot: str
    source: str
    train: Mapping[str, Any]
    model: Mapping[str, Any]
    parameters: float | None = None
    objective: float | None = None

    @classmethod
    def of(
        cls, robot: str, source: str, config: Mapping[str, Any], **facts: Any
    ) -> Hyperparameters:
        """Take the groups `train` and `model` of a configuration or of the best of a study."""
        return cls(robot, source, config.get("train") or {}, config.get("model") or {}, **facts)

    @property
    def hidden(self) -> list[int]:
        """Neurons of each hidden layer, none where unknown."""
        return list(self.model.get("hidden") or [])


def published_hyperparameters(published: Published, robot: str) -> list[Hyperparameters]:
    """Return the row of Table I of a robot, none where the paper has none."""
    if robot not in published.robots(TABLE):
        return []
    keys = ("batch_size", "learning_rate", "position_weight", "rotation_weight", "tanh_layers")
    found = {key: published.number(TABLE, robot, "cycleik", key) for key in keys}
    neurons = published.text(TABLE, robot, "cycleik", "neurons_per_layer") or ""
    model = {"hidden": neurons.split(), "tanh_layers": found.pop("tanh_layers")}
    parameters = published.number(TABLE, robot, "cycleik", "parameters")
    return [Hyperparameters(robot, "paper", found, model, parameters)]


def _trained(key: str) -> Any:
    return lambda row: row.train.get(key)


def _learning_rate(row: Hyperparameters) -> float | None:
    rate = row.train.get("learning_rate")
    return None if rate is None else float(rate) * RATE_UNIT


def _millions(row: Hyperparameters) -> float | None:
    return None if row.parameters is None else row.parameters / 1e6


SOURCE = text("source", "Source")
COLUMNS = (
    count("batch_size", "Batch size", _trained("batch_size")),
    number("learning_rate", "Lr", _learning_rate),
    count("hidden_layers", "No. layers", lambda row: len(row.hidden) or None),
    count("tanh_layers", "No. tanh", lambda row: row.model.get("tanh_layers")),
    Column("position_weight", "w pos", source=_trained("position_weight"), digits=3),
    Column("rotation_weight", "w rot", source=_trained("rotation_weight"), digits=3),
    text(
        "neurons_per_layer", "Neurons per layer", lambda row: " ".join(map(str, row.hidden)) or None
    ),
    number("parameters", "Parameters [1e6]", _millions, digits=5),
)


def found_hyperparameters(robot: str, published: Published, found: list[Hyperparameters]) -> Table:
    """One robot's Table I: what the paper found and what a study did.

    Args:
        robot: Name of the robot.
        published: The paper's numbers.
        found: Rows of the study.
    """
    return Table.of(
        [*published_hyperparameters(published, robot), *found],
        (SOURCE, *COLUMNS, number("objective", "Objective", digits=4)),
        name="table1",
        title=f"Hyperparameters of {robot_title(robot)} in the form of Table I",
        caption="The paper's best of 200 trials and this study's. Learning rate in units of 1e-4; "
        "the objective is this study's, after the short training of a trial.",
    )
