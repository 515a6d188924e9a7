"""Protocols from the command line: all six run, are kept, and leave other rows alone."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from pipeline.__main__ import main
from pipeline.data.tables import read_metadata, read_table
from tests.refusals import assert_refused

PROTOCOLS = ["curobo", "hjcd_ik", "trac_ik"]  # all six: tests/slow/test_all_protocols.py
RUN = [
    "protocols=[curobo,hjcd_ik,trac_ik]",
    "robot=nico",
    "profile=smoke",
    "protocol.most_poses=4",
    "protocol.solvers=[placo,pinocchio]",
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("results")
    assert main(["protocols", *RUN, f"results_dir={made}"]) == 0
    return made


def test_each_has_rows_of_the_same_solvers_and_one_figure(folder: Path) -> None:
    rows = folder / "evaluate_protocol" / "nico"
    assert sorted(path.name for path in rows.iterdir()) == PROTOCOLS
    assert not (folder / "evaluate").exists()
    assert not (folder / "evaluate_suite").exists()
    path = rows / "hjcd_ik" / "placo" / "batch10.parquet"
    made = read_table(path)
    assert (len(made), made.target.nunique(), made.call.nunique()) == (40, 4, 4)
    assert read_metadata(path)["protocol"]["title"] == "HJCD-IK"
    assert read_metadata(rows / "trac_ik/placo/batch1.parquet")["solver_identity"]["settings"][
        "position_tolerance_m"
    ] == pytest.approx(1e-5)
    out = folder / "protocols" / "nico"
    ranked = pd.read_csv(out / "protocols.csv")
    assert list(dict.fromkeys(ranked.protocol)) == ["TRAC-IK", "cuRobo / PyRoki", "HJCD-IK"]
    assert len(pd.read_csv(out / "protocol_agreement.csv")) == 3
    assert (out / "protocols.png").stat().st_size > 10_000


def test_the_same_again_measures_nothing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = {path: path.stat().st_mtime_ns for path in folder.rglob("*.parquet")}
    assert main(["protocols", *RUN, f"results_dir={folder}"]) == 0
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*.parquet")} == files


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["protocols", "protocols=[trac]"], "no protocol 'trac'"),
        (["protocols", "protocols=[]"], "protocols=[] names no protocol"),
        (["protocols", "protocol=trac_ik"], "protocols takes protocols=[...]"),
        (
            ["evaluate-protocol", "evaluate.seeded_by=cycleik"],
            "a protocol says where solvers start",
        ),
        (["evaluate-protocol", "protocol.solvers=[no_such]"], "no solver 'no_such'"),
    ],
)
def test_what_cannot_be_is_refused(
    arguments: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert_refused(arguments, words, tmp_path, capsys)
