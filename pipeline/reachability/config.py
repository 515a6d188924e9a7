"""Type of `conf/reach`: how finely places and orientations are asked for."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from baselines import Freedom
from pipeline.checks import one_of, positive

FREEDOMS = {
    "pose": Freedom(),
    "position": Freedom.position_only(),
    **{axis: Freedom.free_about(axis) for axis in "xyz"},
}


@dataclass
class ReachConfig:
    """Grid, orientations, and what answers."""

    solver: str = MISSING
    spacing_m: float = MISSING
    orientations: int = MISSING
    freedom: str = MISSING
    iterations: int = MISSING
    chunk: int = MISSING

    def __post_init__(self) -> None:
        """Refuse grids of nothing, and a search of nothing."""
        one_of("reach.freedom", self.freedom, FREEDOMS)
        for name in ("spacing_m", "orientations", "iterations", "chunk"):
            positive(f"reach.{name}", getattr(self, name))

    def solvers_by_key(self) -> dict[str, list[str]]:
        """Return the names of the solvers that a run loads, by the key that names them."""
        return {"reach.solver": [self.solver]}
