"""Solvers that live outside the checkout, by module:Class and by entry point."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import baselines
from baselines import SettingError, SolverError, UnknownSolverError, outside, registry
from pipeline.config import compose
from pipeline.solvers import check_budgets, is_neural
from pipeline.stages.solvers import code_of
from robots import Robot, load_robot

SOURCE = """
from baselines import QuerySolver
from baselines.protocol import Answer

class Lazy(QuerySolver):
    def __init__(self, robot, *, gain=0.5, time_s=None, iterations=7):
        super().__init__(robot, time_s=time_s, iterations=iterations)
        self.gain = gain

    def _solve_one(self, pose, initial, clock):
        return Answer(initial, "no idea")

class Needy(QuerySolver):
    def __init__(self, robot, gain, time_s=None):
        super().__init__(robot, time_s=time_s)

    def _solve_one(self, pose, initial, clock):
        return Answer(initial, "")
"""
TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot(urdf=TWO_LINK)


@pytest.fixture
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "a_strangers_solver.py"
    path.write_text(SOURCE, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, path.stem, raising=False)
    return path


@pytest.mark.usefixtures("module")
def test_a_class_of_any_module_is_a_solver(robot: Robot) -> None:
    name = "a_strangers_solver:Lazy"
    solver = baselines.load(name, robot, gain=2.0)
    assert (solver.name, solver.settings["gain"], solver.settings["iterations"]) == (name, 2.0, 7)
    assert solver.budget == baselines.Budget(iterations=7)
    assert name not in baselines.names()
    with pytest.raises(SettingError, match="no setting 'gian'; did you mean 'gain'"):
        baselines.load(name, robot, gian=1.0)


@pytest.mark.usefixtures("module")
def test_an_entry_point_gives_it_a_name(robot: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outside, "installed", lambda: {"mine": "a_strangers_solver:Lazy"})
    assert baselines.load("mine", robot).name == "mine"
    with pytest.raises(UnknownSolverError, match="no solver 'yours'"):
        registry.settings("yours")


def test_a_name_of_conf_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outside, "installed", lambda: {"lm": "a_strangers_solver:Lazy"})
    assert registry.settings("lm")["_target_"] == "baselines.lm.LevenbergMarquardt"


@pytest.mark.usefixtures("module")
def test_what_cannot_be_loaded_says_why(robot: Robot) -> None:
    with pytest.raises(SolverError, match="settings gain have no default"):
        baselines.load("a_strangers_solver:Needy", robot)
    with pytest.raises(SolverError, match=r"cannot import a_strangers_solver.Gone"):
        baselines.load("a_strangers_solver:Gone", robot)
    with pytest.raises(SolverError, match=r"cannot import no_such_module.Lazy"):
        baselines.load("no_such_module:Lazy", robot)
    with pytest.raises(SolverError, match=r"is not a subclass of baselines.Solver"):
        baselines.load("pathlib:Path", robot)


@pytest.mark.parametrize("source", ["raise RuntimeError('no licence')", "def broken(:"])
def test_a_module_that_fails_is_named(source: str, module: Path, robot: Robot) -> None:
    module.with_name("a_broken_solver.py").write_text(source, encoding="utf-8")
    with pytest.raises(SolverError, match=r"cannot import a_broken_solver.Any: \w+Error: "):
        baselines.load("a_broken_solver:Any", robot)


def test_a_run_takes_it_and_its_rows_know_its_code(module: Path) -> None:
    name = "a_strangers_solver:Lazy"
    config = compose([f"evaluate.solvers=[{name}]", "profile=smoke"])
    assert config.evaluate.solvers == [name]
    assert not is_neural(name)
    check_budgets(config)
    before = code_of("pipeline.stages.evaluate_suite", {"solver": [name]}, config)
    module.write_text(SOURCE.replace("0.5", "0.25"), encoding="utf-8")
    assert code_of("pipeline.stages.evaluate_suite", {"solver": [name]}, config) != before
