"""One arm of the zoo from its URDF to a row: trained, measured, kept."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.data.files import read_json, write_json
from pipeline.learning.card import chain_facts
from pipeline.seeding import derive_seed
from pipeline.zoo.arms import Arm, ZooConfig, robot_of_arm
from pipeline.zoo.measuring import descents
from pipeline.zoo.training import trained
from robots import Robot

ROW = "row.json"


def row_of(arm: Arm, folder: Path, zoo: ZooConfig) -> dict[str, Any]:
    """Return the row of an arm, made where there is none for these sizes.

    Args:
        arm: The arm.
        folder: Of the zoo: robots lie in it, and a folder for each arm.
        zoo: Sizes.

    Raises:
        MissingArmError: No installed package has its URDF.
        RobotError: The URDF cannot be used.
    """
    own = folder / arm.name
    with exclusive(own):
        robot = robot_of_arm(arm, folder / "robots")
        digest = provenance.digest([asdict(zoo), chain_facts(robot)])
        path = own / ROW
        if path.exists() and (kept := dict(read_json(path)))["digest"] == digest:
            return kept
        row = {"digest": digest, "arm": arm.name, **_shape(robot), **_measured(robot, own, zoo)}
        row |= {**provenance.made_by(), **provenance.signature("none"), "seed": zoo.seed}
        write_json(path, row)
        return row


def _shape(robot: Robot) -> dict[str, Any]:
    turning = ~robot.sliding
    return {
        "joints": robot.dof,
        "endless": int(robot.endless.sum()),
        "sliding": int(robot.sliding.sum()),
        "range_rad": float((robot.upper - robot.lower)[turning].mean()),
    }


def _measured(robot: Robot, folder: Path, zoo: ZooConfig) -> dict[str, Any]:
    """Train and measure; poses are of free configurations, which the training does not know."""
    network = trained(robot, folder / "weights", zoo)
    joints = robot.sample(zoo.poses, seed=derive_seed(zoo.seed, "zoo", robot.name, "test"))
    poses = robot.forward_kinematics(joints)
    home, seeded = descents(robot, network.folder, np.ascontiguousarray(poses), zoo.rounds)
    facts = {
        "training_s": network.processor_s,
        "network_mm": network.position_mm,
        "network_deg": network.rotation_deg,
    }
    for name, descent in (("home", home), ("seeded", seeded)):
        facts |= {f"{name}_{key}": value for key, value in asdict(descent).items()}
    facts["gain_iterations"] = home.iterations / seeded.iterations
    facts["gain_time"] = home.time_us / seeded.time_us
    return facts
