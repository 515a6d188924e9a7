"""Types of `conf/export`."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive, within

PRECISIONS = ("float64", "float32")
OPSETS = (20, 23)  # the oldest with all operators that are used, and the newest tried


@dataclass
class ExportConfig:
    """How a file is written, and what of it is checked; see conf/export/default.yaml."""

    precision: str = MISSING
    opset: int = MISSING
    poses: int = MISSING
    largest_rad: float = MISSING
    tie: float = MISSING

    def __post_init__(self) -> None:
        """Refuse precisions and operators that there are none of."""
        one_of("export.precision", self.precision, PRECISIONS)
        within("export.opset", self.opset, *OPSETS)
        at_least("export.poses", self.poses, 0)
        positive("export.largest_rad", self.largest_rad)
        positive("export.tie", self.tie)
