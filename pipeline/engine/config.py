"""Types of `conf/engine`: where the tasks of a stage run, how many at a time, and on what."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive

LOCAL, SLURM, RAY = ENGINES = ("local", "slurm", "ray")
CLUSTERS = ("slurm", "local", "debug")


@dataclass
class EngineConfig:
    """An engine and what one task of it gets.

    Keys that only one engine knows stand in its YAML alone; here they are empty for the others.
    """

    name: str = MISSING
    workers: int = MISSING
    cpus: int = MISSING
    start_up_s: float = MISSING
    pieces: int = MISSING
    memory_gb: float = 0.0  # these are of slurm and ray
    cluster: str = ""  # these are of slurm
    partition: str = ""
    minutes: int = 0
    tasks_per_job: int = 1
    options: dict[str, Any] | None = None
    setup: list[str] = field(default_factory=list)
    folder: str = ""
    address: str = ""  # this is of ray

    def __post_init__(self) -> None:
        """Refuse engines that do not exist and tasks that get nothing."""
        one_of("engine.name", self.name, ENGINES)
        anywhere = self.name in (SLURM, RAY)
        at_least("engine.workers", self.workers, 1 if anywhere else 0)
        at_least("engine.cpus", self.cpus, 1 if anywhere else 0)
        at_least("engine.start_up_s", self.start_up_s, 0)
        at_least("engine.memory_gb", self.memory_gb, 0)
        positive("engine.pieces", self.pieces)
        positive("engine.tasks_per_job", self.tasks_per_job)
        if self.name == SLURM:
            one_of("engine.cluster", self.cluster, CLUSTERS)
            positive("engine.minutes", self.minutes)
            if not self.folder:
                raise ValueError("engine.folder must name a folder that every machine sees")
        if self.name == RAY and not self.address:
            raise ValueError(
                "engine.address must be local (a runtime of its own on this machine), auto (the "
                "cluster that this machine belongs to) or host:port, got nothing"
            )
