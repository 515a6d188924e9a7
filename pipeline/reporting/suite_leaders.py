"""Who leads in a suite of hard poses, and whether that is certain."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pipeline.evaluation.statistics import Interval
from pipeline.presentation.columns import ROBOT, count, number, plain, share, text, under
from pipeline.presentation.naming import solver_title
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.suite_measures import QUICK, Rows, each_solver, mean_time_us, rates

SUITE = text("suite", "Suite", convert=plain)
FIRST_TWO = (  # of `ahead`
    text("best", "best", convert=solver_title),
    *under("its rate [%]", share("best_share", "share"), share("best_low", "from")),
    text("second", "second", convert=solver_title),
    *under("its rate [%]", share("second_share", "share"), share("second_high", "to")),
)
LEADERS = (ROBOT, SUITE, text("rate", "rate"), *FIRST_TWO, text("apart", "apart"))


QUICKEST = (
    ROBOT,
    SUITE,
    text("rate", "level in"),
    count("level", "solvers"),
    text("best", "quickest", convert=solver_title),
    *under("its time [us]", number("best_us", "mean"), number("best_high", "to")),
    text("second", "second", convert=solver_title),
    *under("its time [us]", number("second_us", "mean"), number("second_low", "from")),
    text("apart", "apart"),
)


def leaders(rows: Rows, config: ReportConfig) -> Table:
    """The best and the second-best solver of each suite and robot, and whether they are apart."""
    found = []
    for (robot, suite, rate), group in _ranked(rows, config).items():
        if len(group) > 1:
            found.append({"robot": robot, "suite": suite, "rate": rate, **ahead(group)})
    return Table.of(
        found,
        LEADERS,
        name="suite_leaders",
        title="Who leads in each suite, and whether that is certain",
        caption=f"Rates are success, success {QUICK}, true no (unreachable; who always says no has "
        "all of these), trajectories followed (tracking), and poses reached free of collision "
        "(cluttered). "
        f"Apart: the {config.confidence * 100:g} % Wilson intervals do not overlap.",
    )


def ahead(shares: Sequence[tuple[str, Interval]]) -> dict[str, Any]:
    """Return the best of two solvers or more, the second, and whether the best is certainly ahead.

    The second is the one of the others whose interval ends highest. Where all had as many trials it
    is the one with the next share; a solver that had few may reach higher than that one.

    Args:
        shares: Solvers with what they reach; of equals the first one counts.
    """
    best, first = max(shares, key=lambda each: each[1].estimate)
    others = [each for each in shares if each[0] != best]
    second, other = max(others, key=lambda each: (each[1].high, each[1].estimate))
    return {
        "best": best,
        "best_share": first.estimate,
        "best_low": first.low,
        "second": second,
        "second_share": other.estimate,
        "second_high": other.high,
        "apart": "yes" if first.low > other.high else "no",
    }


def quickest(rows: Rows, config: ReportConfig) -> Table:
    """Of the solvers that no rate of a suite tells from the best one, who is quicker than all."""
    found = []
    for (robot, suite, rate), group in _ranked(rows, config).items():
        if rate == QUICK:
            continue
        level = [solver for solver, share in group if share.high >= group[0][1].low]
        means = {solver: mean_time_us(rows[robot, suite, solver], config) for solver in level}
        timed = sorted(
            ((solver, mean) for solver, mean in means.items() if mean is not None),
            key=lambda each: each[1].estimate,
        )
        if len(timed) < 2:
            continue
        (best, first), (second, other) = timed[:2]
        found.append(
            {
                "robot": robot,
                "suite": suite,
                "rate": rate,
                "level": len(level),
                "best": best,
                "best_us": first.estimate,
                "best_high": first.high,
                "second": second,
                "second_us": other.estimate,
                "second_low": other.low,
                "apart": "yes" if first.high < other.low else "no",
            }
        )
    return Table.of(
        found,
        QUICKEST,
        name="suite_quickest",
        title="Where solvers are level, who is quicker",
        caption="Solvers whose rate cannot be told from the best one's (their Wilson intervals "
        "overlap), by the geometric mean of the time of a call, shifted by "
        f"{config.leaderboard.shift_us:g} us, misses as long as they took. Apart: the "
        f"{config.confidence * 100:g} % intervals of a bootstrap over the poses do not overlap. "
        "Times of one machine.",
    )


def _ranked(
    rows: Rows, config: ReportConfig
) -> dict[tuple[str, str, str], list[tuple[str, Interval]]]:
    """Solvers of each robot, suite and rate with what they reach, the best first."""
    ranked: dict[tuple[str, str, str], list[tuple[str, Interval]]] = {}
    for names, part in each_solver(rows):
        for rate, interval in rates(part, config).items():
            key = (names["robot"], names["suite"], rate)
            ranked.setdefault(key, []).append((names["solver"], interval))
    return {key: sorted(group, key=lambda each: -each[1].estimate) for key, group in ranked.items()}
