"""Types of `conf/protocol`: what is solved, from where and for how long, and what is made of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive, positive_all

TARGETS = ("workspace", "free", "uniform", "halton", "near_home")
STARTS = ("home", "middle", "random", "none")
ERROR_KINDS = ("axes_mean", "euclidean", "each_axis")
NO_SUCCESS = "none"  # nothing counts as success or failure
STATISTICS = ("mean", "median", "p98", "shifted_mean")
COUNTED = ("all", "successes")
NOT_FOUND = ("idle", "own")
HIGHER_IS_BETTER = {"success": True, "position": False, "rotation": False, "time": False}


@dataclass
class SuccessRule:
    """What counts as solved; both bounds are exclusive."""

    errors: str = MISSING
    position_mm: float | None = MISSING
    rotation_deg: float | None = MISSING
    limits: bool = MISSING

    def __post_init__(self) -> None:
        """Refuse kinds of errors that nobody has, and a kind without its bounds."""
        one_of("protocol.success.errors", self.errors, (*ERROR_KINDS, NO_SUCCESS))
        for key in ("position_mm", "rotation_deg"):
            value = getattr(self, key)
            if value is not None:
                positive(f"protocol.success.{key}", value)
            elif self.errors != NO_SUCCESS:
                raise ValueError(
                    f"protocol.success.{key} must be a number where errors is {self.errors}"
                )


@dataclass
class ErrorRule:
    """Which errors, of which poses, and by which statistic."""

    kind: str = MISSING
    statistic: str = MISSING
    of: str = MISSING
    not_found: str = MISSING

    def __post_init__(self) -> None:
        """Refuse names of nothing."""
        one_of("protocol.errors.kind", self.kind, ERROR_KINDS)
        one_of("protocol.errors.statistic", self.statistic, STATISTICS)
        one_of("protocol.errors.of", self.of, COUNTED)
        one_of("protocol.errors.not_found", self.not_found, NOT_FOUND)


@dataclass
class RankRule:
    """By what solvers are ranked, and from where on two of them are tied."""

    by: str = MISSING
    digits: int = MISSING

    def __post_init__(self) -> None:
        """Refuse a metric that nobody has, and digits that tell nothing."""
        one_of("protocol.rank.by", self.by, HIGHER_IS_BETTER)
        positive("protocol.rank.digits", self.digits)


@dataclass
class ProtocolConfig:
    """How one group measures."""

    name: str = MISSING
    title: str = MISSING
    source: str = MISSING
    solvers: list[str] = MISSING
    targets: str = MISSING
    within_deg: list[float] = MISSING
    poses: int = MISSING
    most_poses: int = MISSING
    start: str = MISSING
    time_s: float | None = MISSING
    iterations: int | None = MISSING
    tolerance: float | None = MISSING
    draws: int = MISSING
    best_draw: bool = MISSING
    batch_sizes: list[int] = MISSING
    ranked_batch: int = MISSING
    one_call: bool = MISSING
    warm_up_calls: int = MISSING
    success: SuccessRule = field(default_factory=SuccessRule)
    errors: ErrorRule = field(default_factory=ErrorRule)
    time_statistic: str = MISSING
    rank: RankRule = field(default_factory=RankRule)

    def __post_init__(self) -> None:
        """Refuse runs of nothing, and a ranking that no rows are left for."""
        one_of("protocol.targets", self.targets, TARGETS)
        one_of("protocol.start", self.start, STARTS)
        one_of("protocol.time_statistic", self.time_statistic, STATISTICS)
        for key in ("poses", "most_poses", "draws", "ranked_batch"):
            positive(f"protocol.{key}", getattr(self, key))
        for key in ("time_s", "iterations", "tolerance"):
            if getattr(self, key) is not None:
                positive(f"protocol.{key}", getattr(self, key))
        positive_all("protocol.batch_sizes", self.batch_sizes)
        at_least("protocol.warm_up_calls", self.warm_up_calls, 0)
        if not isinstance(self.solvers, str) and not self.solvers:
            raise ValueError("protocol.solvers must name at least one solver")
        if self.targets == "near_home":
            positive_all("protocol.within_deg", self.within_deg)
        if self.rank.by == "success" and self.success.errors == NO_SUCCESS:
            raise ValueError(
                "protocol.rank.by=success needs protocol.success.errors: "
                f"one of {', '.join(ERROR_KINDS)}"
            )

    def solvers_by_key(self) -> dict[str, list[str]]:
        """Return the names of the solvers that a run loads, by the key that names them."""
        return {"protocol.solvers": list(self.solvers)}

    @property
    def targets_at_most(self) -> int:
        """Targets of a run: as many as the source has, or as the profile takes."""
        return min(self.poses, self.most_poses)

    def calls(self) -> dict[int, int]:
        """Return the answers of each batch size: those of all targets, or of one call.

        Batch sizes of one call that are more than there are targets are left out, but the smallest.
        """
        total = self.targets_at_most * self.draws
        if not self.one_call:
            return dict.fromkeys(self.batch_sizes, total)
        fitting = [size for size in self.batch_sizes if size <= total]
        return {size: min(size, total) for size in fitting or [min(self.batch_sizes)]}

    def ranking_batch(self) -> int:
        """Return the batch size that ranks: the one named, or the largest below it that there is.

        The smallest where all are larger.
        """
        sizes = self.calls()
        return max((size for size in sizes if size <= self.ranked_batch), default=min(sizes))


def from_facts(facts: Mapping[str, Any]) -> ProtocolConfig:
    """Return the protocol that stands in the metadata of rows."""
    rules = {"success": SuccessRule, "errors": ErrorRule, "rank": RankRule}
    made = {name: rule(**facts[name]) for name, rule in rules.items()}
    return ProtocolConfig(**{**facts, **made})
