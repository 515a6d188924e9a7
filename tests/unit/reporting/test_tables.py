"""Tables: the paper's number beside ours, and files that other programs read."""

import csv
import io
from types import SimpleNamespace

import pandas as pd
import pytest
from synthetic import PUBLISHED, raw_rows, report_config

from pipeline.presentation.columns import (
    ROBOT,
    count,
    number,
    p_value,
    share,
    significant,
    text,
    under,
)
from pipeline.presentation.published import PublishedError, read_published
from pipeline.presentation.table import Table
from pipeline.reporting.results import Results
from pipeline.reporting.summary import summarise
from pipeline.reporting.topics.outcomes import grasping
from pipeline.reporting.topics.paper import neural_comparison, numerical_comparison
from pipeline.reporting.topics.planner import planner
from pipeline.reporting.topics.training import hyperparameters


@pytest.fixture(scope="module")
def published():
    return read_published(PUBLISHED)


def records(table):
    return list(csv.DictReader(io.StringIO(table.to_csv())))


def test_table_two_sets_the_paper_beside_ours(published):
    rows = raw_rows("panda", "cycleik", poses=100)
    table = numerical_comparison(summarise(rows, report_config()), published)
    line = next(r for r in records(table) if r["solver"] == "CycleIK")
    ours = rows.paper_position_error_mm.mean()
    assert float(line["position_error_mean"]) == pytest.approx(ours)
    assert float(line["position_error_mean_paper"]) == 5.7
    assert float(line["position_error_mean_difference"]) == pytest.approx(ours - 5.7)
    assert float(line["time_per_pose"]) == pytest.approx(rows.time_per_pose_us.mean() / 1e3)
    assert float(line["success_rate_paper"]) == 89.18


def test_solvers_of_the_paper_that_were_not_run_keep_a_row(published):
    table = numerical_comparison(summarise(raw_rows(poses=10), report_config()), published)
    line = next(r for r in records(table) if r["solver"] == "BioIK")
    assert line["position_error_mean"] == ""
    assert line["position_error_mean_paper"] == "12.2"


def test_time_at_batch_size_one_only(published):
    rows = raw_rows(poses=100, batch_size=100)
    table = numerical_comparison(summarise(rows, report_config()), published)
    assert next(r for r in records(table) if r["solver"] == "CycleIK")["time_per_pose"] == ""


def test_table_three_times_a_batch_of_a_hundred(published):
    rows = pd.concat([raw_rows(poses=200), raw_rows(poses=100, batch_size=100)])
    table = neural_comparison(summarise(rows, report_config()), published)
    line = records(table)[0]
    assert (line["robot"], line["solver"]) == ("Panda", "CycleIK")
    expected = rows[rows.batch_size == 100].time_per_pose_us.mean() * 100 / 1e3
    assert float(line["time_per_batch_of_100"]) == pytest.approx(expected)
    assert line["time_per_batch_of_100_paper"] == "0.41"


def test_table_one_has_the_published_row_without_any_result(tmp_path, published):
    line = next(
        r for r in records(hyperparameters(Results(tmp_path), published)) if r["robot"] == "Panda"
    )
    assert line["source"] == "paper"
    assert line["neurons_per_layer"] == "1370 880 2980 1000 2710 2290 880"
    assert float(line["learning_rate"]) == pytest.approx(2.4)


def test_outcomes_beside_figure_five(tmp_path, published):
    results = Results(tmp_path)
    results.grasp["nico"] = pd.DataFrame({"class": ["Success"] * 9 + ["Not Grasped"]})
    lines = [
        r for r in records(grasping(results, published, report_config())) if r["robot"] == "NICO"
    ]
    shares = {line["outcome"]: float(line["share"]) for line in lines}
    assert shares == {
        "Success": 0.9,
        "Slipped": 0.0,
        "Not Grasped": 0.1,
        "Detection": 0.0,
        "LLM": 0.0,
    }
    assert float(lines[0]["share_paper"]) == 0.82
    assert float(lines[0]["share_difference"]) == pytest.approx(0.08)


def test_planner_rows_by_waypoint_become_one_a_plan(tmp_path, published):
    results = Results(tmp_path)
    results.plan["nico"] = pd.DataFrame(
        {
            "solver": "cycleik",
            "pair": [0, 0, 1, 1],
            "plan_time_ms": [2.0, 2.0, 4.0, 4.0],
            "tip_error_mm": [1.0, 3.0, 5.0, 2.0],
            "flips": [0, 0, 0, 1],
        }
    )
    line = records(planner(results, published))[0]
    assert line["plans"] == "2"
    assert float(line["time_median_ms"]) == 3.0
    assert float(line["tip_error_median_mm"]) == 4.0
    assert float(line["without_flip"]) == 0.5
    assert line["tip_error_mean_mm"] == ""
    assert line["time_paper_ms"] == "70.0"


def test_planner_rows_say_how_many_paths_stay_in_reach_and_can_be_followed(tmp_path, published):
    results = Results(tmp_path)
    results.plan["panda"] = pd.DataFrame(
        {
            "solver": ["lm"] * 4 + ["placo"] * 4,
            "pair": [0, 1, 2, 3] * 2,
            "plan_time_ms": [2.0, 2.0, 2.0, 900.0] * 2,
            "tip_error_mm": [0.1, 0.1, 0.1, 500.0, 0.1, 0.1, 0.1, 500.0],
            "flips": [0, 0, 1, 0, 0, 1, 1, 0],
            "query_flips": [3, 0, 1, 0, 1, 1, 1, 0],
            "waypoints": 50,
            "waypoints_found": [50, 50, 50, 20, 50, 50, 50, 20],
            "in_reach": [True, True, True, False] * 2,
            "continuous": [True, False, False, False] * 2,
        }
    )
    lm, placo = records(planner(results, published))
    assert (lm["plans"], lm["in_reach"]) == ("4", "3")
    # The search missed pair 1, but lm followed it.
    assert lm["continuous"] == placo["continuous"] == "2"
    assert float(lm["time_p99_ms"]) == 2.0
    assert float(lm["query_without_flip"]) == pytest.approx(1 / 3)
    assert float(lm["without_flip"]) == pytest.approx(2 / 3)
    assert float(lm["followed_without_flip"]) == 1.0
    assert float(placo["followed_without_flip"]) == 0.5


COLUMNS = (
    text("name", "Name"),
    *under("ours", number("error_mm", "error [mm]", "error"), share("share", "share [%]", "rate")),
)


@pytest.fixture
def small():
    lines = pd.DataFrame(
        {"name": ["x|y_z", "none"], "error": [0.012345, None], "rate": [0.5, None]}
    )
    return Table.of(lines, COLUMNS, name="small", title="A & B", caption="50 % of a_b | c")


def test_csv_keeps_full_precision_and_leaves_gaps_empty(small):
    assert records(small) == [
        {"name": "x|y_z", "error_mm": "0.012345", "share": "0.5"},
        {"name": "none", "error_mm": "", "share": ""},
    ]


def test_markdown_rows_have_as_many_bars_as_columns(small):
    lines = [line for line in small.to_markdown().splitlines() if line.startswith("|")]
    assert lines[2] == r"| x\|y_z | 0.0123 | 50.0 |"
    assert lines[3] == "| none | – | – |"
    assert lines[1] == "| --- | ---: | ---: |"


def test_latex_escapes_what_latex_would_eat(small):
    text = small.to_latex()
    assert r"\caption{A \& B. 50 \% of a\_b | c}" in text
    assert r"x|y\_z & 0.0123 & 50.0 \\" in text
    assert r"\multicolumn{2}{c}{ours}" in text


def test_html_escapes_and_says_a_repeated_name_once():
    columns = (text("robot", "Robot"), text("a", "a"))
    lines = [{"robot": "<b>", "a": "1"}, {"robot": "<b>", "a": "2"}]
    table = Table.of(lines, columns, name="t", title="T", caption="")
    assert table.to_html().count("&lt;b&gt;") == 1
    assert "<b>" not in table.to_html()


def test_a_column_whose_source_is_not_in_the_lines_is_refused():
    lines = pd.DataFrame({"name": ["a"], "eror": [1.0], "rate": [0.5]})
    with pytest.raises(KeyError, match=r"table small have no column .*error"):
        Table.of(lines, COLUMNS, name="small", title="", caption="")
    assert Table.of(pd.DataFrame(), COLUMNS, name="small", title="", caption="").rows == []


def test_a_cell_comes_from_a_key_an_attribute_or_a_function_and_keeps_its_kind():
    line = {"poses": 3.0, "robot": "nico", "gap": float("nan")}
    assert count("poses", "").cell(line) == 3
    assert isinstance(count("poses", "").cell(line), int)
    assert count("gap", "").cell(line) != count("gap", "").cell(line)  # NaN stays a gap
    assert ROBOT.cell(line) == "NICO"
    assert ROBOT.cell(SimpleNamespace(robot="panda")) == "Panda"
    assert number("half", "", lambda row: row["poses"] / 2).cell(line) == 1.5
    assert [p_value("p").cell({"p": p}) for p in (0.0004, 0.25)] == ["< 0.001", "0.250"]


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (12.345, "12.3"),
        (-0.5, "−0.500"),
        (12345.6, "12,346"),
        (1e-9, "< 0.0001"),
        (0.00862, "0.0086"),
    ],
)
def test_numbers_have_significant_digits(value, shown):
    assert significant(value, 3) == shown


def test_published_numbers_are_checked(tmp_path):
    with pytest.raises(PublishedError, match="there is no"):
        read_published(tmp_path / "none.csv")
    (tmp_path / "bad.csv").write_text("table,robot\na,b\n")
    with pytest.raises(PublishedError, match="method, metric, value, unit"):
        read_published(tmp_path / "bad.csv")
