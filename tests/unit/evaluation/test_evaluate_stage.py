"""The evaluate stage refuses a solver that cannot run before it makes anything."""

import pytest

from baselines import SkippedSolver, UnknownSolverError
from pipeline.config import compose
from pipeline.stages.running import run_stage


@pytest.mark.parametrize(
    ("name", "error", "words"),
    [
        ("frankik", SkippedSolver, "'frankik' cannot run for nico: "),
        ("placco", UnknownSolverError, "did you mean 'placo'"),
    ],
)
def test_a_solver_that_cannot_run_stops_before_the_first_one(tmp_path, name, error, words):
    solvers = f"evaluate.solvers=[lm,{name}]"
    config = compose(["robot=nico", "profile=smoke", solvers, f"results_dir={tmp_path}"])
    with pytest.raises(error, match=words):
        run_stage("evaluate", config)
    assert not list(tmp_path.iterdir())
