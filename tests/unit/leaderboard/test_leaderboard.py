"""Lines of the leaderboard: a round trip from a file that is sent, the schema, ranks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from pipeline.__main__ import main
from pipeline.commands.leaderboard import Destination, add_file
from pipeline.data.tables import read_metadata, read_table, write_table
from pipeline.evaluation.statistics import shifted_geometric_mean
from pipeline.leaderboard.boards import machine_name, put, read_boards
from pipeline.leaderboard.errors import LeaderboardError
from pipeline.leaderboard.schema import read_lines
from pipeline.leaderboard.standings import overall, ranked
from tests.leaderboard_lines import LINE


def put_all(folder: Path, *changes: dict[str, Any]) -> Path:
    return [put(folder, "desk", {**LINE, **change}) for change in changes][-1]


def sent_line(
    run: Path, folder: Path, columns: dict[str, Any], facts: dict[str, Any] | None = None
) -> Any:
    """The line of somebody's answers to `warm` of a run: the right ones, but for some columns."""
    suite = run / "suite" / "nico" / "warm.parquet"
    checksum = read_metadata(suite)["suite_checksum"]
    sent = read_table(suite)[[f"q{joint}" for joint in range(6)]]
    sent = sent.assign(pose=range(len(sent)), suite_checksum=checksum, **columns)
    sent.to_parquet(folder / "mine.parquet")
    said = {"solver": "mine", "robot": "nico", "suite": "warm", "profile": "smoke", "seed": 0}
    said |= {"versions": {"mine": 1}, "commit": "v1", "threads": 1, "date": "2026-11-27"}
    said |= {"processor": "a processor", **(facts or {})}
    (folder / "mine.yaml").write_text(yaml.safe_dump(said))
    board, _ = add_file(
        folder / "mine.parquet", Destination(folder / "boards", "desk"), [f"results_dir={run}"]
    )
    return read_lines(board).iloc[0]


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("run")
    call = ["suites", "suites=[warm]", "robot=nico", "profile=smoke", "evaluate.solvers=[lm]"]
    assert main([*call, f"results_dir={made}"]) == 0
    return made


def test_a_file_that_is_sent_becomes_a_line_and_a_second_time_the_same(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    raw = run / "evaluate_suite" / "nico" / "warm" / "lm.parquet"
    folder, suite = tmp_path / "boards", read_table(run / "suite" / "nico" / "warm.parquet")
    add = ["leaderboard", "add", "--machine", "desk", "--folder", str(folder)]
    assert main([*add, str(raw), f"results_dir={run}"]) == 0
    path = folder / "desk" / "warm_nico.csv"
    line = read_lines(path).iloc[0]
    rows = read_table(raw)
    assert line.good == line.good_poses == 40
    assert line.position_median_mm == pytest.approx(rows.position_error_mm.median(), rel=1e-5)
    assert line.time_median_us == pytest.approx(rows.time_per_pose_us.median(), rel=1e-5)
    assert line.timed_by == "here"
    first = path.read_bytes()
    assert main([*add, str(raw), f"results_dir={run}"]) == 0
    assert path.read_bytes() == first

    sent = suite[[f"q{joint}" for joint in range(6)]].assign(
        pose=range(40), suite_checksum=line.suite_checksum, time_us=np.arange(1.0, 41.0)
    )
    sent.loc[30:, "q0"] += 0.5
    sent.to_parquet(tmp_path / "mine.parquet")
    facts = {"solver": "mine", "robot": "nico", "suite": "warm", "profile": "smoke", "seed": 0}
    facts |= {"versions": {"mine": 1}, "commit": "v1", "threads": 1, "date": "2026-11-27"}
    facts |= {"processor": line.processor}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(facts))
    assert main([*add, str(tmp_path / "mine.parquet"), f"results_dir={run}"]) == 0
    assert "10 of 40 poses are claimed but wrong" in capsys.readouterr().out
    mine = read_lines(path).set_index("solver").loc["mine"]
    assert (mine.good, mine.claimed_and_wrong, mine.timed_by) == (30, 10, "sender")
    assert (mine.within_10us, mine.within_1000000us) == (10, 30)
    placed = ranked(read_boards(folder), 0.95)
    assert placed.solver.tolist() == ["lm", "mine"]
    assert placed["rank"].tolist() == [1, 2]
    assert main(["leaderboard", "check", "--folder", str(folder)]) == 0

    del facts["threads"]
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(facts))
    assert main([*add, str(tmp_path / "mine.parquet"), f"results_dir={run}"]) == 2
    assert "does not say threads" in capsys.readouterr().err


def test_errors_and_claims_in_a_file_are_not_believed(run: Path, tmp_path: Path) -> None:
    raw = run / "evaluate_suite" / "nico" / "warm" / "lm.parquet"
    forged, facts = read_table(raw), read_metadata(raw)
    forged["q1"] += 0.3
    forged["position_error_mm"] = 0.0
    write_table(tmp_path / "lm.parquet", forged, facts)
    folder = tmp_path / "boards"
    add = ["leaderboard", "add", str(tmp_path / "lm.parquet"), "--folder", str(folder)]
    assert main([*add, f"results_dir={run}"]) == 0
    line = read_boards(folder).iloc[0]
    assert line.good == 0
    assert line.position_median_mm > 10


def test_a_column_of_a_sender_that_is_no_answer_is_not_believed(run: Path, tmp_path: Path) -> None:
    """Who claims nothing has found nothing, whatever else the file says."""
    line = sent_line(run, tmp_path, {"found": False, "answered": True})
    assert (line.good, line.claimed_and_wrong) == (0, 0)


@pytest.mark.parametrize(
    ("columns", "facts", "words"),
    [
        ({"time_us": "fast"}, {}, "time_us must hold numbers"),
        ({"time_us": 0.0}, {}, "time_us must be above 0"),
        ({}, {"threads": "two"}, "threads must be a whole number from 1, got 'two'"),
        ({}, {"seed": "none"}, "seed must be a whole number from 0, got 'none'"),
        ({}, {"date": "today"}, "date must be a day"),
        ({}, {"solver": "my solver"}, "solver must be letters"),
    ],
)
def test_what_a_sender_says_wrongly_is_one_sentence(
    columns: dict[str, Any],
    facts: dict[str, Any],
    words: str,
    run: Path,
    tmp_path: Path,
) -> None:
    with pytest.raises(LeaderboardError, match=words):
        sent_line(run, tmp_path, columns, facts)


def test_poses_of_a_suite_are_no_answers(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    poses = run / "suite" / "nico" / "warm.parquet"
    add = ["leaderboard", "add", str(poses), "--folder", str(tmp_path), f"results_dir={run}"]
    assert main(add) == 2
    assert "holds the poses of a suite and no answers" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"good": 101}, "good is 101, more than trials"),
        ({"suite_checksum": "ab"}, "suite_checksum must be 64 hex digits"),
        ({"date": "today"}, "date must be a day"),
        ({"position_mean_mm": float("nan")}, "position_mean_mm must be a finite number"),
        ({"solver": "<b>"}, "solver must be letters"),
        ({"within_10us": 95}, "within_..us must rise"),
        ({"within_100us": 95}, "within_..us must rise"),
        ({"time_median_us": ""}, "some of its times are missing"),
        ({"threads": 0}, "threads must be a whole number from 1"),
        ({"timed_by": "nobody"}, "timed_by must be here"),
    ],
)
def test_a_line_that_cannot_be_is_refused_and_nothing_is_written(
    change: dict[str, Any], words: str, tmp_path: Path
) -> None:
    with pytest.raises(LeaderboardError, match=words):
        put_all(tmp_path, change)
    assert not list(tmp_path.rglob("*.csv"))


def test_a_board_is_of_one_suite_and_a_machine_of_one_processor(tmp_path: Path) -> None:
    path = put_all(tmp_path, {}, {"solver": "placo"})
    before = path.read_bytes()
    with pytest.raises(LeaderboardError, match="is of suite_checksum abab"):
        put_all(tmp_path, {"suite_checksum": "cd" * 32})
    with pytest.raises(LeaderboardError, match="has lines of a processor, and this is of another"):
        put_all(tmp_path, {"processor": "another", "robot": "panda"})
    assert path.read_bytes() == before
    path.rename(path.with_name("warm_panda.csv"))
    with pytest.raises(LeaderboardError, match=r"its lines are those of warm_nico\.csv"):
        read_boards(tmp_path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"position_mm": 10}, "is of position_mm 0, this file of 10"),
        ({"rotation_deg": 20}, "is of rotation_deg 0, this file of 20"),
        ({"shift_us": 100}, "shift_us differs between lines"),
        ({"within_1000us": 90}, "has within_10us, within_100us, this file within_10us, within_100"),
    ],
)
def test_lines_of_other_tolerances_or_limits_are_of_another_board(
    change: dict[str, Any], words: str, tmp_path: Path
) -> None:
    path = put_all(tmp_path, {})
    before = path.read_bytes()
    with pytest.raises(LeaderboardError, match=words):
        put_all(tmp_path, {"solver": "placo", **change})
    assert path.read_bytes() == before


def test_a_line_without_times_is_one(tmp_path: Path) -> None:
    times = [name for name in LINE if name.endswith("us")]
    put_all(tmp_path, {}, {"solver": "elsewhere", **dict.fromkeys(times, "")})
    placed = ranked(read_boards(tmp_path), 0.95).set_index("solver")
    assert placed["rank"].to_dict() == {"lm": 1, "elsewhere": 1}
    assert placed.time_geometric_us.isna().to_dict() == {"lm": False, "elsewhere": True}
    assert not placed.front["elsewhere"]


def test_a_column_too_many_or_a_line_twice_is_named(tmp_path: Path) -> None:
    path = put_all(tmp_path, {})
    texts = pd.read_csv(path, dtype=str, keep_default_na=False)
    pd.concat([texts, texts]).to_csv(path, index=False)
    with pytest.raises(LeaderboardError, match="has lm twice"):
        read_lines(path)
    texts.assign(more="1").to_csv(path, index=False)
    with pytest.raises(LeaderboardError, match=r"differing: \['more'\]"):
        read_lines(path)


def test_ranks_are_shared_where_intervals_overlap_and_hold_within_a_machine(tmp_path: Path) -> None:
    put_all(
        tmp_path,
        {"solver": "slow", "good": 100, "good_poses": 100, "time_geometric_us": 50.0},
        {"solver": "fast", "good": 99, "good_poses": 99},
        {"solver": "bad", "good": 50, "good_poses": 50, "within_10us": 9, "within_100us": 50},
    )
    put(tmp_path, "lap", {**LINE, "solver": "bad", "good": 50})
    placed = ranked(read_boards(tmp_path), 0.95)
    here = placed[placed.machine == "desk"].set_index("solver")
    # Wilson: 100 of 100 from 0.963; 99 of 100 from 0.946 to 0.998; 50 of 100 to 0.596.
    assert here["rank"].to_dict() == {"slow": 1, "fast": 1, "bad": 3}
    assert here.low["slow"] == pytest.approx(0.963, abs=1e-3)
    assert placed[placed.machine == "lap"]["rank"].tolist() == [1]
    assert [line["solver"] for line in overall(placed)] == ["slow", "fast", "bad", "bad"]


def test_who_is_on_few_boards_does_not_lead_over_all(tmp_path: Path) -> None:
    good = {"good": 100, "good_poses": 100}
    put_all(tmp_path, {"solver": "lm"}, {"solver": "lm", "robot": "panda"})
    put_all(tmp_path, {"solver": "placo", "robot": "panda", **good})
    found = overall(ranked(read_boards(tmp_path), 0.95))
    assert [(line["solver"], line["boards"]) for line in found] == [("lm", 2), ("placo", 1)]
    assert found[0]["mean_rank"] > found[1]["mean_rank"]


def test_the_front_has_those_that_none_beats_in_both(tmp_path: Path) -> None:
    put_all(
        tmp_path,
        {"solver": "a", "time_geometric_us": 1.0, "position_median_mm": 5.0},
        {"solver": "b", "time_geometric_us": 2.0, "position_median_mm": 6.0},
        {"solver": "c", "time_geometric_us": 3.0, "position_median_mm": 1.0},
    )
    placed = ranked(read_boards(tmp_path), 0.95).set_index("solver")
    assert placed.front.to_dict() == {"a": True, "b": False, "c": True}


def test_the_shifted_geometric_mean_by_hand() -> None:
    # sqrt((10 + 10) * (70 + 10)) - 10 = 30.
    assert shifted_geometric_mean(np.array([10.0, 70.0]), 10.0) == pytest.approx(30.0)


def test_a_machine_has_a_plain_name() -> None:
    assert machine_name("AMD EPYC 7543 32-Core Processor", 1) == "amd_epyc_7543_32_1_thread"
    assert machine_name("Intel(R) Xeon(R) Processor with NVIDIA H100", 2).endswith("_2_threads")
