"""The same solvers by several protocols: a ranking each, how they agree, and what turned them."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping
from itertools import combinations
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from pipeline.presentation.columns import (
    NOTHING,
    ROBOT,
    SOLVER,
    count,
    number,
    share,
    text,
    under,
)
from pipeline.presentation.naming import ordered_robots, ordered_solvers, solver_title
from pipeline.presentation.table import Table
from pipeline.protocols.comparison import ELEMENTS, MADE_WITH, Ranking, Turn, kendall_tau, turns
from pipeline.protocols.config import NO_SUCCESS, ProtocolConfig, from_facts
from pipeline.protocols.scoring import rounded
from pipeline.reporting.bump_chart import Place, Stop, bump_chart
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.results import ProtocolKey

Rows = Mapping[ProtocolKey, tuple[pd.DataFrame, Mapping[str, Any]]]
Group = tuple[str, str]  # robot and machine: nothing is ranked across either

ORDER = ("cycleik", "trac_ik", "ikflow", "curobo", "hjcd_ik", "frankik")  # others behind
KINDS = {
    "axes_mean": "mean of the axes",
    "euclidean": "Euclidean, geodesic",
    "each_axis": "largest axis",
}
STATISTICS = {
    "mean": "mean",
    "median": "median",
    "p98": "98th percentile",
    "shifted_mean": "shifted geometric mean",
}
METRICS = {
    "success": ("success", "%", 100.0),
    "position": ("position error", "mm", 1.0),
    "rotation": ("rotation error", "deg", 1.0),
    "time": ("time of a call", "ms", 1.0),
}

PROTOCOL = text("protocol", "Protocol")
MACHINE = text("machine", "machine")
RANKINGS = (
    ROBOT,
    PROTOCOL,
    count("batch_size", "a call"),
    SOLVER,
    text("rank", "rank"),
    text("by", "ranked by"),
    count("targets", "targets"),
    share("success", "success [%]", decimals=2),
    *under(
        "error",
        text("errors", "statistic"),
        number("position_error_mm", "position [mm]"),
        number("rotation_error_deg", "rotation [deg]"),
    ),
    number("time_ms", "time of a call [ms]"),
    MACHINE,
)
AGREEMENT = (
    ROBOT,
    text("one", "one protocol"),
    text("other", "the other"),
    count("solvers", "solvers"),
    number("tau", "Kendall's tau", decimals=2),
    count("reversed", "pairs reversed"),
    count("pairs", "of"),
    text("causes", "what turned them"),
    MACHINE,
)
TURNED = (
    ROBOT,
    text("first", "first", convert=solver_title),
    text("second", "second", convert=solver_title),
    text("ahead", "first is ahead in"),
    text("behind", "second is ahead in"),
    text("tied", "tied in"),
    text("causes", "what turned it"),
    MACHINE,
)


def rankings(rows: Rows) -> Table:
    """Solver by protocol and batch size: the rank, what it is by, and all that is reported."""
    found = []
    for (robot, machine), batches in _grouped(rows).items():
        for (_, size), ranking in batches.items():
            protocol, places = ranking.protocol, ranking.ranks
            for solver in sorted(places, key=places.__getitem__):
                score = ranking.scores[solver]
                found.append(
                    {
                        "robot": robot,
                        "machine": machine,
                        "protocol": protocol.title,
                        "batch_size": size,
                        "solver": solver,
                        "rank": _rank(places, solver),
                        "by": METRICS[protocol.rank.by][0],
                        "targets": score.targets,
                        "success": score.success,
                        "errors": _errors_title(protocol),
                        "position_error_mm": score.position,
                        "rotation_error_deg": score.rotation,
                        "time_ms": score.time,
                    }
                )
    return Table.of(
        found,
        RANKINGS,
        name="protocols",
        title="The same solvers by everyone's protocol",
        caption="Each protocol with its own targets, start, budget, success and statistic "
        "(conf/protocol); = marks a tie in the digits that the protocol ranks by. Solvers are "
        "ranked within a machine only; errors are recomputed from the joints. Ranks have no "
        "interval: who is close may change places in another run, most of all by time and "
        "under a budget of time.",
    )


def agreement(rows: Rows) -> Table:
    """Kendall's tau of each pair of protocols, and what reversed pairs of solvers."""
    found = []
    for (robot, machine), ranked in _ranked(rows).items():
        turned = list(turns(ranked))
        for one, other in combinations(ranked.values(), 2):
            titles = {one.protocol.title, other.protocol.title}
            mine = [turn for turn in turned if {turn.ahead_in, turn.behind_in} == titles]
            solvers = len(set(one.ranks) & set(other.ranks))
            found.append(
                {
                    "robot": robot,
                    "machine": machine,
                    "one": one.protocol.title,
                    "other": other.protocol.title,
                    "solvers": solvers,
                    "tau": kendall_tau(one.ranks, other.ranks),
                    "reversed": len(mine),
                    "pairs": solvers * (solvers - 1) // 2,
                    "causes": _causes(mine),
                }
            )
    return Table.of(
        found,
        AGREEMENT,
        name="protocol_agreement",
        title="How the protocols' rankings agree",
        caption="Kendall's tau-b: 1 the same order, −1 the reverse, 0 no relation. " + _how(),
    )


def turned_pairs(rows: Rows) -> Table:
    """Pairs of solvers whose order differs between protocols, and what turned it."""
    found = []
    for (robot, machine), ranked in _ranked(rows).items():
        by_pair: dict[tuple[str, str], list[Turn]] = {}
        for turn in turns(ranked):
            by_pair.setdefault((turn.first, turn.second), []).append(turn)
        for (first, second), mine in by_pair.items():
            places: dict[int, list[str]] = {-1: [], 0: [], 1: []}
            for ranking in ranked.values():
                if {first, second} <= set(ranking.rows):
                    places[ranking.order(first, second)].append(ranking.protocol.title)
            found.append(
                {
                    "robot": robot,
                    "machine": machine,
                    "first": first,
                    "second": second,
                    "ahead": ", ".join(places[-1]),
                    "behind": ", ".join(places[1]),
                    "tied": ", ".join(places[0]) or None,
                    "causes": _causes(mine),
                }
            )
    return Table.of(
        found,
        TURNED,
        name="protocol_turns",
        title="Pairs of solvers whose order depends on the protocol",
        caption=_how(),
    )


def bumps(rows: Rows) -> Figure:
    """Rank by protocol, one line a solver, a panel a robot and machine."""
    panels = {}
    for (robot, machine), ranked in _ranked(rows).items():
        stops = [
            Stop(
                ranking.protocol.title,
                _by_title(ranking.protocol),
                [
                    Place(solver, rank, _value(ranking, solver))
                    for solver, rank in ranking.ranks.items()
                ],
            )
            for ranking in ranked.values()
        ]
        panels[robot, machine] = stops
    return bump_chart(panels)


def comparable(rows: Rows) -> Rows:
    """Return the rows that answer the same questions by the same rules as most of their protocol.

    A protocol that was changed may have been run again with some of its solvers only.
    """
    asked: dict[tuple[str, str, int], Counter[str]] = {}
    questions = {}
    for key, (_, facts) in rows.items():
        robot, name, _, size = key
        text = json.dumps([facts["protocol"], facts["poses_checksum"]], sort_keys=True)
        questions[key] = (robot, name, size), text
        asked.setdefault((robot, name, size), Counter())[text] += 1
    return {
        key: rows[key]
        for key, (place, text) in questions.items()
        if text == asked[place].most_common(1)[0][0]
    }


def _grouped(rows: Rows) -> dict[Group, dict[tuple[str, int], Ranking]]:
    """Rankings by robot and machine, then by protocol and batch size, in the order of tables."""
    parts: dict[Group, dict[tuple[str, int], dict[str, pd.DataFrame]]] = {}
    protocols: dict[tuple[Group, str, int], ProtocolConfig] = {}
    for (robot, name, solver, size), (frame, facts) in comparable(rows).items():
        group = (robot, str(frame.machine.iloc[0]))
        parts.setdefault(group, {}).setdefault((name, size), {})[solver] = frame
        protocols[group, name, size] = from_facts(facts["protocol"])
    robots = ordered_robots({robot for robot, _ in parts})
    made: dict[Group, dict[tuple[str, int], Ranking]] = {}
    for group in sorted(parts, key=lambda each: (robots.index(each[0]), each[1])):
        made[group] = {}
        for name, size in sorted(parts[group], key=lambda each: (_place(each[0]), *each)):
            frames = parts[group][name, size]
            solvers = ordered_solvers(frames)
            made[group][name, size] = Ranking(
                protocols[group, name, size], {solver: frames[solver] for solver in solvers}
            )
    return made


def _ranked(rows: Rows) -> dict[Group, dict[str, Ranking]]:
    """The rankings of the batch sizes that rank, by robot and machine, then by protocol."""
    return {
        group: {
            name: ranking
            for (name, size), ranking in batches.items()
            if size == ranking.protocol.ranking_batch()
        }
        for group, batches in _grouped(rows).items()
    }


def _place(protocol: str) -> int:
    return ORDER.index(protocol) if protocol in ORDER else len(ORDER)


def _rank(places: Mapping[str, int], solver: str) -> str:
    tied = list(places.values()).count(places[solver]) > 1
    return f"{places[solver]}=" if tied else str(places[solver])


def _errors_title(protocol: ProtocolConfig) -> str:
    of = " of the successes" if protocol.errors.of == "successes" else ""
    return f"{STATISTICS[protocol.errors.statistic]}{of}, {KINDS[protocol.errors.kind]}"


def _by_title(protocol: ProtocolConfig) -> str:
    """What a protocol ranks by, in a few short lines."""
    by, rule = protocol.rank.by, protocol.success
    if by == "success" and rule.errors != NO_SUCCESS:
        return (
            f"success\n{rule.position_mm:.3g} mm, {rule.rotation_deg:.2g} deg\n"
            + (KINDS[rule.errors])
        )
    if by == "time":
        answers = protocol.ranking_batch()
        one_pose = protocol.best_draw or answers == 1
        calls = "one pose a call" if one_pose else f"{answers} poses a call"
        more = f"\nbest of {protocol.draws}" if protocol.best_draw else ""
        return f"{STATISTICS[protocol.time_statistic]} time\n{calls}{more}"
    more = f"\n{protocol.draws} draws a pose" if protocol.draws > 1 else ""
    return f"{STATISTICS[protocol.errors.statistic]} {METRICS[by][0]}\n" + (
        f"{KINDS[protocol.errors.kind]}{more}"
    )


def _value(ranking: Ranking, solver: str) -> str:
    """What a solver is ranked by, in the digits in which it may be tied."""
    rule = ranking.protocol.rank
    _, unit, scale = METRICS[rule.by]
    value = rounded(getattr(ranking.scores[solver], rule.by) * scale, rule.digits)
    if not math.isfinite(value):
        return NOTHING
    magnitude = math.floor(math.log10(value)) if value > 0 else rule.digits - 1
    return f"{value:,.{max(rule.digits - 1 - magnitude, 0)}f} {unit}"


def _causes(mine: list[Turn]) -> str | None:
    """Causes with the number of reversals that each explains, the most frequent first."""
    counts = Counter(cause for turn in mine for cause in turn.causes)
    return "; ".join(f"{cause} {number}×" for cause, number in counts.most_common()) or None


def _how() -> str:
    return (
        f"What turned a pair: each of {', '.join(ELEMENTS)} that reverses its order when it alone "
        "is exchanged between the two protocols, on the rows of either; where not even all of them "
        "together do, it is among what the rows were made with differently "
        f"({', '.join(MADE_WITH)}). The number counts pairs of solvers and protocols."
    )


TOPIC = Topic(
    stages=("evaluate_protocol",),
    tables=(
        lambda data: rankings(data.results.protocols),
        lambda data: agreement(data.results.protocols),
        lambda data: turned_pairs(data.results.protocols),
    ),
    plots=(
        Plot(
            "protocols",
            "The same solvers by everyone's protocol: rank by what each protocol reports first, "
            "with its value. Solvers in one frame are tied: they share the digits that are shown.",
            lambda data: data.results.protocols,
            lambda data: bumps(data.results.protocols),
        ),
    ),
)
