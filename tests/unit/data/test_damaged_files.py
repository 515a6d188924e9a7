"""Each kind of file cut off and with flipped bytes: refused by its name, made anew, never wrong.

`python -m benchmarks.fuzzing files` does the same at many more places.
"""

from __future__ import annotations

import logging
import random
from collections import Counter
from pathlib import Path

import pytest

from benchmarks.fuzzing.files import KINDS, attack
from pipeline.data.files import (
    FileError,
    check_listed,
    read_json,
    read_sealed_yaml,
    replacing,
    sha256,
    write_sealed_json,
    write_sealed_yaml,
)
from pipeline.tuning.journal_file import JournalFile, whole_bytes

PLACES = 8


@pytest.mark.parametrize("name", KINDS)
def test_a_damaged_file_is_refused_or_made_anew(name: str, tmp_path: Path) -> None:
    ends = Counter[str]()
    wrong = list(attack(KINDS[name], tmp_path / "made", PLACES, random.Random(name), ends))
    assert not wrong
    assert ends["refused"] + ends["anew"] + ends["taken"] >= PLACES


def test_a_sealed_object_comes_back_without_its_seal_and_an_edit_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "card.json"
    content = {"a": [1, 2.5, None, float("inf")], "b": {"ä": "ö"}, "c": {1: "x"}}
    write_sealed_json(path, content)
    assert read_json(path) == {**content, "c": {"1": "x"}}
    path.write_text(path.read_text().replace("2.5", "2.6"))
    with pytest.raises(FileError, match=r"card\.json was changed after it was written"):
        read_json(path)
    path.write_text('{"a": 1}')  # of an earlier version, or by hand
    assert read_json(path) == {"a": 1}


def test_sealed_yaml_may_be_edited_but_not_cut(tmp_path: Path) -> None:
    path = tmp_path / "best.yaml"
    write_sealed_yaml(path, "train:\n  rate: 0.0012\n")
    whole = path.read_text()
    assert read_sealed_yaml(path) == {"train": {"rate": 0.0012}}
    path.write_text("train:\n  rate: 0.001")
    with pytest.raises(FileError, match="is cut off"):
        read_sealed_yaml(path)
    path.write_text(whole.replace("0.0012", "0.0013"))
    with pytest.raises(FileError, match="remove its last line"):
        read_sealed_yaml(path)
    path.write_text(path.read_text().rsplit("# sha256", 1)[0])
    assert read_sealed_yaml(path) == {"train": {"rate": 0.0013}}


def test_a_file_that_a_card_knows_otherwise_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "curve.csv"
    path.write_text("a,b\n1,2.25\n")
    card = {"files": {"curve.csv": sha256(path)}}
    check_listed(path, card)
    path.write_text("a,b\n1,2.2")
    with pytest.raises(FileError, match=r"curve\.csv was changed"):
        check_listed(path, card)
    check_listed(path, {})


def test_what_killed_writers_left_is_removed_and_that_of_others_stays(tmp_path: Path) -> None:
    with replacing(tmp_path / "rows.parquet") as partial:
        partial.write_bytes(b"a")
        name = partial.name
    head, _, end = name.partition(".partial")
    node = head.rpartition("-")[0]
    dead, foreign = (
        tmp_path / f"{node}-999999999.partial{end}",
        tmp_path / f".rows.far-7.partial{end}",
    )
    alive = tmp_path / f"{node}-1.partial{end}"
    for path in (dead, foreign, alive):
        path.write_bytes(b"half")
    with replacing(tmp_path / "rows.parquet") as partial:
        partial.write_bytes(b"b")
    assert {path.name for path in tmp_path.iterdir()} == {"rows.parquet", foreign.name, alive.name}


def test_a_journal_of_an_earlier_version_has_no_checksums_and_is_taken(tmp_path: Path) -> None:
    path = tmp_path / "tune.log"
    path.write_text('{"op_code":0,"worker_id":"a"}\n{"op_code":4,"worker_id":"a"}\n')
    assert whole_bytes(path) == path.stat().st_size
    file = JournalFile(path)
    file.append_logs([{"op_code": 5, "worker_id": "b"}])
    assert [log["op_code"] for log in file.read_logs(0)] == [0, 4, 5]
    assert all("crc32" not in log for log in file.read_logs(0))
    path.write_text(path.read_text().replace('"op_code":5', '"op_code":6'))
    assert path.read_bytes()[: whole_bytes(path)].count(b"\n") == 2


def test_a_damaged_journal_says_where(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    kind = KINDS["journal of a search (JSON lines)"]
    path = kind.make(tmp_path)
    path.write_bytes(path.read_bytes()[:-9] + b"\n")
    logging.getLogger("cycleik_bench").addHandler(caplog.handler)
    kind.read(path)
    logging.getLogger("cycleik_bench").removeHandler(caplog.handler)
    assert "tune.log is damaged from byte" in caplog.text
