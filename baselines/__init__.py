"""Inverse-kinematics solvers that are not neural, behind one protocol.

>>> from robots import load_robot
>>> import baselines
>>> solver = baselines.load("lm", load_robot("panda"))
>>> solution = solver.solve(poses)  # poses (N, 7)
"""

from baselines.errors import (
    BudgetError,
    InitialError,
    PoseError,
    SettingError,
    SkippedSolver,
    SolverError,
    UnknownSolverError,
)
from baselines.protocol import Budget, QuerySolver, Solution, Solver
from baselines.registry import load, names, skip

__all__ = [
    "Budget",
    "BudgetError",
    "InitialError",
    "PoseError",
    "QuerySolver",
    "SettingError",
    "SkippedSolver",
    "Solution",
    "Solver",
    "SolverError",
    "UnknownSolverError",
    "load",
    "names",
    "skip",
]
