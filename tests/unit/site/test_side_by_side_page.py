"""Two results folders side by side: what is called different, and what only one has."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd

from pipeline.presentation.published import Published
from pipeline.reporting.data import ReportData
from pipeline.reporting.results import Results
from pipeline.reporting.summary import summarise
from pipeline.site.comparison import comparison_table, verdict
from tests.unit.reporting.synthetic import raw_rows, report_config


def data(solvers: tuple[str, ...], factor: float = 1.0) -> ReportData:
    rows = pd.concat([raw_rows(solver=solver) for solver in solvers])
    rows = rows.assign(position_error_mm=rows.position_error_mm * factor)
    summary = summarise(rows, report_config())
    nothing = pd.DataFrame()
    published = Published(nothing)
    return ReportData(
        Results(Path("results")), published, summary, nothing, nothing, report_config(), "quick"
    )


def verdicts(first: ReportData, second: ReportData) -> dict[tuple[str, str], str]:
    table = comparison_table(first, second, ("A", "B"), report_config())
    assert table.origin is not None
    return {(line["solver"], line["what"]): line["verdict"] for line in table.records()}  # type: ignore[misc]


def test_a_folder_does_not_differ_from_itself() -> None:
    found = verdicts(data(("cycleik", "lm")), data(("cycleik", "lm")))
    assert set(found.values()) == {"within", "no interval"}
    assert found["CycleIK", "time a pose, median [µs]"] == "no interval"
    assert len(found) == 10


def test_numbers_beyond_the_intervals_are_marked_and_others_are_not() -> None:
    found = verdicts(data(("cycleik",)), data(("cycleik",), factor=3.0))
    assert found["CycleIK", "position error, mean [mm]"] == "differs"
    assert found["CycleIK", "rotation error, mean [deg]"] == "within"


def test_what_one_folder_lacks_is_named() -> None:
    found = verdicts(data(("cycleik", "lm")), data(("cycleik",)))
    assert {verdict for (solver, _), verdict in found.items() if solver != "CycleIK"} == {
        "only in one"
    }


def test_intervals_that_touch_overlap() -> None:
    line = {
        "value_a": 1.0,
        "low_a": 0.5,
        "high_a": 1.5,
        "value_b": 2.0,
        "low_b": 1.5,
        "high_b": 3.0,
    }
    assert verdict(line) == "within"
    assert verdict({**line, "low_b": 1.6}) == "differs"
    assert verdict({**line, "high_b": float("nan")}) == "no interval"


def test_a_folder_without_evaluations_has_nothing_to_compare() -> None:
    given = data(("lm",))
    empty = replace(given, summary=given.summary.iloc[:0])
    assert set(verdicts(given, empty).values()) == {"only in one"}
    assert verdicts(empty, empty) == {}
