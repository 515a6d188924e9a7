"""Types of the `grasp` group; conf/grasp owns the values and comments every key with its unit."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from omegaconf import MISSING

from pipeline.checks import at_least, interval, one_of, positive, positive_all, within
from pipeline.planning.config import MotionConfig, TimingConfig

SHAPES = ("sphere", "capsule", "cylinder", "box")
VIDEOS = ("none", "first", "classes", "all")
AXES = (
    "solver",
    "position_error",
    "tension_scale",
    "friction_scale",
    "rate",
    "iterations",
    "noise_seed",
    "zero_offset",
    "backlash",
    "mass_spread",
)
MOTIONS = ("approach", "lift", "transfer", "deposit", "homeward", "push")
ONE_MOTION, TWO_MOTIONS = "one_motion", "two_motions"  # from the table into the bin
DRAWN, PINNED = "drawn", "pinned"  # from the seed, or from a committed file
EVIDENCE = ("failures", "all", "none")


@dataclass
class PhysicsConfig:
    """The physics engine and its accuracy."""

    rate: float = MISSING  # Hz
    iterations: int = MISSING
    settle_s: float = MISSING
    placement_noise: float = MISSING  # m
    noise_seed: int = MISSING

    def __post_init__(self) -> None:
        """Refuse coarse physics: what is held would then depend on the step."""
        at_least("grasp.physics.rate", self.rate, 60)
        at_least("grasp.physics.iterations", self.iterations, 10)
        at_least("grasp.physics.settle_s", self.settle_s, 0)
        at_least("grasp.physics.placement_noise", self.placement_noise, 0)
        at_least("grasp.physics.noise_seed", self.noise_seed, 0)


@dataclass
class HardwareConfig:
    """Errors that a real robot has and a simulated one lacks."""

    zero_offset: float = MISSING  # rad
    backlash: float = MISSING  # rad
    mass_spread: float = MISSING

    def __post_init__(self) -> None:
        """Refuse errors of a negative size."""
        for name in ("zero_offset", "backlash", "mass_spread"):
            at_least(f"grasp.hardware.{name}", getattr(self, name), 0)


@dataclass
class PartConfig:
    """One primitive of an object."""

    shape: str = MISSING
    size: list[float] = MISSING  # m: radius | radius, length | radius, length | x, y, z
    position: list[float] = MISSING  # m, object frame
    rotation: list[float] = MISSING  # deg, roll pitch yaw, object frame
    colour: list[float] = MISSING  # red, green, blue, alpha

    def __post_init__(self) -> None:
        """Refuse unknown shapes and a size that does not fit the shape."""
        one_of("grasp.objects: shape", self.shape, SHAPES)
        numbers = {"sphere": 1, "capsule": 2, "cylinder": 2, "box": 3}
        if self.shape in numbers and len(self.size) != numbers[self.shape]:
            raise ValueError(
                f"grasp.objects: the size of a {self.shape} has {numbers[self.shape]} numbers [m], "
                f"got {list(self.size)}"
            )


@dataclass
class ObjectConfig:
    """An object to grasp, built from primitives."""

    mass: float = MISSING  # kg
    friction: float = MISSING
    rolling_friction: float = MISSING
    spinning_friction: float = MISSING
    stiffness: float | None = None  # N/m
    damping: float | None = None  # N s/m
    height: float = MISSING  # m
    yaw: float | None = None  # deg
    parts: list[PartConfig] = MISSING

    def __post_init__(self) -> None:
        """Refuse objects without mass or size."""
        positive("grasp.objects: mass", self.mass)
        positive("grasp.objects: height", self.height)
        at_least("grasp.objects: friction", self.friction, 0)
        if (self.stiffness is None) != (self.damping is None):
            raise ValueError("grasp.objects: give stiffness and damping both, or neither")


@dataclass
class TableConfig:
    """The table; without a size the robot's own description has it."""

    height: float = MISSING  # m, base frame
    centre: list[float] | None = None  # m
    size: list[float] | None = None  # m
    friction: float = MISSING
    rolling_friction: float | None = None  # m


@dataclass
class BinConfig:
    """An open box."""

    centre: list[float] = MISSING  # m, base frame
    size: list[float] = MISSING  # m, outside
    floor: float = MISSING  # m, base frame
    wall: float = MISSING  # m
    drop: list[float] | None = None  # m, where to let go; the centre if not given

    def __post_init__(self) -> None:
        """Refuse boxes without a hollow."""
        if isinstance(self.wall, float):
            positive("grasp.scenes: bins: wall", self.wall)
            within("grasp.scenes: bins: wall", self.wall, 0.0, min(self.size[:2]) / 2)


@dataclass
class AreaConfig:
    """Where objects are laid: rows in depth, spread over the width."""

    x: list[float] = MISSING  # m, from and to
    y: list[float] = MISSING  # m, from and to
    row_step: float = MISSING  # m

    def __post_init__(self) -> None:
        """Refuse areas whose ends are swapped."""
        interval("grasp.scenes: area.x", self.x)
        interval("grasp.scenes: area.y", self.y)
        positive("grasp.scenes: area.row_step", self.row_step)


@dataclass
class GripConfig:
    """How the hand comes to an object."""

    rotation: list[float] = MISSING  # deg, roll pitch yaw of the tip at yaw 0
    pivot: list[float] | None = None  # m
    closing: float = MISSING  # deg
    tilts: list[float] = MISSING  # deg
    yaws: list[float] = MISSING  # deg
    release_yaws: list[float] = MISSING  # deg
    ready: list[float] | None = None  # m
    scale: float = MISSING
    offset: list[float] = MISSING  # m
    floor: float = MISSING  # m
    depth: float = MISSING  # m
    tolerance: float = MISSING  # m
    search_iterations: int = MISSING
    lift: float = MISSING  # m
    release: float = MISSING  # m


@dataclass
class HandConfig:
    """How the fingers move."""

    tension: float = MISSING  # N
    speed: float = MISSING  # rad/s or m/s
    ratios: list[float] = MISSING
    preshape: dict[str, float] = field(default_factory=dict)  # rad
    drive_inertia: float = MISSING  # kg m^2
    friction: float = MISSING
    close_s: float = MISSING  # s
    stall_speed: float = MISSING  # rad/s or m/s
    stall_s: float = MISSING  # s
    open_s: float = MISSING  # s
    shake: float = MISSING  # rad

    def __post_init__(self) -> None:
        """Refuse hands that push."""
        at_least("grasp.scenes: hand.tension", self.tension, 0)
        at_least("grasp.scenes: hand.speed", self.speed, 0)
        at_least("grasp.scenes: hand.shake", self.shake, 0)
        at_least("grasp.scenes: hand.drive_inertia", self.drive_inertia, 0)


@dataclass
class PushConfig:
    """How the closed hand pushes an object over the table."""

    stand_off: float = MISSING  # m
    distance: float = MISSING  # m
    height: float = MISSING  # m
    directions: list[float] = MISSING  # deg
    yaws: list[float] = MISSING  # deg
    tilts: list[float] = MISSING  # deg
    min_displacement: float = MISSING  # m

    def __post_init__(self) -> None:
        """Refuse pushes that go nowhere."""
        for name in ("stand_off", "distance", "min_displacement"):
            positive(f"grasp.scenes: push.{name}", getattr(self, name))
        at_least("grasp.scenes: push.height", self.height, 0)
        if not (self.directions and self.yaws and self.tilts):
            raise ValueError(
                "grasp.scenes: push needs a direction, a yaw and a tilt [deg] at least"
            )


@dataclass
class PointConfig:
    """How the hand points at an object."""

    distances: list[float] = MISSING  # m
    yaws: list[float] = MISSING  # deg
    tilts: list[float] = MISSING  # deg
    stretched: list[str] = MISSING
    hold_s: float = MISSING  # s
    beside: float = MISSING  # m

    def __post_init__(self) -> None:
        """Refuse gestures without a direction to point in."""
        positive_all("grasp.scenes: point.distances", self.distances)
        if not self.yaws or not self.tilts:
            raise ValueError("grasp.scenes: point needs at least one yaw and one tilt [deg]")
        at_least("grasp.scenes: point.hold_s", self.hold_s, 0)
        positive("grasp.scenes: point.beside", self.beside)


@dataclass
class CloseupConfig:
    """The second camera, which follows the hand; its picture lies beside that of the first."""

    distance: float = MISSING  # m
    yaw: float = MISSING  # deg


@dataclass
class CameraConfig:
    """The camera of the videos."""

    target: list[float] = MISSING  # m, base frame
    distance: float = MISSING  # m
    yaw: float = MISSING  # deg
    pitch: float = MISSING  # deg
    closeup: CloseupConfig = field(default_factory=CloseupConfig)


@dataclass
class SceneConfig:
    """A robot's table, bins, objects and grip."""

    objects: list[str] = MISSING
    table: TableConfig = field(default_factory=TableConfig)
    bins: dict[str, BinConfig] = MISSING
    area: AreaConfig = field(default_factory=AreaConfig)
    grip: GripConfig = field(default_factory=GripConfig)
    hand: HandConfig = field(default_factory=HandConfig)
    push: PushConfig = field(default_factory=PushConfig)
    point: PointConfig = field(default_factory=PointConfig)
    camera: CameraConfig = field(default_factory=CameraConfig)

    def __post_init__(self) -> None:
        """Refuse a scene with nothing to grasp."""
        if not self.objects:
            raise ValueError("grasp.scenes: objects must name at least one object, got none")


@dataclass
class AblationConfig:
    """A study: the same trials for every combination of some settings' values."""

    study: str = MISSING
    vary: dict[str, list[Any]] = MISSING

    def __post_init__(self) -> None:
        """Refuse settings that cannot be varied, and axes without values."""
        if isinstance(self.vary, dict):
            for name, values in self.vary.items():
                one_of("grasp.ablation.vary", name, AXES)
                if not values:
                    raise ValueError(f"grasp.ablation.vary.{name} needs at least one value")


@dataclass
class VideoConfig:
    """Size and speed of the videos."""

    width: int = MISSING  # pixels
    height: int = MISSING  # pixels
    rate: float = MISSING  # Hz, of the simulated time
    closeup: int = MISSING  # pixels
    gif_width: int = MISSING  # pixels
    gif_rate: float = MISSING  # Hz, of the simulated time

    def __post_init__(self) -> None:
        """Refuse pictures without pixels and films without pictures."""
        for name in ("width", "height", "rate", "gif_rate"):
            positive(f"grasp.recording.{name}", getattr(self, name))
        for name in ("closeup", "gif_width"):
            at_least(f"grasp.recording.{name}", getattr(self, name), 0)


@dataclass
class ProtocolConfig:
    """Rows of objects, the sentence that starts them, and what counts as seen."""

    sentence: str = MISSING
    attempts: int = MISSING
    gap: float = MISSING  # m
    widest_gap: float | None = None  # m
    located: float = MISSING  # m
    bin_margin: float = MISSING  # m
    evidence: str = MISSING

    def __post_init__(self) -> None:
        """Refuse a protocol without a sentence, or that takes anything for seen."""
        if not self.sentence.strip():
            raise ValueError("grasp.protocol.sentence must not be empty")
        positive("grasp.protocol.attempts", self.attempts)
        at_least("grasp.protocol.gap", self.gap, 0)
        if self.widest_gap is not None:
            at_least("grasp.protocol.widest_gap", self.widest_gap, self.gap)
        positive("grasp.protocol.located", self.located)
        at_least("grasp.protocol.bin_margin", self.bin_margin, 0)
        one_of("grasp.protocol.evidence", self.evidence, EVIDENCE)


@dataclass
class GraspConfig:
    """The grasp experiment."""

    trials: int = MISSING
    placements: str = MISSING
    solver: str = MISSING
    repair: str | None = None
    carry: str = MISSING
    shake_after_lift: float = MISSING  # rad
    detour: bool = MISSING
    gui: bool = MISSING
    video: str = MISSING
    position_error: float = MISSING  # m
    tension_scale: float = MISSING
    friction_scale: float = MISSING
    lift_threshold: float = MISSING  # m
    ablation: AblationConfig | None = None
    physics: PhysicsConfig = field(default_factory=PhysicsConfig)
    hardware: HardwareConfig = field(default_factory=HardwareConfig)
    timing: TimingConfig = field(default_factory=TimingConfig)
    motions: dict[str, MotionConfig] = MISSING
    recording: VideoConfig = field(default_factory=VideoConfig)
    protocol: ProtocolConfig = field(default_factory=ProtocolConfig)
    objects: dict[str, ObjectConfig] = MISSING
    scenes: dict[str, SceneConfig] = MISSING

    def __post_init__(self) -> None:
        """Refuse an experiment without trials, unknown objects and missing motions."""
        positive("grasp.trials", self.trials)
        for name in ("position_error", "tension_scale", "friction_scale"):
            at_least(f"grasp.{name}", getattr(self, name), 0)
        one_of("grasp.placements", self.placements, (DRAWN, PINNED))
        one_of("grasp.video", self.video, VIDEOS)
        one_of("grasp.carry", self.carry, (ONE_MOTION, TWO_MOTIONS))
        at_least("grasp.shake_after_lift", self.shake_after_lift, 0)
        if self.carry == ONE_MOTION and self.shake_after_lift:
            raise ValueError(
                f"grasp.shake_after_lift needs a lift that ends: grasp.carry={TWO_MOTIONS}"
            )
        if isinstance(self.motions, dict) and set(self.motions) != set(MOTIONS):
            raise ValueError(f"grasp.motions must be {', '.join(MOTIONS)}, got {[*self.motions]}")
        if isinstance(self.scenes, dict) and isinstance(self.objects, dict):
            for robot, scene in self.scenes.items():
                for name in scene.objects:
                    one_of(f"grasp.scenes.{robot}.objects", name, sorted(self.objects))

    def solvers_by_key(self) -> dict[str, list[str]]:
        """Return the names of the solvers that a run loads, by the key that names them."""
        varied = self.ablation.vary.get("solver", []) if self.ablation is not None else []
        return {
            "grasp.solver": [self.solver],
            "grasp.repair": [self.repair] if self.repair else [],
            "grasp.ablation.vary.solver": [str(name) for name in varied],
        }
