"""How rankings by several protocols agree, and which element of a protocol turned a pair."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations

import numpy as np
import pandas as pd
from scipy import stats

from pipeline.protocols.config import NO_SUCCESS, ProtocolConfig
from pipeline.protocols.scoring import Score, ranks, score

Exchange = Callable[[ProtocolConfig, ProtocolConfig], ProtocolConfig]

# What can be exchanged on rows that are there: each takes a protocol and gives it one element of
# the other. What rows were made with (targets, start, budget, calls) cannot.
ELEMENTS: dict[str, Exchange] = {
    "metric": lambda own, other: _with_metric(own, other),
    "success threshold": lambda own, other: _with_success(own, other),
    "statistic of errors": lambda own, other: replace(
        own,
        errors=replace(own.errors, kind=other.errors.kind, statistic=other.errors.statistic),
    ),
    "who is counted": lambda own, other: replace(
        own,
        errors=replace(own.errors, of=other.errors.of, not_found=other.errors.not_found),
        best_draw=other.best_draw,
    ),
    "statistic of time": lambda own, other: replace(own, time_statistic=other.time_statistic),
}
TOGETHER = "several of these together"
# What rows were made with, by the keys of a protocol: a run each, which nobody makes here.
MADE_WITH = {
    "targets": ("targets", "within_deg"),
    "start": ("start",),
    "budget": ("time_s", "iterations"),
    "tolerance": ("tolerance",),
    "calls": ("draws", "ranked_batch", "one_call"),
}
SAMPLE = "other draws of the same"  # nothing differs but the seed


@dataclass
class Ranking:
    """Solvers on one protocol and one machine.

    Attributes:
        protocol: The protocol.
        rows: Raw rows of one batch size, by solver.
    """

    protocol: ProtocolConfig
    rows: Mapping[str, pd.DataFrame]
    _scored: dict[str, dict[str, Score]] = field(default_factory=dict, repr=False)

    @cached_property
    def scores(self) -> dict[str, Score]:
        """What the protocol reports, by solver."""
        return self.under(self.protocol)

    @cached_property
    def ranks(self) -> dict[str, int]:
        """Rank of each solver, 1 the best; equal ones are tied."""
        return ranks(self.scores, self.protocol)

    def under(self, protocol: ProtocolConfig) -> dict[str, Score]:
        """Return what another protocol would report of the same rows."""
        key = repr(protocol)
        if key not in self._scored:
            self._scored[key] = {name: score(rows, protocol) for name, rows in self.rows.items()}
        return self._scored[key]

    def order(self, first: str, second: str, protocol: ProtocolConfig | None = None) -> int:
        """Return -1 where the first is ahead of the second, 1 where it is behind, 0 if tied."""
        chosen = protocol or self.protocol
        scores = self.under(chosen)
        placed = ranks({name: scores[name] for name in (first, second)}, chosen)
        return int(np.sign(placed[first] - placed[second]))


@dataclass(frozen=True)
class Turn:
    """A pair of solvers whose order two protocols reverse.

    Attributes:
        first: Ahead in the one protocol.
        second: Ahead in the other.
        ahead_in: Title of the one.
        behind_in: Title of the other.
        causes: Elements that reverse the order when they alone are exchanged between the two; else
            that several do together, or what the rows of the two were made with differently.
    """

    first: str
    second: str
    ahead_in: str
    behind_in: str
    causes: tuple[str, ...]


def kendall_tau(one: Mapping[str, int], other: Mapping[str, int]) -> float:
    """Kendall's tau-b of two rankings, over the solvers of both (Kendall, 1945: ties count).

    Returns:
        From -1 to 1; NaN where fewer than two are common or one ranking ties all of them.
    """
    common = [name for name in one if name in other]
    if len(common) < 2:
        return float("nan")
    found = stats.kendalltau([one[name] for name in common], [other[name] for name in common])
    return float(found.statistic)


def turns(rankings: Mapping[str, Ranking]) -> Iterator[Turn]:
    """Yield each pair of solvers and of protocols that reverses them, with what did.

    Args:
        rankings: By protocol, of one robot and machine.
    """
    for one, other in combinations(rankings.values(), 2):
        common = [name for name in one.rows if name in other.rows]
        for first, second in combinations(common, 2):
            order = one.order(first, second)
            if order * other.order(first, second) != -1:
                continue
            ahead, behind = (one, other) if order == -1 else (other, one)
            yield Turn(
                first,
                second,
                ahead.protocol.title,
                behind.protocol.title,
                _causes(ahead, behind, first, second),
            )


def _with_metric(own: ProtocolConfig, other: ProtocolConfig) -> ProtocolConfig:
    """The metric of the other protocol, with what it calls success where one's own has no rule."""
    ruled = own.success.errors != NO_SUCCESS
    return replace(own, rank=other.rank, success=own.success if ruled else other.success)


def _with_success(own: ProtocolConfig, other: ProtocolConfig) -> ProtocolConfig:
    """What the other protocol calls success, if anything."""
    ruled = other.success.errors != NO_SUCCESS
    return replace(own, success=other.success) if ruled else own


def _causes(ahead: Ranking, behind: Ranking, first: str, second: str) -> tuple[str, ...]:
    """What reverses the order of two solvers: `Turn.causes`."""
    sides = ((ahead, behind, 1), (behind, ahead, -1))
    alone = [
        name
        for name, exchange in ELEMENTS.items()
        if any(
            own.order(first, second, exchange(own.protocol, other.protocol)) == reverse
            for own, other, reverse in sides
        )
    ]
    if alone:
        return tuple(alone)
    for own, other, reverse in sides:
        protocol = own.protocol
        for exchange in ELEMENTS.values():
            protocol = exchange(protocol, other.protocol)
        if own.order(first, second, protocol) == reverse:
            return (TOGETHER,)
    return (_made_differently(ahead.protocol, behind.protocol),)


def _made_differently(one: ProtocolConfig, other: ProtocolConfig) -> str:
    """Name what the rows of two protocols were made with differently."""
    names = [
        name
        for name, keys in MADE_WITH.items()
        if any(getattr(one, key) != getattr(other, key) for key in keys)
    ]
    return " or ".join(filter(None, (", ".join(names[:-1]), *names[-1:]))) or SAMPLE
