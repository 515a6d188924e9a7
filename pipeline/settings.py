"""Types of the configuration: one dataclass a group, checked when it is made.

YAML under conf/ owns every value; these classes own names, types and what is possible at all. A
value that cannot be raises `ValueError` with the key, the value and the range.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from omegaconf import MISSING

from pipeline.agent.config import AgentConfig
from pipeline.checks import at_least, positive, positive_all
from pipeline.engine.config import EngineConfig
from pipeline.evaluation.config import EvaluateConfig, SampleConfig
from pipeline.exporting.config import ExportConfig
from pipeline.grasping.config import GraspConfig
from pipeline.learning.config import ModelConfig, TrainConfig
from pipeline.learning.registry import config_classes
from pipeline.learning.tracker import TrackerConfig
from pipeline.perception.config import DetectorConfig, PerceptionConfig
from pipeline.planning.config import PlanConfig
from pipeline.protocols.config import ProtocolConfig
from pipeline.reachability.config import ReachConfig
from pipeline.reporting.config import ReportConfig
from pipeline.speech.config import SpeechConfig
from pipeline.suites.config import SuiteConfig
from pipeline.tuning.config import TuneConfig, check_space
from pipeline.viewing.config import ViewConfig


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
    rotation_weight: float = 3.0
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
class Config:
    """Everything a stage may ask for.

    Attributes:
        solver: Settings of every solver by name, as conf/solver and the run say.
    """

    seed: int = MISSING
    profile: str = MISSING
    results_dir: str = MISSING
    robot: RobotConfig = field(default_factory=RobotConfig)
    dataset: DatasetConfig = field(default_factory=DatasetConfig)
    model: ModelConfig = field(default_factory=ModelConfig)
    train: TrainConfig = field(default_factory=TrainConfig)
    tracker: TrackerConfig = field(default_factory=TrackerConfig)
    solver: dict[str, dict[str, Any]] = MISSING
    tune: TuneConfig = field(default_factory=TuneConfig)
    evaluate: EvaluateConfig = field(default_factory=EvaluateConfig)
    sample: SampleConfig = field(default_factory=SampleConfig)
    suite: SuiteConfig = field(default_factory=SuiteConfig)
    protocol: ProtocolConfig = field(default_factory=ProtocolConfig)
    reach: ReachConfig = field(default_factory=ReachConfig)
    plan: PlanConfig = field(default_factory=PlanConfig)
    grasp: GraspConfig = field(default_factory=GraspConfig)
    agent: AgentConfig = field(default_factory=AgentConfig)
    speech: SpeechConfig = field(default_factory=SpeechConfig)
    perception: PerceptionConfig = field(default_factory=PerceptionConfig)
    detector: DetectorConfig = field(default_factory=DetectorConfig)
    export: ExportConfig = field(default_factory=ExportConfig)
    report: ReportConfig = field(default_factory=ReportConfig)
    engine: EngineConfig = field(default_factory=EngineConfig)
    view: ViewConfig = field(default_factory=ViewConfig)
    # Folder of the trained weights of each neural solver, filled in before a stage runs; no key.
    weights: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse negative seeds, axes of no key, and results in the middle of the sources."""
        at_least("seed", self.seed, 0)
        check_space(self.tune.space, (TrainConfig, *config_classes()))
        if Path(self.results_dir) == Path():
            raise ValueError(
                f"results_dir must name a folder for the results, got '{self.results_dir}'"
            )
