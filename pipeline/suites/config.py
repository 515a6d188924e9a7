"""Types of `conf/suite`: a class for each generator, checked when it is made."""

from __future__ import annotations

import re
from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive, positive_all, within
from pipeline.errors import ConfigError

# Generators that are judged in their own way: by a true "no", by whole trajectories, in which the
# size of the second is counted as well, under freedoms, and by what is free of collision.
UNREACHABLE, TRACKING = "unreachable", "tracking"
PARTIAL, CLUTTERED = "partial", "cluttered"


@dataclass
class SuiteConfig:
    """What every suite has: its name, who generates it, its version, and its size by profile."""

    name: str = MISSING
    generator: str = MISSING
    version: int = MISSING
    poses: int = MISSING
    trajectories: int = MISSING

    def __post_init__(self) -> None:
        """Refuse empty suites, versions that are none, and names that are no plain word."""
        if not re.fullmatch(r"[a-z]\w*", self.name):
            raise ConfigError(
                f"suite.name is a plain word, the name of its files, not {self.name!r}"
            )
        for key in ("version", "poses", "trajectories"):
            positive(f"suite.{key}", getattr(self, key))


@dataclass
class AtLimitsConfig(SuiteConfig):
    """Several joints near one of their limits."""

    margin: float = MISSING
    most_joints: int = MISSING

    def __post_init__(self) -> None:
        """Refuse margins that are no share of a range, and fewer than two joints."""
        super().__post_init__()
        within("suite.margin", self.margin, 0.0, 0.5)
        at_least("suite.most_joints", self.most_joints, 2)


@dataclass
class ShareConfig(SuiteConfig):
    """The outermost share of something that is measured on a reference sample."""

    share: float = MISSING
    reference: int = MISSING

    def __post_init__(self) -> None:
        """Refuse shares that are none, and a reference that tells nothing."""
        super().__post_init__()
        within("suite.share", self.share, 0.001, 0.5)
        at_least("suite.reference", self.reference, 100)


@dataclass
class UnreachableConfig(ShareConfig):
    """Poses that no configuration reaches: too far, or of an impossible orientation."""

    beyond_mm: list[float] = MISSING
    search_starts: int = MISSING
    search_position_mm: float = MISSING
    search_rotation_deg: float = MISSING

    def __post_init__(self) -> None:
        """Refuse distances within reach, and a search of nothing."""
        super().__post_init__()
        positive_all("suite.beyond_mm", self.beyond_mm)
        for key in ("search_starts", "search_position_mm", "search_rotation_deg"):
            positive(f"suite.{key}", getattr(self, key))


@dataclass
class WarmConfig(SuiteConfig):
    """Targets near a start that the solver is given."""

    offsets_deg: list[float] = MISSING

    def __post_init__(self) -> None:
        """Refuse a start that is the answer already."""
        super().__post_init__()
        positive_all("suite.offsets_deg", self.offsets_deg)


@dataclass
class TrackingConfig(ShareConfig):
    """Smooth trajectories that a continuous solution is known to."""

    rates_hz: list[float] = MISSING
    duration_s: float = MISSING
    speed: float = MISSING
    default_velocity: float = MISSING

    def __post_init__(self) -> None:
        """Refuse rates, times and speeds at which nothing moves."""
        super().__post_init__()
        positive_all("suite.rates_hz", self.rates_hz)
        positive("suite.duration_s", self.duration_s)
        within("suite.speed", self.speed, 0.001, 1.0)
        positive("suite.default_velocity", self.default_velocity)


@dataclass
class PartialConfig(SuiteConfig):
    """Targets of which a part is free."""

    axis: str = MISSING

    def __post_init__(self) -> None:
        """Refuse axes that the tip has not."""
        super().__post_init__()
        one_of("suite.axis", self.axis, ("x", "y", "z"))


@dataclass
class ClutteredConfig(SuiteConfig):
    """Obstacles around a configuration that is known to be free."""

    clearances_mm: list[float] = MISSING
    requested: float = MISSING
    obstacles: int = MISSING
    blocking: int = MISSING
    half_size_mm: list[float] = MISSING

    def __post_init__(self) -> None:
        """Refuse clearances that are none, and obstacles without a size."""
        super().__post_init__()
        positive_all("suite.clearances_mm", self.clearances_mm)
        within("suite.requested", self.requested, 0.0, 1.0)
        positive("suite.obstacles", self.obstacles)
        within("suite.blocking", self.blocking, 0, self.obstacles)
        positive_all("suite.half_size_mm", self.half_size_mm)
        if len(self.half_size_mm) != 2 or self.half_size_mm[0] > self.half_size_mm[1]:
            raise ConfigError(
                f"suite.half_size_mm is [least, largest], not {list(self.half_size_mm)}"
            )


CLASSES: dict[str, type[SuiteConfig]] = {
    "uniform": SuiteConfig,
    "at_limits": AtLimitsConfig,
    "near_singular": ShareConfig,
    "boundary": ShareConfig,
    UNREACHABLE: UnreachableConfig,
    "warm": WarmConfig,
    TRACKING: TrackingConfig,
    PARTIAL: PartialConfig,
    CLUTTERED: ClutteredConfig,
}


def suite_class(generator: str) -> type[SuiteConfig]:
    """Return the class of the configuration of a generator.

    Raises:
        ValueError: There is no such generator.
    """
    one_of("suite.generator", generator, CLASSES)
    return CLASSES[generator]
