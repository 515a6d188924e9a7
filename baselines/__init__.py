"""Inverse-kinematics solvers that are not neural, behind one protocol.

>>> from robots import load_robot
>>> import baselines
>>> solver = baselines.load("lm", load_robot("panda"))
>>> solution = solver.solve(poses)  # poses (N, 7)
"""

from robots.compiled_cache import use_own_folder

use_own_folder("baselines", "robots")  # before the imports below declare compiled functions

from baselines.errors import (  # noqa: E402
    AbilityError,
    BudgetError,
    FreedomError,
    InitialError,
    PoseError,
    SettingError,
    SkippedSolver,
    SolverError,
    UnknownSolverError,
)
from baselines.explanation import Explanation  # noqa: E402
from baselines.freedom import Freedom  # noqa: E402
from baselines.protocol import Answer, Budget, Clock, QuerySolver, Solution, Solver  # noqa: E402
from baselines.registry import load, names, skip  # noqa: E402

__all__ = [
    "AbilityError",
    "Answer",
    "Budget",
    "BudgetError",
    "Clock",
    "Explanation",
    "Freedom",
    "FreedomError",
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
