"""Suites from the command line: generated, evaluated, kept, shown, and answers judged again."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pipeline.__main__ import main
from pipeline.data.tables import read_metadata, read_table
from tests.refusals import assert_refused

RUN = ["robot=nico", "profile=smoke", "evaluate.solvers=[lm]"]
SUITES = "suites=[unreachable,warm]"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("results")
    assert main(["suites", SUITES, *RUN, f"results_dir={made}"]) == 0
    return made


def test_rows_are_those_of_the_suite_and_of_no_plain_evaluation(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} >= {"suite", "evaluate_suite"}
    assert not (folder / "evaluate").exists()
    path = folder / "evaluate_suite" / "nico" / "unreachable" / "lm.parquet"
    rows, suite = read_table(path), folder / "suite" / "nico" / "unreachable.parquet"
    assert rows.pose.tolist() == list(range(40))
    assert rows.batch_size.unique().tolist() == [1]
    assert not rows.found.any()
    checksum = read_metadata(suite)["suite_checksum"]
    assert read_metadata(path)["suite_checksum"] == checksum


def test_the_same_again_measures_nothing_and_shows_the_same(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {path: path.stat().st_mtime_ns for path in folder.rglob("*.parquet")}
    assert main(["suites", SUITES, *RUN, f"results_dir={folder}"]) == 0
    out = capsys.readouterr().out
    assert "| NICO | warm | LM, compiled | 40 | 100.0 |" in out
    assert "| NICO | beyond 1mm | LM, compiled | 10 | 100.0 |" in out
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.parquet")} == files


def test_answers_are_judged_from_the_command_line(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suite = folder / "suite" / "nico" / "warm.parquet"
    frame = read_table(suite)
    answers = frame[[f"q{joint}" for joint in range(6)]].assign(
        pose=range(len(frame)), suite_checksum=read_metadata(suite)["suite_checksum"]
    )
    answers[:30].to_parquet(tmp_path / "mine.parquet")
    call = ["judge", str(tmp_path / "mine.parquet"), "suite=warm", *RUN[:2]]
    assert main([*call, f"results_dir={folder}"]) == 0
    out = capsys.readouterr().out
    assert "| NICO | warm | mine (re-judged) | 40 | 75.0 |" in out
    assert "10 of 40 poses have no answer, the first is pose 30" in out
    assert len(pd.read_parquet(folder / "judge" / "nico" / "warm" / "mine.parquet")) == 40
    assert main([*call, "seed=1", f"results_dir={folder}"]) == 2
    assert "other values of seed" in capsys.readouterr().err
    assert main([*call, "seed=1", f"results_dir={tmp_path}"]) == 2
    assert "answers the suite with the checksum" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["suites", "suites=[near]"], "no suite 'near'"),
        (["suites", "suites=[]"], "suites=[] names no suite"),
        (["suites", "suite=warm"], "suites takes suites=[...]"),
        (["evaluate-suite", "evaluate.seeded_by=cycleik"], "a suite says where solvers start"),
        (["evaluate-suite", "evaluate.solvers=[no_module:Solver]"], "cannot import no_module"),
        (["judge", "none.parquet", "suite=near"], "no suite 'near'"),
        (["judge", "none.parquet", "suite=warm", "--name", "../mine"], "--name is letters"),
        (["judge", "none.parquet", "suite=warm", "suite.name=../x"], "is a plain word"),
    ],
)
def test_what_cannot_be_is_refused(
    arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert_refused(arguments, words, tmp_path, capsys)
