"""No published number and no claim of the paper stays without rows or a reason."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pipeline.commands.claims import closing_rows, closing_tables, in_short, table_one
from pipeline.errors import PipelineError
from pipeline.presentation.published import Published, read_published
from pipeline.reporting.claims import (
    FAILS,
    HOLDS,
    UNTESTED,
    VERDICTS,
    ClaimsError,
    every_claim,
    read_claims,
)
from pipeline.reporting.evidence import Evidence, Measured
from pipeline.reporting.numbers import Line, Setting, every_number

RESULTS = Path(__file__).parents[3] / "results"
RULE = {
    "metric": "position_error_mean",
    "best": "lowest",
    "solver": "cycleik",
    "among": ["bio_ik"],
    "robots": ["panda", "nico"],
}
ENTRY = {"id": "a", "claim": "b", "where": "IV", "test": "c"}


def table_two(folder: Path, *rows: tuple[str, str, float]) -> Evidence:
    """Write a Table II with position errors of solvers on robots."""
    lines = pd.DataFrame(rows, columns=["robot", "solver", "position_error_mean"])
    lines = lines.assign(position_error_sd=10.0, success_rate=90.0, poses=100)
    (folder / "paper" / "tables").mkdir(parents=True, exist_ok=True)
    lines.to_csv(folder / "paper/tables/table2_numerical_comparison.csv", index=False)
    return Evidence(folder)


def verdict_of(evidence: Evidence) -> tuple[str, str]:
    (claim,) = every_claim([{**ENTRY, "rules": [RULE]}], evidence)
    return claim.verdict.verdict, claim.verdict.reason


def test_every_published_number_has_one_of_ours_or_a_reason() -> None:
    numbers, _ = closing_tables(RESULTS)
    published = read_published(RESULTS / "published_results.csv").rows
    keys = ["table", "robot", "method", "metric"]
    assert len(numbers.rows) == len(published) == len(published[keys].drop_duplicates()) == 160
    for row in numbers.records():
        assert row["ours"] is not None or row["why"], row
        assert not row["difference"] or row["why"], row
        assert row["rows"] is None or (RESULTS / str(row["rows"])).exists(), row


def test_every_claim_has_a_verdict_and_every_verdict_its_rows_or_its_reason() -> None:
    _, claims = closing_tables(RESULTS)
    rows = claims.records()
    assert len({row["id"] for row in rows}) == len(rows) > 40
    for row in rows:
        assert row["verdict"] in VERDICTS
        assert row["reason"] and row["claim"] and row["where"] and row["test"], row
        assert row["verdict"] == UNTESTED or row["rows"], row
        assert row["rows"] is None or (RESULTS / str(row["rows"])).exists(), row


def test_claims_cover_every_table_and_figure_of_results_and_the_abstract() -> None:
    entries, _ = read_claims(RESULTS / "claims.yaml")
    places = " ".join(str(entry["where"]) for entry in entries)
    for place in ("abstract", "II", "III", "IV-A", "IV-B", "IV-C", "Table II", "Fig. 5", "V"):
        assert place in places


def test_a_number_without_ours_or_a_reason_is_refused(tmp_path: Path) -> None:
    rows = read_published(RESULTS / "published_results.csv").rows
    published = Published(rows[rows.method == "eem"])
    reason = {"table": "neural_*", "method": "eem", "why": "not built again"}
    assert [line.why for line in every_number(published, Evidence(tmp_path), {}, [reason])] == [
        "not built again",
        "not built again",
    ]
    for others in ([], [{**reason, "ours": "measured"}], [{**reason, "robot": "nico"}]):
        with pytest.raises(PipelineError, match=r"eem position_error_mean is published as 12\.3"):
            every_number(published, Evidence(tmp_path), {}, others)


def test_a_claim_holds_only_where_every_robot_shows_it(tmp_path: Path) -> None:
    good = [("Panda", "CycleIK", 1.0), ("Panda", "BioIK", 2.0), ("NICO", "CycleIK", 3.0)]
    verdict, reason = verdict_of(table_two(tmp_path / "a", *good))
    assert verdict == UNTESTED and "NICO (BioIK)" in reason
    verdict, reason = verdict_of(table_two(tmp_path / "b", *good, ("NICO", "BioIK", 4.0)))
    assert verdict == HOLDS and "NICO: position_error_mean CycleIK 3, BioIK 4" in reason
    verdict, reason = verdict_of(table_two(tmp_path / "c", *good, ("NICO", "BioIK", 2.5)))
    assert verdict == FAILS and "Panda" not in reason
    missing, _ = verdict_of(Evidence(tmp_path / "none"))
    assert missing == UNTESTED


def test_intervals_of_table_two_by_hand(tmp_path: Path) -> None:
    evidence = table_two(tmp_path, ("Panda", "BioIK", 5.0))
    mean = evidence.precision("panda", "bio_ik", "position_error_mean")
    assert mean is not None and mean.low is not None and mean.high is not None
    assert (mean.low, mean.high) == pytest.approx((5 - 1.959964, 5 + 1.959964), abs=1e-6)
    rate = evidence.precision("panda", "bio_ik", "success_rate")
    assert rate is not None and rate.low == pytest.approx(82.563, abs=1e-3)
    assert evidence.precision("panda", "bio_ik", "position_error_sd") == Measured(10.0, mean.rows)
    assert evidence.precision("nico", "bio_ik", "position_error_mean") is None


def test_a_number_agrees_where_its_interval_holds_the_published_one() -> None:
    def line(published: str, measured: Measured) -> Line:
        return Line("t", "nico", "lm", "m", "", published, measured, "")

    assert line("2", Measured(2.5, "", 1.9, 3.1)).agrees
    assert not line("2", Measured(2.5, "", 2.1, 2.9)).agrees
    assert line("29146000", Measured(29146188.0)).agrees
    assert line("1 2", Measured("1 2")).agrees and not line("1 2", Measured("1 3")).agrees
    assert line("1 2", Measured("1 2")).difference is None


def test_parameters_are_counted_from_the_layers() -> None:
    assert Setting({}, [4, 5], 3).get("parameters") == 8 * 4 + 5 * 5 + 6 * 3
    assert table_one("nico").get("parameters") == 11_514_096
    assert table_one("nico").get("degrees_of_freedom") == 6


@pytest.mark.parametrize(
    ("entry", "complaint"),
    [
        ({"id": "a"}, "lacks claim, where, test"),
        ({**ENTRY, "verdict": "maybe", "reason": "x"}, "verdict of holds"),
        ({**ENTRY, "verdict": "holds"}, "a reason"),
        ({**ENTRY, "verdict": "holds", "reason": "x"}, "without rows"),
        ({**ENTRY, "rules": [{**RULE, "best": "least"}]}, "best is lowest or highest"),
    ],
)
def test_claims_that_leave_something_open_are_refused(
    tmp_path: Path, entry: dict[str, object], complaint: str
) -> None:
    path = tmp_path / "claims.yaml"
    path.write_text(str({"claims": [entry], "numbers": []}))
    with pytest.raises(ClaimsError, match=complaint):
        read_claims(path)


def test_a_missing_or_damaged_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(ClaimsError, match="there is no"):
        read_claims(tmp_path / "none.yaml")
    (tmp_path / "bad.yaml").write_text("claims: [")
    with pytest.raises(ClaimsError, match="not readable"):
        read_claims(tmp_path / "bad.yaml")
    (tmp_path / "half.yaml").write_text("claims: []")
    with pytest.raises(ClaimsError, match="lacks the lists"):
        read_claims(tmp_path / "half.yaml")


def test_numbers_stand_in_the_order_of_the_file() -> None:
    rows = pd.DataFrame([["hyperparameters", "nico", "cycleik", "batch_size", "300", ""]])
    rows.columns = ["table", "robot", "method", "metric", "value", "unit"]
    settings = {"nico": Setting({"batch_size": 300.0}, [1], 6)}
    (line,) = every_number(Published(rows), Evidence(RESULTS), settings, [])
    assert line.agrees and line.difference == 0 and line.why == ""


def test_the_short_form_in_the_readme_is_that_of_the_tables_on_disk() -> None:
    text = (RESULTS.parent / "README.md").read_text(encoding="utf-8")
    assert in_short(*closing_rows(RESULTS)) in text, "python -m pipeline claims --readme"
