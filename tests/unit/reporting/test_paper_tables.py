"""Tables II and III alone, from the folder that holds rows for them."""

import pandas as pd
import pytest
from synthetic import PUBLISHED, SOLVERS, raw_rows, report_config

from pipeline.data.tables import write_table
from pipeline.errors import MissingArtifactError, PipelineError
from pipeline.presentation.published import read_published
from pipeline.reporting.single import paper_table
from pipeline.reporting.summary import summarise
from pipeline.reporting.topics.paper import neural_comparison, numerical_comparison


@pytest.fixture(scope="module")
def published():
    return read_published(PUBLISHED)


def put(folder, solver, **changes):
    rows = raw_rows("panda", solver if solver in SOLVERS else "cycleik", 50)
    rows = rows.assign(solver=solver, **changes)
    write_table(folder / "evaluate" / "panda" / f"{solver}.parquet", rows, {})


def cells(table, solver, robot="Panda"):
    names = [column.name for column in table.columns]
    wanted = [row for row in table.rows if row[:2] == [robot, solver]]
    assert len(wanted) == 1, solver
    return dict(zip(names, wanted[0], strict=True))


def test_the_first_folder_with_rows_for_the_table_is_taken_and_told(tmp_path, published):
    paper, quick = tmp_path / "paper", tmp_path / "quick"
    put(paper, "lm")
    put(quick, "lm")
    put(quick, "cycleik")
    config = report_config()
    table, folder = paper_table("table2", [paper, quick], published, config)
    assert folder == paper
    assert table.notes[-1] == "Rows: paper/evaluate, panda."
    table, folder = paper_table("table3", [paper, quick], published, config)
    assert folder == quick
    with pytest.raises(MissingArtifactError, match="evaluate"):
        paper_table("table2", [tmp_path / "none"], published, config)
    with pytest.raises(PipelineError, match="no table 'table4'"):
        paper_table("table4", [paper], published, config)


def test_table_two_has_our_metric_and_a_solver_that_was_not_pinned(published):
    rows = raw_rows("panda", "trac_ik", 80)
    free = rows.assign(solver="trac_ik_unpinned", threads=2, pinned=False)
    summary = summarise(rows, report_config())
    table = numerical_comparison(summary, published)
    line = cells(table, "TRAC-IK")
    assert line["euclidean_mm"] == pytest.approx(summary.position_error_mm_mean.iloc[0])
    assert line["strict_low"] < line["strict"] < line["strict_high"]
    assert line["cores"] == 1
    line = cells(
        numerical_comparison(summarise(free, report_config()), published), "TRAC-IK, unpinned"
    )
    assert line["cores"] == 2
    assert line["position_error_mean_paper"] == 44.0


def test_table_three_takes_every_network_and_marks_what_is_published(published):
    rows = raw_rows("panda", "cycleik", 80)
    networks = [rows, rows.assign(solver="flow"), rows.assign(solver="lm")]
    table = neural_comparison(summarise(pd.concat(networks), report_config()), published)
    assert cells(table, "CycleIK")["source"] == "this run"
    assert cells(table, "flow")["source"] == "this run"
    assert cells(table, "flow")["position_error_mean_paper"] is None
    for name in ("IKFlow", "EEM"):
        line = cells(table, name)
        assert line["source"] == "published"
        assert line["position_error_mean"] is None
        assert line["position_error_mean_paper"] > 0
    assert cells(table, "CycleIK", "Valkyrie")["source"] == "published"
    assert not [row for row in table.rows if row[1] == "LM, compiled"]
