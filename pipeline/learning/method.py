"""What a folder of a neural method declares, in words that need no torch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

MODEL_CONFIG = "pipeline.learning.config.ModelConfig"


@dataclass(frozen=True)
class Method:
    """Networks of a method and what they are trained for; classes by their dotted names.

    The solver of a method is declared by its YAML in conf/solver, as every solver is.

    Attributes:
        networks: Class of the network for each ``model.kind``, a subclass of `IkNetwork`, made of a
            robot and a `ModelConfig`.
        objective: Class of the `Objective`, made of robot, network, `TrainConfig`, device and seed.
        model: Name in conf/model of what is trained for the method where nothing else is said.
        config: Dataclass of the keys of ``model`` for its networks, `ModelConfig` or one derived
            from it with keys of its own.
        trained_for: What stands for the loss in tables; empty where ``train.loss`` names it.
    """

    networks: Mapping[str, str]
    objective: str
    model: str
    config: str = MODEL_CONFIG
    trained_for: str = ""

    @property
    def kinds(self) -> tuple[str, ...]:
        """Its kinds of networks, as ``model.kind`` names them."""
        return tuple(self.networks)
