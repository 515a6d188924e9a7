"""Types of the `plan` and `motion` groups; conf/plan and conf/motion own the values."""

from __future__ import annotations

from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.checks import at_least, positive, within


@dataclass
class MotionConfig:
    """How the control points of one kind of motion are placed, see `control_points`."""

    name: str = MISSING
    leave_height: float = MISSING  # m above the start
    leave_repeat: int = MISSING
    arrive_height: float = MISSING  # m above the target
    arrive_repeat: int = MISSING
    steps: int = MISSING
    reroute: bool = MISSING

    def __post_init__(self) -> None:
        """Refuse negative heights and paths of fewer than two poses."""
        for name in ("leave_height", "arrive_height", "leave_repeat", "arrive_repeat"):
            at_least(f"motion.{name}", getattr(self, name), 0)
        at_least("motion.steps", self.steps, 2)


@dataclass
class TimingConfig:
    """How a path of joints becomes a trajectory in time."""

    speed: float = MISSING  # share of the velocity limits
    swing: float = MISSING  # share of the velocity limits, from joints to joints
    velocity_cap: float = MISSING  # rad/s or m/s
    rate: float = MISSING  # Hz
    pause_s: float = MISSING  # s at rest after a motion
    max_duration_s: float = MISSING  # s

    def __post_init__(self) -> None:
        """Refuse speeds beyond the limits."""
        for name in ("speed", "swing"):
            positive(f"timing.{name}", getattr(self, name))
            within(f"timing.{name}", getattr(self, name), 0.0, 1.0)
        positive("timing.velocity_cap", self.velocity_cap)
        positive("timing.rate", self.rate)
        at_least("timing.pause_s", self.pause_s, 0)
        positive("timing.max_duration_s", self.max_duration_s)


@dataclass
class PlanConfig:
    """The planner benchmark: random start-target pairs, several solvers."""

    pairs: int = MISSING
    solvers: list[str] = MISSING
    repair: str | None = None
    time_s: float = MISSING  # s per waypoint
    threads: int = MISSING
    motion: MotionConfig = field(default_factory=MotionConfig)
    figure: MotionConfig = field(default_factory=MotionConfig)
    timing: TimingConfig = field(default_factory=TimingConfig)

    def __post_init__(self) -> None:
        """Refuse an empty benchmark."""
        positive("plan.pairs", self.pairs)
        positive("plan.time_s", self.time_s)
        positive("plan.threads", self.threads)
        if not self.solvers:
            raise ValueError("plan.solvers must name at least one solver, got none")

    def solvers_by_key(self) -> dict[str, list[str]]:
        """Return the names of the solvers that a run loads, by the key that names them."""
        repair = [self.repair] if self.repair else []
        return {"plan.solvers": list(self.solvers), "plan.repair": repair}
