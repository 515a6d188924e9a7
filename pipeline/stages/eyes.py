"""The detector of a run: the one that it trained, else the project's."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.grasping.trial import required_scene
from pipeline.perception.loading import load_detector
from pipeline.perception.weights import CARD
from pipeline.stages.inputs import artifacts

if TYPE_CHECKING:
    from pipeline.perception.detection import Detector
    from pipeline.settings import Config
    from robots import Robot


def detector_of(robot: Robot, config: Config) -> Detector:
    """Load the detector of a run: the one that this run trained, else the project's.

    `perception.weights` names another folder; an open-vocabulary model is the user's own.

    Raises:
        PerceptionError: There is none, or it is for another robot or for other objects.
    """
    wanted = config.perception
    if wanted.weights is None and wanted.detector == "embedded":
        folders = artifacts(config)
        own = folders.detector(robot.name)
        found = folders.find(own.relative_to(folders.root) / CARD)
        wanted = replace(wanted, weights=str(found.parent) if found else None)
    return load_detector(wanted, robot, required_scene(config.grasp, robot.name).objects)
