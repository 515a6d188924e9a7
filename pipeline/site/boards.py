"""The page of the leaderboard: committed lines, who is where, and figures of each board."""

from __future__ import annotations

from typing import Any

import pandas as pd
from markupsafe import Markup

from pipeline.leaderboard.leads import leads
from pipeline.leaderboard.schema import HERE
from pipeline.leaderboard.standings import overall, ranked
from pipeline.presentation.columns import (
    ROBOT,
    SOLVER,
    count,
    number,
    plain,
    share,
    text,
    under,
)
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig, tolerance_title
from pipeline.reporting.suite_leaders import FIRST_TWO
from pipeline.site.figures import board_charts
from pipeline.site.parts import Item, Page, Prose, Section, Sheet

COMMAND = "python -m pipeline leaderboard add FILE.parquet"
MACHINE = text("machine", "Machine", convert=plain)
OVERALL = (
    MACHINE,
    SOLVER,
    count("boards", "boards"),
    count("first", "ranked first"),
    number("mean_rank", "mean rank", decimals=2),
    *under("solved [%]", share("mean_share", "mean"), share("least_share", "least")),
    number("time_us", "time [µs]"),
)
LINES = (
    ROBOT,
    text("suite", "Suite", convert=plain),
    count("rank", "rank"),
    SOLVER,
    *under("solved [%]", share("share", "share"), share("low", "from"), share("high", "to")),
    *under(
        "time of a call [µs]",
        number("time_geometric_us", "geometric mean"),
        number("time_median_us", "median"),
        number("time_p99_us", "99th percentile"),
    ),
    *under(
        "error",
        number("position_median_mm", "median [mm]"),
        number("position_p99_mm", "p99 [mm]"),
        number("rotation_median_deg", "median [deg]"),
    ),
    share("self_collision_share", "self-collision [%]"),
    count("claimed_and_wrong", "claimed, wrong"),
    text("front", "Pareto front", lambda line: "yes" if line["front"] else "no"),
    MACHINE,
    text("criterion", "counted"),
    count("trials", "of"),
    count("batch_size", "poses a call"),
    count("threads", "threads"),
    text("timed_by", "timed"),
    text("date", "date"),
)
LEADS = (
    MACHINE,
    text("suite", "Suite", convert=plain),
    ROBOT,
    text("apart", "apart"),
    text("within_us", "within [µs]"),
    *FIRST_TWO,
)
LEFT = (  # of a line, in a table of its own
    MACHINE,
    ROBOT,
    text("suite", "Suite", convert=plain),
    SOLVER,
    text("robot_source", "robot from", lambda line: line["robot_source"] or None),
    text("suite_version", "version"),
    text("profile", "profile"),
    text("suite_checksum", "checksum of the suite", lambda line: line["suite_checksum"][:12]),
    text("processor", "processor"),
    text("versions", "versions"),
    text("network", "network", lambda line: line["network"] or None),
    text("commit", "commit"),
    text("answers_sha256", "answers", lambda line: line["answers_sha256"][:12]),
)
EMPTY = Markup(
    "<p>No line is committed yet. <code>python benchmarks/leaderboard.py</code> makes those of "
    "this machine; <code>python -m pipeline leaderboard add</code> takes a file of yours.</p>"
)
HOW = Markup(
    "<p>Answers are judged again from their joints when a line is made; no error is believed. "
    "Ranks hold within a machine, a robot and a suite. A rank is one more than the solvers that "
    "are certainly better, whose interval lies above; equal ranks stand in the order of their "
    "share, then of their time. Of poses that cannot be reached, solved is a true no; of "
    "trajectories, that they are followed without a jump.</p>"
    "<p>To add a row of yours: a file and a pull request, see <code>docs/leaderboard.md</code>.</p>"
)


def leaderboard_page(lines: pd.DataFrame, config: ReportConfig) -> Page:
    """Make the page.

    Args:
        lines: Of `pipeline.leaderboard.boards.read_boards`.
        config: Confidence of intervals, what solved means, the shift of times.
    """
    lead = "Solvers on suites of hard poses, a board for each suite, robot and machine."
    if lines.empty:
        return Page("leaderboard", "Leaderboard", lead, [Section("empty", "", [Prose(EMPTY)])])
    placed = ranked(lines, config.confidence)
    charts: dict[str, list[Item]] = {"profile": [], "pareto": []}
    for chart in board_charts(placed):
        charts[chart.group].append(chart)
    sections = [
        Section("how", "", [Prose(HOW)]),
        Section("overall", "Overall", [Sheet(overall_table(placed, config))]),
        Section("boards", "Boards", [Sheet(lines_table(placed, config))]),
        Section("leads", "Who is ahead", [Sheet(leads_table(placed, config))]),
        Section("within", "Success within a time", charts["profile"]),
        Section("error-time", "Error and time", charts["pareto"]),
        Section("made", "What made each line", [Sheet(made_table(placed), folded=True)]),
    ]
    kept = [section for section in sections if section.items]
    return Page("leaderboard", "Leaderboard", lead, kept)


def overall_table(lines: pd.DataFrame, config: ReportConfig) -> Table:
    """The table of solvers over all boards of a machine."""
    table = Table.of(
        overall(lines),
        OVERALL,
        name="leaderboard_overall",
        title="Over all boards of a machine",
        caption="Mean rank, and mean and least share solved, over the boards that a solver is on; "
        "time: geometric mean over these boards of the shifted geometric mean of a call "
        f"(shift {config.leaderboard.shift_us:g} µs). Who is on fewer boards stands behind.",
    )
    table.origin = lines_origin(lines)
    return table


def lines_table(lines: pd.DataFrame, config: ReportConfig) -> Table:
    """The table of all lines, ranked within their board."""
    table = Table.of(
        lines,
        LINES,
        name="leaderboard_lines",
        title="Every line",
        caption=f"Solved: {tolerance_title(config.success.strict)}, joint limits kept, with "
        f"{config.confidence * 100:g} % Wilson intervals. Geometric mean of times shifted by "
        f"{config.leaderboard.shift_us:g} µs, misses as long as they took. Self-collision: of the "
        f"solved. Timed `{HERE}`: by this pipeline; else by who sent the answers.",
    )
    table.origin = lines_origin(lines)
    return table


def leads_table(lines: pd.DataFrame, config: ReportConfig) -> Table:
    """The table of the first two of each board, within the time that tells them apart best."""
    table = Table.of(
        leads(lines, config.confidence),
        LEADS,
        name="leaderboard_leads",
        title="The first two of each board",
        caption="Rates are of poses solved by calls of at most so long (any: the rate of the "
        "board), at the limit of time that tells the first two apart best; of waypoints, counted "
        "as so many trials as there are trajectories. Apart: their Wilson intervals "
        f"do not overlap, at {config.confidence * 100:g} % for all limits of a board together.",
    )
    table.origin = lines_origin(lines)
    return table


def made_table(lines: pd.DataFrame) -> Table:
    """The table of what made each line."""
    table = Table.of(
        lines,
        LEFT,
        name="leaderboard_made",
        title="Versions, processor, commit and checksums",
        caption="Full checksums stand in `results/leaderboard`.",
    )
    table.origin = lines_origin(lines)
    return table


def lines_origin(lines: pd.DataFrame) -> Origin:
    """What made lines; several values stand behind commas."""
    joined = {name: ", ".join(dict.fromkeys(lines[name].map(str))) for name in _SHARED}
    renamed: dict[str, Any] = {"seeds": joined.pop("seed"), "networks": joined.pop("network")}
    return Origin(COMMAND, **joined, **{key: text.strip(", ") for key, text in renamed.items()})


_SHARED = ("commit", "date", "processor", "profile", "seed", "network")
