"""Types of the `perception` group; conf/perception owns the values."""

from __future__ import annotations

from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive, within

SOURCES = ("perfect", "camera")
DETECTORS = ("embedded", "open_vocabulary")


@dataclass
class EyeConfig:
    """How the simulated eye renders; its mount and lens stand in the robot's robot.yaml."""

    near: float = MISSING  # m
    far: float = MISSING  # m
    light: list[float] = MISSING  # direction to the light, base frame
    ambient: float = MISSING  # share of full light
    diffuse: float = MISSING  # share of full light
    specular: float = MISSING  # share of full light
    shadow: bool = MISSING
    background: list[int] = MISSING  # red, green, blue, 0 to 255

    def __post_init__(self) -> None:
        """Refuse lenses that see nothing and lights without a direction."""
        positive("perception.eye.near", self.near)
        if isinstance(self.far, float) and isinstance(self.near, float) and self.far <= self.near:
            raise ValueError(
                f"perception.eye.far must lie beyond near ({self.near}), got {self.far}"
            )
        three("perception.eye.light", self.light)
        three("perception.eye.background", self.background)
        for name in ("ambient", "diffuse", "specular"):
            at_least(f"perception.eye.{name}", getattr(self, name), 0)


@dataclass
class PerturbationConfig:
    """What is wrong with camera and scene, unknown to the robot."""

    tilt: list[float] = MISSING  # deg, roll pitch yaw in the camera's frame
    shift: list[float] = MISSING  # m, x y z in the camera's frame
    lighting: float = MISSING  # 0 as in `eye`, 1 half the light from the other side
    distractors: int = MISSING

    def __post_init__(self) -> None:
        """Refuse anything but three angles, three lengths, a share and a number."""
        three("perception.perturbation.tilt", self.tilt)
        three("perception.perturbation.shift", self.shift)
        within("perception.perturbation.lighting", self.lighting, 0.0, 1.0)
        at_least("perception.perturbation.distractors", self.distractors, 0)


@dataclass
class OpenVocabularyConfig:
    """An open-vocabulary detector from a folder of the user's."""

    model: str | None = None
    prompt: str = MISSING

    def __post_init__(self) -> None:
        """Refuse a prompt that says every class alike."""
        if self.prompt != MISSING and "{name}" not in self.prompt:
            raise ValueError(
                f"perception.vocabulary.prompt must hold {{name}}, got '{self.prompt}'"
            )


@dataclass
class PerceptionConfig:
    """Where the places of things come from."""

    source: str = MISSING
    detector: str = MISSING
    weights: str | None = None
    threshold: float = MISSING
    eye: EyeConfig = field(default_factory=EyeConfig)
    perturbation: PerturbationConfig = field(default_factory=PerturbationConfig)
    vocabulary: OpenVocabularyConfig = field(default_factory=OpenVocabularyConfig)

    def __post_init__(self) -> None:
        """Refuse unknown sources and detectors."""
        one_of("perception.source", self.source, SOURCES)
        one_of("perception.detector", self.detector, DETECTORS)
        within("perception.threshold", self.threshold, 0.0, 1.0)


def three(key: str, values: list[float] | list[int]) -> None:
    """Refuse anything but three numbers; a value still missing passes."""
    if not isinstance(values, str) and len(values) != 3:
        raise ValueError(f"{key} must be three numbers, got {list(values)}")
