"""compare tells robots, models and solvers apart, and computes what stages leave as raw rows."""

import re

import pytest
from synthetic import raw_rows

from pipeline.commands.compare import compare
from pipeline.data.files import write_json
from pipeline.data.tables import write_table
from pipeline.errors import PipelineError


def evaluation(root, solver, error_mm, damping=0.1):
    facts = {
        "seed": 0,
        "evaluate": {"chunk": 100},
        "solver_budget": {"time_s": None, "iterations": 30},
        "solver_identity": {"settings": {"damping": damping}},
    }
    rows = raw_rows("nico", solver, 20).assign(position_error_mm=error_mm)
    write_table(root / "evaluate" / "nico" / f"{solver}.parquet", rows.assign(answered=True), facts)


def test_evaluations_are_compared_by_their_rows_and_their_solver_settings(tmp_path, capsys):
    for name, error, damping in (("a", 2.0, 0.1), ("b", 4.0, 0.2)):
        evaluation(tmp_path / name, "placo", error, damping)
        evaluation(tmp_path / name, "lm", 1.0)
    assert compare([str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    out = capsys.readouterr().out
    assert re.search(r"evaluate/nico/placo: solver\.damping +0\.1 +0\.2", out)
    assert re.search(r"evaluate/nico/placo position_error_mm_mean +2 +4 +\+2 \(\+100\.0%\)", out)
    assert "nico/lm" not in out


def test_cards_of_several_robots_do_not_hide_each_other(tmp_path, capsys):
    for run, losses in (("a", {"nico": "former", "panda": "smooth"}), ("b", {})):
        for robot in ("nico", "panda"):
            folder = tmp_path / run / "train" / robot / "tiny"
            write_json(folder / "card.json", {"config": {"loss": losses.get(robot, "smooth")}})
            write_json(folder / "metrics.json", {"error_mm": 1.0})
    compare([str(tmp_path / "a"), str(tmp_path / "b")])
    out = capsys.readouterr().out
    assert re.search(r"train/nico/tiny: loss +former +smooth", out)
    assert "panda" not in out
    assert "metrics: the same" in out


def test_a_missing_folder_is_named(tmp_path):
    with pytest.raises(PipelineError, match="no folder"):
        compare([str(tmp_path / "x"), str(tmp_path)])
