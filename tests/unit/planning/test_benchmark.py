"""The planner benchmark: a killed one goes on, and its figures show every solver."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.colors import to_hex

import baselines
from pipeline.config import compose
from pipeline.data.rows import RowCheckpoint
from pipeline.planning import benchmark as module
from pipeline.planning.benchmark import KEY, benchmark, plan_pair, random_pairs
from pipeline.planning.figures import _joint_figure, write_figures
from robots import load_robot

CONFIG = replace(compose(["profile=smoke"]).plan, pairs=3)


def test_a_killed_benchmark_plans_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = load_robot("panda")
    solvers = {"lm": baselines.load("lm", robot)}
    planned = []

    def plan(*arguments):
        planned.append(arguments[2])
        if len(planned) == 4:  # one to warm up, two that are kept
            raise KeyboardInterrupt
        return plan_pair(*arguments)

    monkeypatch.setattr(module, "plan_pair", plan)
    path = tmp_path / "rows.jsonl"
    with pytest.raises(KeyboardInterrupt):
        benchmark(robot, solvers, CONFIG, 0, RowCheckpoint(path, KEY))
    first = path.read_text()
    assert first.count("\n") == 2
    rows = benchmark(robot, solvers, CONFIG, 0, RowCheckpoint(path, KEY))
    assert len(planned) == 4 + 2
    assert list(rows["pair"]) == [0, 1, 2]
    assert path.read_text().startswith(first)
    benchmark(robot, solvers, CONFIG, 0, RowCheckpoint(path, KEY))
    assert len(planned) == 6


def test_figures_show_more_solvers_than_there_are_looks_for(tmp_path: Path) -> None:
    robot = load_robot("panda")
    pair = random_pairs(robot, 1, seed=0)[0]
    motion = plan_pair(robot, baselines.load("lm", robot), pair, CONFIG, None)
    motions = {f"solver{i}": motion for i in range(16)}
    lines = _joint_figure(robot, motions).axes[0].get_lines()
    assert [line.get_label() for line in lines] == list(motions)
    assert len({to_hex(line.get_color()) for line in lines}) > 10
    write_figures(robot, pair, {"lm": motion}, CONFIG, tmp_path)
    assert {"path.png", "joints.png"} <= {path.name for path in tmp_path.iterdir()}
