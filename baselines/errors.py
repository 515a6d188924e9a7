"""Errors that a user of the solvers can meet; each says what was expected and what came."""


class SolverError(ValueError):
    """A solver was asked for something that it cannot do; base of all errors of this package."""


class UnknownSolverError(SolverError):
    """No solver of that name is registered."""


class SettingError(SolverError):
    """A setting of a solver is unknown, of the wrong type or has an impossible value."""


class PoseError(SolverError):
    """Target poses that are not finite, not of shape (N, 7) or whose quaternion is not unit."""


class InitialError(SolverError):
    """An initial guess that is not finite or has the wrong shape."""


class BudgetError(SolverError):
    """A budget that is empty, not positive or of a kind that the solver does not take."""


class FreedomError(SolverError):
    """Freedoms of a target that are no widths, or do not fit the poses."""


class AbilityError(SolverError):
    """A solver was asked for what only others can do; `Solver.lacks` says so beforehand."""


class SkippedSolver(SolverError):  # noqa: N818 - it is a state of the machine, not a fault
    """The solver cannot run here: a package is missing, or it does not know this robot."""
