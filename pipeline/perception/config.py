"""Types of the groups `perception` and `detector`; their folders in conf/ own the values."""

from __future__ import annotations

from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.checks import at_least, interval, numbers, one_of, positive, positive_all, within

SOURCES = ("perfect", "camera")
DETECTORS = ("embedded", "open_vocabulary")
TEXTURES = ("plain", "waves", "stripes", "rings", "dots", "checks", "blotches")
STRIDE = 8  # input pixels a side of a cell of the heat map


@dataclass
class EyeConfig:
    """How the simulated camera renders; its mount and lens stand in the robot's robot.yaml."""

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
        numbers("perception.eye.light", self.light, 3)
        numbers("perception.eye.background", self.background, 3)
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
        numbers("perception.perturbation.tilt", self.tilt, 3)
        numbers("perception.perturbation.shift", self.shift, 3)
        within("perception.perturbation.lighting", self.lighting, 0.0, 1.0)
        at_least("perception.perturbation.distractors", self.distractors, 0)


@dataclass
class CalibrationErrorConfig:
    """By how much the eye's extrinsic calibration is wrong, unknown to the robot."""

    translation: float = MISSING  # m
    rotation: float = MISSING  # rad

    def __post_init__(self) -> None:
        """Refuse negative sizes."""
        at_least("perception.calibration_error.translation", self.translation, 0)
        at_least("perception.calibration_error.rotation", self.rotation, 0)


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
    """Where the places of objects come from."""

    source: str = MISSING
    detector: str = MISSING
    weights: str | None = None
    threshold: float = MISSING
    max_detections: int = MISSING
    merge_overlap: float = MISSING
    eye: EyeConfig = field(default_factory=EyeConfig)
    perturbation: PerturbationConfig = field(default_factory=PerturbationConfig)
    calibration_error: CalibrationErrorConfig = field(default_factory=CalibrationErrorConfig)
    vocabulary: OpenVocabularyConfig = field(default_factory=OpenVocabularyConfig)

    def __post_init__(self) -> None:
        """Refuse unknown sources and detectors."""
        one_of("perception.source", self.source, SOURCES)
        one_of("perception.detector", self.detector, DETECTORS)
        within("perception.threshold", self.threshold, 0.0, 1.0)
        positive("perception.max_detections", self.max_detections)
        within("perception.merge_overlap", self.merge_overlap, 0.0, 1.0)

    @property
    def title(self) -> str:
        """Name of the choice of `conf/perception` that it is, for folders and raw rows."""
        wrong = self.calibration_error
        if self.source == "camera" and (wrong.translation > 0 or wrong.rotation > 0):
            return "miscalibrated"
        return self.source


@dataclass
class NetworkConfig:
    """Size of the network."""

    width: int = MISSING  # pixels
    height: int = MISSING  # pixels
    channels: list[int] = MISSING

    def __post_init__(self) -> None:
        """Refuse inputs that cannot be halved four times, and other than four widths."""
        for name in ("width", "height"):
            value = getattr(self, name)
            positive(f"detector.network.{name}", value)
            if isinstance(value, int) and value % (2 * STRIDE):
                raise ValueError(
                    f"detector.network.{name} must be a multiple of {2 * STRIDE}, got {value}"
                )
        positive_all("detector.network.channels", self.channels)
        numbers("detector.network.channels", self.channels, 4)


@dataclass
class AugmentConfig:
    """Changes of a training picture, drawn each time it is seen."""

    brightness: float = MISSING
    tint: float = MISSING
    noise: float = MISSING
    blur: float = MISSING

    def __post_init__(self) -> None:
        """Refuse shares outside 0 to 1."""
        for name in ("brightness", "tint", "noise", "blur"):
            within(f"detector.augment.{name}", getattr(self, name), 0.0, 1.0)


@dataclass
class DomainConfig:
    """From where a random scene, its light and its camera are drawn."""

    reach: float = MISSING  # m
    gap: float = MISSING  # m
    absent: float = MISSING
    tilt: list[float] = MISSING  # deg
    shift: list[float] = MISSING  # m
    azimuth: list[float] = MISSING  # deg
    elevation: list[float] = MISSING  # deg
    ambient: list[float] = MISSING
    diffuse: list[float] = MISSING
    hue: list[float] = MISSING
    saturation: list[float] = MISSING
    value: list[float] = MISSING
    textures: list[str] = MISSING
    contrast: list[float] = MISSING
    distractors: list[int] = MISSING
    distractor_hue: list[float] = MISSING
    distractor_saturation: list[float] = MISSING

    def __post_init__(self) -> None:
        """Refuse ranges whose ends are swapped, chances that are none, and unknown textures."""
        for name in ("tilt", "shift", "azimuth", "elevation", "ambient", "diffuse", "hue"):
            interval(f"detector: {name}", getattr(self, name))
        for name in ("saturation", "value", "contrast", "distractors"):
            interval(f"detector: {name}", getattr(self, name))
        for name in ("distractor_hue", "distractor_saturation"):
            interval(f"detector: {name}", getattr(self, name))
        within("detector: absent", self.absent, 0.0, 1.0)
        at_least("detector: gap", self.gap, 0.0)
        if not isinstance(self.textures, str):
            for name in self.textures:
                one_of("detector: textures", name, TEXTURES)


@dataclass
class DetectorConfig:
    """The stage that renders, trains and judges the embedded detector."""

    source: str = MISSING  # `detector.from` in YAML and on the command line, as `train.from`
    pictures: int = MISSING
    held_out_pictures: int = MISSING
    chunk: int = MISSING
    network: NetworkConfig = field(default_factory=NetworkConfig)
    epochs: int = MISSING
    batch_size: int = MISSING
    learning_rate: float = MISSING
    warm_up_steps: int = MISSING
    weight_decay: float = MISSING
    offset_weight: float = MISSING
    box_weight: float = MISSING
    heatmap_sigma: float = MISSING  # cells
    gradient_clip: float = MISSING
    precision: str = MISSING
    checkpoint_epochs: int = MISSING
    augment: AugmentConfig = field(default_factory=AugmentConfig)
    match_overlap: float = MISSING
    visible: float = MISSING
    figure_pictures: int = MISSING
    training: DomainConfig = field(default_factory=DomainConfig)
    held_out: DomainConfig = field(default_factory=DomainConfig)

    def __post_init__(self) -> None:
        """Refuse a training without pictures or steps."""
        for name in ("pictures", "held_out_pictures", "chunk", "epochs", "batch_size"):
            positive(f"detector.{name}", getattr(self, name))
        for name in ("learning_rate", "heatmap_sigma", "gradient_clip", "checkpoint_epochs"):
            positive(f"detector.{name}", getattr(self, name))
        for name in ("warm_up_steps", "weight_decay", "offset_weight", "box_weight"):
            at_least(f"detector.{name}", getattr(self, name), 0)
        one_of("detector.from", self.source, ("default", "shipped"))
        one_of("detector.precision", self.precision, ("float32", "bfloat16"))
        within("detector.match_overlap", self.match_overlap, 0.0, 1.0)
        within("detector.visible", self.visible, 0.0, 1.0)
        at_least("detector.figure_pictures", self.figure_pictures, 0)
