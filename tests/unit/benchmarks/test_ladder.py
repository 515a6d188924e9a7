"""Owners of lost trials by hand, gains by McNemar's test, and the cells' runs."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from benchmarks.ladder.cells import Cell, cells, keep_messages
from benchmarks.ladder.owners import gains, oracles, with_owners
from benchmarks.ladder.tables import tables
from pipeline.config import compose

PERCEPTION = {"e": "miscalibrated", "c": "camera", "p": "perfect"}
SOLVER = {"n": "cycleik", "r": "cycleik_refined"}
CLASS = {"1": "Success", "0": "Slipped"}


def rows_of(**outcomes: str) -> pd.DataFrame:
    """Rows of NICO's cells, such as en="10": perception and solver, then a digit a trial."""
    return pd.DataFrame(
        [
            {
                "robot": "nico",
                "perception": PERCEPTION[name[0]],
                "agent": "policy",
                "solver": SOLVER[name[1]],
                "trial": number,
                "object": "tomato",
                "class": CLASS[digit],
                "reason": "",
                "sighting_error_mm": 1.0,
                "wall_s": 2.0,
            }
            for name, digits in outcomes.items()
            for number, digit in enumerate(digits)
        ]
    )


def owners(rows: pd.DataFrame, perception: str, solver: str) -> list[str]:
    owned = with_owners(rows)
    part = owned[(owned.perception == PERCEPTION[perception]) & (owned.solver == SOLVER[solver])]
    return [*part["owner"]]


def test_the_first_oracle_that_mends_a_trial_says_who_owns_it() -> None:
    #            won, calibration, perception, solver, several, physics
    rows = rows_of(
        en="100000",
        cn="110000",
        pn="111000",
        er="100100",
        cr="110100",
        pr="111110",
    )
    first = ["", "calibration", "perception", "solver", "several", "physics"]
    assert owners(rows, "e", "n") == first
    assert owners(rows, "c", "n") == ["", "", "perception", "solver", "several", "physics"]
    assert owners(rows, "p", "n") == ["", "", "", "solver", "solver", "physics"]
    assert owners(rows, "p", "r") == ["", "", "", "", "", "physics"]


def test_what_has_not_run_leaves_its_trials_undecided() -> None:
    rows = rows_of(en="00", cn="01", pr="1")
    # Trial 0: whether true places mend it is not known. Trial 1: the calibrated eye does.
    assert owners(rows, "e", "n") == ["undecided", "calibration"]
    assert owners(rows, "c", "n") == ["undecided", ""]
    assert owners(rows, "p", "r") == [""]


def test_a_language_model_is_owned_by_the_agent() -> None:
    lost = rows_of(en="0", cn="0", pn="0", er="0", cr="0", pr="1")
    model = lost.assign(agent="local")
    won = lost.assign(**{"class": "Success"})
    owned = with_owners(pd.concat([model, won]))
    bottom = owned[(owned.agent == "local") & (owned.perception == "miscalibrated")]
    assert [*bottom["owner"]] == ["agent", "perception"]  # true places alone mend the second
    assert [*oracles(Cell("nico", "perfect", "local", "cycleik_refined"))] == ["agent"]


def test_gains_are_paired_by_trial_and_tested() -> None:
    # Eight trials that only true places win, one that only the camera wins, one more only it ran:
    # McNemar exact, two-sided: 2 (1 + 9) / 2^9.
    found = gains(rows_of(cn="0000000011", pn="111111110"))
    (gain,) = found
    assert (gain.owner, gain.trials, gain.won, gain.lost) == ("perception", 9, 8, 1)
    assert gain.test.effect == pytest.approx(7 / 9)
    assert gain.test.p_value == pytest.approx(20 / 512)
    assert gain.adjusted == gain.test.p_value  # the only one


def test_tables_count_every_lost_trial_once() -> None:
    rows = with_owners(rows_of(en="1000", cn="1100", pn="1110", er="1000", cr="1100", pr="1110"))
    shown, owned, gained, lost = (table.records() for table in tables(rows))
    assert [line["trials"] for line in shown] == [4] * 6
    assert shown[0]["slipped"] == 3
    assert shown[0]["trial_s"] == 2.0
    names = ("calibration", "perception", "agent", "solver", "several", "physics", "undecided")
    for line in owned:
        assert line["lost"] == sum(int(str(line[name])) for name in names)
    assert [owned[0][name] for name in names] == [1, 1, 0, 0, 0, 1, 0]
    assert len(gained) == 9
    assert [line["trial"] for line in lost] == [1, 2, 3]


def test_cells_differ_in_one_part_alone_and_the_most_telling_come_first() -> None:
    made = cells(["nico", "nicol"], ["policy"])
    assert len(made) == 12
    assert made[0] == Cell("nico", "miscalibrated", "policy", "cycleik")
    assert made[2].name == "perfect/policy/cycleik_refined"
    assert len(cells(["nico"], ["policy", "local"])) == 12
    plain, other = (compose(cell.overrides(5)) for cell in (made[4], made[0]))
    assert (other.grasp.solver, plain.grasp.solver) == ("cycleik", "cycleik_refined")
    assert plain.grasp.placements == "pinned"
    assert plain.results_dir != other.results_dir
    assert other.perception.title == "miscalibrated"


def test_what_a_language_model_answered_is_kept_and_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell, other = (Cell("nico", "camera", kind, "cycleik") for kind in ("local", "endpoint"))
    recorded = compose(cell.overrides(5)).agent
    replayed = compose(cell.overrides(5, tmp_path / "said.jsonl")).agent
    assert (recorded.kind, replayed.kind) == ("local", "replay")
    assert recorded.record == str(cell.messages) != str(other.messages)
    assert replayed.file == str(tmp_path / "said.jsonl")
    assert compose(other.overrides(5)).agent.record == str(other.messages)
    monkeypatch.setattr("benchmarks.ladder.cells.FOLDER", tmp_path)
    keep_messages([cell, other], tmp_path / "all.jsonl")
    assert not (tmp_path / "all.jsonl").exists()
    for each, text in ((cell, "a\nb\n"), (other, "b\nc\n")):
        each.messages.parent.mkdir(parents=True)
        each.messages.write_text(text)
    keep_messages([cell, other], tmp_path / "all.jsonl")
    assert (tmp_path / "all.jsonl").read_text() == "a\nb\nc\n"
