"""Types of `conf/tune`: what a search varies, how it draws, when it gives up, where it is kept."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import Field, dataclass, field, fields
from typing import Any

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, ordered, positive, within

FLOAT, INT, CHOICE, LAYERS = "float", "int", "choice", "layers"
KINDS = (FLOAT, INT, CHOICE, LAYERS)
# What kinds of axes may set a field of train or model, by the type of the field.
KINDS_OF = {
    "float": (FLOAT, INT, CHOICE),
    "float | None": (FLOAT, INT, CHOICE),
    "int": (INT, CHOICE),
    "bool": (CHOICE,),
    "str": (CHOICE,),
    "list[int]": (LAYERS, CHOICE),
}
# `tune` says how long and on what a trial trains; the rest names a run or what is kept of it.
FIXED = (
    *("epochs", "validations", "poses", "name", "kind"),
    *("replicate", "checkpoint_s", "device", "keep", "source"),
)
PRUNERS = ("none", "outclassed", "percentile", "median", "hyperband")
JOURNAL = "journal"
STORAGES = ("postgresql://", "postgresql+")


@dataclass
class Range:
    """Whole numbers from low to high, ``step`` apart: the neurons of a layer."""

    low: float = MISSING
    high: float = MISSING
    step: float = MISSING

    def __post_init__(self) -> None:
        """Refuse empty ranges and steps that go nowhere."""
        ordered("tune.space: neurons", self.low, self.high)
        positive("tune.space: step of neurons", self.step)


@dataclass
class Axis:
    """What one key of train or model may become.

    Attributes:
        kind: float, int, choice, or layers: a list as long as one draw says, each width another.
        low: Least value, or least number of layers.
        high: Greatest value, or greatest number of layers.
        step: Distance of values; none for a float is continuous, for an int is 1.
        log: Draw on a logarithmic scale.
        choices: The values of a choice.
        neurons: Widths of the layers of a list.
    """

    kind: str = MISSING
    low: float | None = None
    high: float | None = None
    step: float | None = None
    log: bool = False
    choices: list[Any] | None = None
    neurons: Range | None = None

    def __post_init__(self) -> None:
        """Refuse axes that lack what their kind needs, and empty ranges."""
        one_of("tune.space: kind", self.kind, KINDS)
        if self.kind == CHOICE:
            if not self.choices:
                raise ValueError("tune.space: an axis of kind: choice needs choices: [...]")
            return
        if self.low is None or self.high is None:
            raise ValueError(f"tune.space: an axis of kind: {self.kind} needs low and high")
        ordered("tune.space", self.low, self.high)
        if self.step is not None:
            positive("tune.space: step", self.step)
        if self.log:
            positive("tune.space: low of a range with log: true", self.low)
            if self.step is not None and not (self.kind == INT and self.step == 1):
                raise ValueError(
                    f"tune.space: a range with log: true takes no step, got {self.step}: leave it "
                    "out or set it to null"
                )
        if self.kind == LAYERS:
            positive("tune.space: low of layers", self.low)
            if self.neurons is None:
                raise ValueError("tune.space: an axis of kind: layers needs neurons: {low, high}")


@dataclass
class PrunerConfig:
    """When a trial that falls behind is cut short."""

    kind: str = MISSING
    keep: float = MISSING
    margin: float = MISSING
    startup: int = MISSING
    after: float = MISSING
    reports: int = MISSING

    def __post_init__(self) -> None:
        """Refuse unknown pruners and shares beyond 1."""
        one_of("tune.pruner.kind", self.kind, PRUNERS)
        within("tune.pruner.keep", self.keep, 0, 1)
        within("tune.pruner.after", self.after, 0, 1)
        at_least("tune.pruner.margin", self.margin, 1)
        at_least("tune.pruner.startup", self.startup, 0)
        positive("tune.pruner.reports", self.reports)


@dataclass
class StopConfig:
    """When a study is hopeless; 0 never stops for that reason."""

    failures: int = MISSING
    stall: int = MISSING

    def __post_init__(self) -> None:
        """Refuse negative counts."""
        at_least("tune.stop.failures", self.failures, 0)
        at_least("tune.stop.stall", self.stall, 0)


@dataclass
class ComparisonConfig:
    """The best of a search against Table I at one budget of training."""

    candidates: list[str] = MISSING
    currency: str = MISSING
    amount: float = MISSING
    replicates: int = MISSING

    def __post_init__(self) -> None:
        """Refuse budgets that buy nothing."""
        one_of("tune.comparison.currency", self.currency, ("seconds", "multiply_adds", "poses"))
        positive("tune.comparison.amount", self.amount)
        at_least("tune.comparison.replicates", self.replicates, 2)


@dataclass
class TuneConfig:
    """Search space, sampler, budget and storage of the hyperparameter search."""

    trials: int = MISSING
    epochs: int = MISSING
    poses: int = MISSING
    workers: int = MISSING
    storage: str = MISSING
    heartbeat_s: int = MISSING
    sampler: str = MISSING
    startup: int = MISSING
    objective: str = MISSING
    objective_position: float = MISSING
    objective_rotation: float = MISSING
    pruner: PrunerConfig = field(default_factory=PrunerConfig)
    stop: StopConfig = field(default_factory=StopConfig)
    comparison: ComparisonConfig = field(default_factory=ComparisonConfig)
    start: list[dict[str, Any]] = MISSING
    space: dict[str, Axis] = MISSING

    def __post_init__(self) -> None:
        """Refuse a search without trials, unknown samplers and storages."""
        for name in ("trials", "epochs", "heartbeat_s"):
            positive(f"tune.{name}", getattr(self, name))
        at_least("tune.workers", self.workers, 0)
        at_least("tune.poses", self.poses, 0)
        at_least("tune.startup", self.startup, 0)
        one_of("tune.sampler", self.sampler, ("tpe", "tpe_independent", "random"))
        one_of("tune.objective", self.objective, ("losses", "errors"))
        at_least("tune.objective_position", self.objective_position, 0)
        at_least("tune.objective_rotation", self.objective_rotation, 0)
        if self.storage not in ("???", JOURNAL) and not self.storage.startswith(STORAGES):
            raise ValueError(
                f"tune.storage must be {JOURNAL} (a file, for the processes of one disk) or a URL "
                f"postgresql://user@host/database, got '{self.storage}'"
            )


def check_space(space: dict[str, Axis], groups: Sequence[type]) -> None:
    """Refuse axes that no trial could set.

    Args:
        space: Axes by the key of train or model that they set.
        groups: The classes of these two groups.

    Raises:
        ValueError: There is no such key, or its values are not of this kind.
    """
    if not isinstance(space, dict):
        return  # still missing
    known = search_axes(groups)
    for name, axis in space.items():
        one_of("tune.space", name, known)
        kinds = KINDS_OF[known[name]]
        if axis.kind not in kinds:
            raise ValueError(
                f"tune.space.{name} sets a value of type {known[name]}: its kind must be one of "
                f"{', '.join(kinds)}, got {axis.kind}"
            )


def search_axes(groups: Sequence[type]) -> dict[str, str]:
    """Return what a search may vary, and the type of each: the plain values of train and model."""
    found: list[Field[Any]] = [item for group in groups for item in fields(group)]
    return {
        item.name: str(item.type)
        for item in sorted(found, key=lambda item: item.name)
        if item.name not in FIXED and item.type in KINDS_OF
    }
