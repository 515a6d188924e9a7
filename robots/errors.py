"""Errors of the robots package: each says what was expected, what came and what to do."""

from __future__ import annotations


class RobotError(ValueError):
    """Anything wrong with a robot: its description, its URDF or a request to it."""


class UrdfError(RobotError):
    """A URDF that cannot be used as it is."""


class UnknownRobotError(RobotError):
    """A robot name that no folder under `robots/` has."""


class DescriptionError(RobotError):
    """A `robot.yaml` that is missing, misspelt or contradicts its URDF."""


class SamplingError(RobotError):
    """No configurations of the wanted kind could be found."""


class ObstacleError(RobotError):
    """Obstacles that are no boxes and spheres, or a clearance that cannot be."""
