"""Types of the configuration: one dataclass a group, checked when it is made.

YAML under conf/ owns every value; these classes own names, types and what is possible at all. A
value that cannot be raises `ValueError` with the key, the value and the range.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from omegaconf import MISSING

from pipeline.agent.config import AgentConfig
from pipeline.checks import at_least, one_of, positive, positive_all, within
from pipeline.engine.config import EngineConfig
from pipeline.evaluation.config import EvaluateConfig, SampleConfig
from pipeline.grasping.config import GraspConfig
from pipeline.learning.config import ConstraintConfig
from pipeline.perception.config import PerceptionConfig
from pipeline.perception.training_config import DetectorConfig
from pipeline.planning.config import PlanConfig
from pipeline.reporting.config import ReportConfig
from pipeline.speech.config import SpeechConfig
from pipeline.tuning.config import TuneConfig, check_space


@dataclass
class TableOne:
    """One row of Table I of the paper: what training of one robot's network takes."""

    batch_size: int = MISSING
    learning_rate: float = MISSING
    hidden: list[int] = MISSING
    tanh_layers: int = MISSING
    position_weight: float = MISSING
    rotation_weight: float = MISSING

    def __post_init__(self) -> None:
        """Refuse sizes and rates that are not positive."""
        positive("robot.table_one.batch_size", self.batch_size)
        positive("robot.table_one.learning_rate", self.learning_rate)
        positive_all("robot.table_one.hidden", self.hidden)


@dataclass
class RobotConfig:
    """Which robot, and what an experiment wants of it."""

    name: str = MISSING
    workspace_filter: bool = MISSING
    table_one: TableOne = field(default_factory=TableOne)


@dataclass
class DatasetConfig:
    """Sizes of the pose sets."""

    train: int = MISSING
    validation: int = MISSING
    test: int = MISSING
    workers: int = MISSING

    def __post_init__(self) -> None:
        """Refuse empty sets."""
        for name in ("train", "validation", "test"):
            positive(f"dataset.{name}", getattr(self, name))
        at_least("dataset.workers", self.workers, 0)


@dataclass
class ModelConfig:
    """Architecture of a network."""

    name: str = MISSING
    kind: str = MISSING
    hidden: list[int] = MISSING
    tanh_layers: int = MISSING
    width: int = MISSING
    heads: int = MISSING
    experts: int = 1  # of kind experts; the other kinds are one network for all poses
    encoder: list[int] = field(default_factory=list)  # these are of kind flow
    couplings: int = 0
    components: int = 0
    noise: float = 0.0

    def __post_init__(self) -> None:
        """Refuse layers without neurons and a count of tanh layers beyond the network."""
        one_of("model.kind", self.kind, ("mlp", "experts", "null_space", "null_space_mlp", "flow"))
        positive_all("model.hidden", self.hidden)
        positive("model.width", self.width)
        positive("model.heads", self.heads)
        positive("model.experts", self.experts)
        if self.kind == "flow":
            positive_all("model.encoder", self.encoder)
            positive("model.couplings", self.couplings)
            positive("model.components", self.components)
            at_least("model.noise", self.noise, 0)
        if self.kind == "mlp" and self.heads != 1:
            raise ValueError(f"model.heads must be 1 for model.kind=mlp, got {self.heads}")
        within("model.tanh_layers", self.tanh_layers, 1, len(self.hidden) + 1)


@dataclass
class TrainConfig:
    """Losses, optimiser and schedule."""

    loss: str = MISSING
    position_beta: float = MISSING
    rotation_beta: float = MISSING
    position_weight: float = MISSING
    rotation_weight: float = MISSING
    batch_size: int = MISSING
    learning_rate: float = MISSING
    epochs: int = MISSING
    warm_up_steps: int = MISSING
    weight_decay: float = MISSING
    gradient_clip: float = MISSING
    mean_head_weight: float = MISSING
    mean_head_weight_until: float = MISSING
    kinematics: str = MISSING
    negate_input: bool = MISSING
    device: str = MISSING
    precision: str = MISSING
    step: str = MISSING
    validations: int = MISSING
    checkpoint_s: float = MISSING
    poses: int = MISSING
    variance_of: str = MISSING
    variance_weight: float = MISSING
    variance_samples: int = MISSING
    constraints: list[ConstraintConfig] = MISSING
    constraint_scale: float = MISSING
    keep: str = MISSING
    replicate: int = MISSING
    source: str = (
        MISSING  # `train.from` in YAML and on the command line: `from` is a Python keyword
    )

    def __post_init__(self) -> None:
        """Refuse rates, sizes and names that cannot be."""
        one_of("train.loss", self.loss, ("smooth", "former", "matrix"))
        one_of(
            "train.kinematics",
            self.kinematics,
            ("auto", "compiled", "products", "pytorch_kinematics"),
        )
        one_of("train.step", self.step, ("auto", "eager", "captured"))
        one_of("train.device", self.device, ("auto", "cpu", "cuda"))
        one_of("train.precision", self.precision, ("float32", "bfloat16_backward"))
        one_of("train.keep", self.keep, ("last", "best"))
        at_least("train.poses", self.poses, 0)
        one_of("train.variance_of", self.variance_of, ("mean", "each"))
        at_least("train.variance_weight", self.variance_weight, 0)
        at_least("train.variance_samples", self.variance_samples, 2)
        at_least("train.constraint_scale", self.constraint_scale, 0)
        at_least("train.replicate", self.replicate, 0)
        one_of("train.from", self.source, ("default", "best"))
        for name in ("position_beta", "rotation_beta", "batch_size", "learning_rate", "epochs"):
            positive(f"train.{name}", getattr(self, name))
        for name in ("gradient_clip", "validations", "checkpoint_s"):
            positive(f"train.{name}", getattr(self, name))
        for name in ("position_weight", "rotation_weight", "warm_up_steps", "weight_decay"):
            at_least(f"train.{name}", getattr(self, name), 0)
        for name in ("mean_head_weight", "mean_head_weight_until"):
            within(f"train.{name}", getattr(self, name), 0, 1)


@dataclass
class Config:
    """Everything a stage may ask for."""

    seed: int = MISSING
    profile: str = MISSING
    results_dir: str = MISSING
    robot: RobotConfig = field(default_factory=RobotConfig)
    dataset: DatasetConfig = field(default_factory=DatasetConfig)
    model: ModelConfig = field(default_factory=ModelConfig)
    train: TrainConfig = field(default_factory=TrainConfig)
    tune: TuneConfig = field(default_factory=TuneConfig)
    evaluate: EvaluateConfig = field(default_factory=EvaluateConfig)
    sample: SampleConfig = field(default_factory=SampleConfig)
    plan: PlanConfig = field(default_factory=PlanConfig)
    grasp: GraspConfig = field(default_factory=GraspConfig)
    agent: AgentConfig = field(default_factory=AgentConfig)
    speech: SpeechConfig = field(default_factory=SpeechConfig)
    perception: PerceptionConfig = field(default_factory=PerceptionConfig)
    detector: DetectorConfig = field(default_factory=DetectorConfig)
    report: ReportConfig = field(default_factory=ReportConfig)
    engine: EngineConfig = field(default_factory=EngineConfig)
    # Folder of the trained weights of each neural solver, filled in before a stage runs; no key.
    weights: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse negative seeds, axes of no key, and results in the middle of the sources."""
        at_least("seed", self.seed, 0)
        check_space(self.tune.space, (TrainConfig, ModelConfig))
        if Path(self.results_dir) == Path():
            raise ValueError(
                f"results_dir must name a folder for the results, got '{self.results_dir}'"
            )
