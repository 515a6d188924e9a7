"""Benchmark and experiment pipeline for neural inverse kinematics and neuro-robotic grasping.

The public API, on which the command line stands as well:

>>> from pipeline import evaluate, load_robot, load_solver, plan_motion, run_command
>>> robot = load_robot("panda")
>>> solver = load_solver("placo", robot)
>>> solution = solver.solve(robot.forward_kinematics(robot.sample(10)))

A solver of one's own derives from `baselines.Solver` or `baselines.QuerySolver`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from baselines import Budget
    from pipeline.commands import run_command
    from pipeline.evaluating import evaluate
    from pipeline.loading import load_solver
    from pipeline.planning import plan_motion
    from robots import load_robot

__all__ = ["Budget", "evaluate", "load_robot", "load_solver", "plan_motion", "run_command"]

_HOMES = {
    "Budget": "baselines",
    "evaluate": "pipeline.evaluating",
    "load_robot": "robots",
    "load_solver": "pipeline.loading",
    "plan_motion": "pipeline.planning",
    "run_command": "pipeline.commands",
}


def __getattr__(name: str) -> Any:
    """Import a name of the API when it is first used, so that `--help` does not wait for torch."""
    if name not in _HOMES:
        raise AttributeError(f"module 'pipeline' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
