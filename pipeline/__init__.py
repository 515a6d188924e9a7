"""Benchmark and experiment pipeline for neural inverse kinematics and neuro-robotic grasping.

The public API, on which the command line stands as well:

>>> from pipeline import load_robot, load_solver, plan_motion
>>> robot = load_robot("panda")
>>> solver = load_solver("placo", robot)
>>> solution = solver.solve(robot.forward_kinematics(robot.sample(10)))
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from baselines import Budget
    from pipeline.loading import load_solver
    from pipeline.planning import plan_motion
    from robots import load_robot

__all__ = ["Budget", "load_robot", "load_solver", "plan_motion"]

_HOMES = {
    "Budget": "baselines",
    "load_robot": "robots",
    "load_solver": "pipeline.loading",
    "plan_motion": "pipeline.planning",
}


def __getattr__(name: str) -> Any:
    """Import a name of the API when it is first used, so that `--help` does not wait for torch."""
    if name not in _HOMES:
        raise AttributeError(f"module 'pipeline' has no attribute '{name}'")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
