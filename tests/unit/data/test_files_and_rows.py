"""Small files: broken ones are named in a sentence, rows go on after a kill."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.data.files import FileError, read_json, read_yaml, write_json
from pipeline.data.rows import Resumable, RowCheckpoint

ROWS = [{"solver": "lm", "pair": 0, "error": 0.5}, {"solver": "lm", "pair": 1, "error": 1e-9}]


@pytest.mark.parametrize("content", ["{", "", "[1, 2]", "null", '"text"'])
def test_what_is_no_json_object_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "card.json"
    path.write_text(content)
    with pytest.raises(FileError, match=r"card\.json .*make it again"):
        read_json(path)


def test_a_key_that_a_card_lacks_is_named_with_its_file(tmp_path: Path) -> None:
    write_json(tmp_path / "card.json", {"seed": 1})
    card = read_json(tmp_path / "card.json")
    assert card == {"seed": 1}
    assert card.get("files") is None
    with pytest.raises(FileError, match=r"card\.json has no 'files'"):
        card["files"]


@pytest.mark.parametrize("content", ["a: [1", "", "- 1", "a: b: c"])
def test_what_is_no_yaml_mapping_is_named(tmp_path: Path, content: str) -> None:
    path = tmp_path / "bench.yaml"
    path.write_text(content)
    with pytest.raises(FileError, match=r"bench\.yaml") as caught:
        read_yaml(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(FileError, match="cannot be read"):
        read_yaml(tmp_path / "none.yaml")


@pytest.mark.parametrize("cut", [1, 2, 20])
def test_rows_cut_off_anywhere_go_on_after_the_last_whole_one(tmp_path: Path, cut: int) -> None:
    path = tmp_path / "checkpoint" / "rows.jsonl"
    kept = RowCheckpoint(path, ("solver", "pair"))
    for row in ROWS:
        kept.put(row)
    whole = path.read_bytes()
    path.write_bytes(whole[:-cut])
    again = RowCheckpoint(path, ("solver", "pair"))
    assert again.get("lm", 0) == ROWS[0]
    assert again.get("lm", 1) == (ROWS[1] if cut == 1 else None)
    again.put(ROWS[1])
    last = RowCheckpoint(path, ("solver", "pair"))
    assert [last.get("lm", pair) for pair in (0, 1)] == ROWS
    last.clear()
    assert not path.exists()


class Pairs(Resumable):
    """Units of two rows each; notes which of them ran."""

    def __init__(self) -> None:
        self.ran: list[int] = []

    def units(self) -> dict[int, list[tuple[object, ...]]]:
        return {unit: [(unit, 0), (unit, 1)] for unit in range(3)}

    def unit(self, unit: int) -> list[dict[str, int]]:
        self.ran.append(unit)
        return [{"unit": unit, "half": half, "value": 10 * unit + half} for half in (0, 1)]


def test_units_with_a_missing_row_run_again_and_all_rows_come_in_order(tmp_path: Path) -> None:
    kept = RowCheckpoint(tmp_path / "rows.jsonl", ("unit", "half"))
    first, second = Pairs().unit(1), Pairs().unit(0)
    for row in (*first, second[0]):  # unit 0 was cut off after its first row
        kept.put(row)
    work, shown = Pairs(), list[int]()
    assert work.pending(kept) == [0, 2]
    rows = work.run(kept, lambda row: shown.append(row["value"]))
    assert work.ran == [0, 2]
    assert rows["value"].tolist() == shown == [0, 1, 10, 11, 20, 21]
    assert not work.pending(RowCheckpoint(kept.path, kept.key))
