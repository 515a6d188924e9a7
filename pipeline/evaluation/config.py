"""Types of `conf/evaluate`: what is solved, how often, what counts as what; names in the rows."""

from __future__ import annotations

from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive, positive_all, within

NOT_FOUND_POLICIES = ("idle", "nan")
UNPINNED = "_unpinned"  # ends the name of a solver in rows that were not measured on pinned cores
HOME = "home"  # the initial guess that is no solver's answer


@dataclass
class Tolerance:
    """How far off a pose may be and still count as reached; both bounds are exclusive."""

    position_mm: float = MISSING
    rotation_deg: float = MISSING

    def __post_init__(self) -> None:
        """Refuse tolerances that nothing could meet."""
        positive("position_mm of a tolerance", self.position_mm)
        positive("rotation_deg of a tolerance", self.rotation_deg)


@dataclass
class EvaluateConfig:
    """Solvers, their budget, and how time is taken."""

    solvers: list[str] = MISSING
    seeded_by: str = MISSING
    poses: int = MISSING
    time_s: float | None = MISSING
    time_factor: dict[str, float] = MISSING
    iterations: int | None = MISSING
    not_found: str = MISSING
    claim: Tolerance = field(default_factory=Tolerance)
    limit_slack: float = MISSING
    batch_sizes: list[int] = MISSING
    error_batch_size: dict[str, int] = MISSING
    trajectories: int = MISSING
    latency_poses: int = MISSING
    warm_up: int = MISSING
    threads: int = MISSING
    pinned: bool = MISSING
    first_core: int = MISSING
    side_by_side: int = MISSING
    keep: bool = MISSING
    chunk: int = MISSING

    def __post_init__(self) -> None:
        """Refuse empty runs, budgets and batches that are not possible."""
        one_of("evaluate.not_found", self.not_found, NOT_FOUND_POLICIES)
        at_least("evaluate.poses", self.poses, 0)
        if self.time_s is not None:
            positive("evaluate.time_s", self.time_s)
        if isinstance(self.time_factor, dict) and self.time_factor:
            positive_all("evaluate.time_factor", list(self.time_factor.values()))
        if self.iterations is not None:
            positive("evaluate.iterations", self.iterations)
        positive_all("evaluate.batch_sizes", self.batch_sizes)
        if isinstance(self.error_batch_size, dict) and self.error_batch_size:
            positive_all("evaluate.error_batch_size", list(self.error_batch_size.values()))
        at_least("evaluate.trajectories", self.trajectories, 0)
        at_least("evaluate.limit_slack", self.limit_slack, 0)
        at_least("evaluate.warm_up", self.warm_up, 0)
        at_least("evaluate.first_core", self.first_core, 0)
        for name in ("latency_poses", "threads", "side_by_side", "chunk"):
            positive(f"evaluate.{name}", getattr(self, name))
        if not isinstance(self.solvers, str) and not self.solvers:
            raise ValueError("evaluate.solvers must name at least one solver")

    def solvers_by_key(self) -> dict[str, list[str]]:
        """Return the names of the solvers that a run loads, by the key that names them."""
        seeders = [] if self.seeded_by == HOME else [self.seeded_by]
        return {"evaluate.solvers": list(self.solvers), "evaluate.seeded_by": seeders}

    def time_of(self, solver: str) -> float | None:
        """Return the seconds a pose that a solver is given, None where the clock stops nobody."""
        return None if self.time_s is None else self.time_s * self.time_factor.get(solver, 1.0)


@dataclass
class SampleConfig:
    """Many solutions of one pose, by a solver that draws."""

    solver: str = MISSING
    poses: int = MISSING
    samples: int = MISSING
    references: int = MISSING
    seed: int = MISSING
    postures: int = MISSING
    pictured: int = MISSING

    def __post_init__(self) -> None:
        """Refuse samples too few to spread, and a picture of what is not there."""
        positive("sample.poses", self.poses)
        at_least("sample.samples", self.samples, 2)
        at_least("sample.references", self.references, 0)
        at_least("sample.seed", self.seed, 0)
        at_least("sample.postures", self.postures, 0)
        at_least("sample.pictured", self.pictured, 0)
        numbers = (self.postures, self.samples, self.pictured, self.poses)
        if all(isinstance(number, int) for number in numbers):
            within("sample.postures", self.postures, 0, self.samples)
            within("sample.pictured", self.pictured, 0, self.poses - 1)

    def solvers_by_key(self) -> dict[str, list[str]]:
        """Return the names of the solvers that a run loads, by the key that names them."""
        return {"sample.solver": [self.solver]}


def row_name(solver: str, pinned: bool) -> str:
    """Return the name of a solver in the rows: one that used all cores is a solver of its own."""
    return solver if pinned else f"{solver}{UNPINNED}"


def solver_of_rows(name: str) -> str:
    """Return the solver behind a name in the rows."""
    return name.removesuffix(UNPINNED)
