"""Every table that is written says what made it; those from before say that they are older."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.commands.readme import _narrow
from pipeline.data.files import read_json
from pipeline.presentation.columns import text
from pipeline.presentation.origin import OLDER, Origin, older, origin_of
from pipeline.presentation.table import ORIGINS, Table
from pipeline.provenance import signature
from robots.locations import FOLDER

CARD = {
    "commit": "abc",
    "date": "2026-11-27",
    "machine": {"processor": "A chip", "accelerator": "none"},
    "seed": 0,
    "profile": "paper",
    "network": "Table I (smooth losses, 500 steps of warm-up, clipped at 10)",
}
COMMITTED = [
    *(
        FOLDER / "results" / name
        for name in ("paper/tables", "paper/older", "studies", "studies/accelerator")
    ),
    *sorted((FOLDER / "results/paper/table_one").iterdir()),
]


def table(origin: Origin | None, name: str = "small") -> Table:
    made = Table.of([{"a": "x"}], [text("a", "a")], name=name, title="T", caption="C.")
    made.origin = origin
    return made


def test_an_origin_joins_what_its_rows_say() -> None:
    other = {**CARD, "seed": 1, "machine": {"processor": "A chip", "accelerator": "a card"}}
    found = origin_of("python -m pipeline report", [CARD, other])
    assert (found.commit, found.date, found.seeds) == ("abc", "2026-11-27", "0, 1")
    assert found.processor == "A chip, A chip with a card"
    assert found.networks.startswith("Table I (smooth losses")
    said = found.sentence()
    assert said.startswith("Made by `python -m pipeline report`; commit abc; date 2026-11-27;")


def test_nothing_is_invented_for_rows_that_do_not_say_it() -> None:
    found = origin_of("x", [CARD, {"config": {"seed": 3}}])
    assert found.date == f"2026-11-27, {OLDER}"
    assert found.seeds == "0, 3"
    assert "older than the record" in older("x").sentence()


def test_a_table_is_written_with_its_origin_or_not_at_all(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="small does not say what made its rows"):
        table(None).write(tmp_path)
    assert not [*tmp_path.iterdir()]
    table(origin_of("a", [CARD])).write(tmp_path)
    assert "Made by `a`; commit abc" in (tmp_path / "small.md").read_text(encoding="utf-8")
    assert "commit abc" in (tmp_path / "small.tex").read_text(encoding="utf-8")
    assert read_json(tmp_path / ORIGINS)["small"]["processor"] == "A chip"
    (tmp_path / "small.csv").unlink()
    table(origin_of("b", [CARD]), "other").write(tmp_path)
    assert [*read_json(tmp_path / ORIGINS)] == ["other"], "those of tables that are no more go"


def test_rows_at_the_end_of_the_line_carry_commit_day_and_profile() -> None:
    signed = signature("quick")
    assert {*signed} == {"commit", "date", "profile"}
    assert len(signed["date"].split("-")) == 3


@pytest.mark.parametrize("folder", COMMITTED, ids=lambda path: path.name)
def test_every_committed_table_says_what_made_it_or_that_it_is_older(folder: Path) -> None:
    origins = read_json(folder / ORIGINS)
    for path in folder.glob("*.md"):
        assert {*origins[path.stem]} >= {"command", "commit", "date", "processor", "seeds"}
        assert "Made by `" in path.read_text(encoding="utf-8"), path
    assert {*origins} == {path.stem for path in folder.glob("*.csv")} - {"curve"}


def test_the_first_screen_names_the_network() -> None:
    heads = "Robot|Solver|pos. [mm] ours|pos. [mm] paper|rot. [deg] ours|rot. [deg] paper"
    heads += "|success [%] ours|success [%] paper|time [ms] ours|time [ms] paper|Network"
    row = "NICO|CycleIK|1|2|1|2|1|2|1|2|compact (ours) (matrix losses, clipped at 10)"
    lines = _narrow("\n".join(f"|{line}|" for line in (heads, heads, row)))
    assert lines[2] == "| NICO | CycleIK, compact (ours) | 1 | 2 | 1 | 2 | 1 | 2 | 1 | 2 |"
