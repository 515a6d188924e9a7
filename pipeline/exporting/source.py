"""What is taken away: a robot, and its network where it has one; and the card of the file."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray

import baselines
from baselines.checks import check_poses
from pipeline import provenance
from pipeline.learning.card import read_card, shipped_weights
from pipeline.learning.cycleik.solver import CycleIk
from pipeline.learning.networks import IkNetwork, parameter_count
from pipeline.learning.solver import Hypotheses
from robots import Robot
from robots.checksums import chain_checksum

Array = NDArray[np.float64]

SOLVER = "cycleik"
POSE = "x y z [m], then qw qx qy qz, unit, in the frame of the base"


@dataclass(frozen=True)
class Source:
    """A robot and the solver whose network is exported.

    Attributes:
        robot: The robot.
        solver: `cycleik` with its weights; None for a robot without any.
    """

    robot: Robot
    solver: CycleIk | None

    @property
    def network(self) -> IkNetwork:
        """The solver's network."""
        assert self.solver is not None
        return self.solver.network

    @cached_property
    def ranking(self) -> Array:
        """(2,) what an error of 1 m and of 1 rad counts when hypotheses are compared."""
        assert self.solver is not None
        tolerances = self.solver.position_tolerance_mm / 1e3, self.solver.rotation_tolerance_deg
        return np.array([1 / tolerances[0], 180 / np.pi / tolerances[1]])

    def precise_hypotheses(self, poses: Array) -> Hypotheses:
        """The network's answers to poses (N, 7) evaluated in float64, head by head, unsorted.

        The solver evaluates compiled networks with a tanh good to 5e-10, others in float32.
        """
        assert self.solver is not None
        network = deepcopy(self.network).double()
        targets = check_poses(poses)
        with torch.inference_mode():
            output = network(torch.as_tensor(targets)).numpy()
        joints = np.clip(output, self.robot.lower, self.robot.upper)
        return Hypotheses(joints, *self.solver.errors(joints, targets))


def load_source(robot: Robot, weights: Path | None) -> Source:
    """Load what is exported of a robot.

    Args:
        robot: The robot.
        weights: Folder of its weights; None for the descent alone.

    Raises:
        WeightsError: They are damaged, or of another robot or kind of network.
    """
    if weights is None:
        return Source(robot, None)
    solver = baselines.load(SOLVER, robot, weights=str(weights))
    return Source(robot, cast(CycleIk, solver))


def card_of(source: Source, command: str) -> dict[str, str]:
    """Return what a file says of itself, texts throughout.

    Args:
        source: What is exported.
        command: That wrote the file.
    """
    robot = source.robot
    card = {
        "robot": robot.name,
        "base": robot.base,
        "tip": robot.tip,
        "joints": json.dumps(list(robot.joint_names)),
        "lower": json.dumps(robot.lower.tolist()),
        "upper": json.dumps(robot.upper.tolist()),
        "units": "rad, m where a joint slides",
        "pose": POSE,
        "chain_checksum": chain_checksum(robot),
        "made_by": f"cycleik-bench {version('cycleik-bench')}, {provenance.commit()}: {command}",
    }
    return card | _of_network(source)


def _of_network(source: Source) -> dict[str, str]:
    solver = source.solver
    if solver is None or solver.weights is None:
        return {"network": "none", "licence": "MIT"}
    trained = read_card(Path(solver.weights))
    shipped = Path(solver.weights) == shipped_weights(source.robot.name)
    of_weights = "MIT" if shipped else "that of whoever trained them"
    return {
        "network": f"model={trained['config']['model']['name']}",
        "parameters": str(parameter_count(source.network)),
        "heads": str(source.network.heads),
        "weights_sha256": str(trained["weights_sha256"]),
        "licence": f"MIT; of the weights: {of_weights}",
    }
