# ruff: noqa: E402 - the cache is set up between the imports
"""What a robot is: descriptions, kinematics, collision and samples.

Public API:
    load_robot, available_robots, Robot, Obstacles of Box and Sphere, and the errors, all of which
    are a `RobotError`.
"""

from robots.compiled_cache import use_own_folder

use_own_folder("robots")  # before the imports below declare compiled functions

from robots.description import Description, available_robots
from robots.errors import (
    DescriptionError,
    ObstacleError,
    RobotError,
    SamplingError,
    UnknownRobotError,
    UrdfError,
)
from robots.obstacles import Box, Obstacles, Sphere
from robots.robot import Robot, load_robot

__all__ = [
    "Box",
    "Description",
    "DescriptionError",
    "ObstacleError",
    "Obstacles",
    "Robot",
    "RobotError",
    "SamplingError",
    "Sphere",
    "UnknownRobotError",
    "UrdfError",
    "available_robots",
    "load_robot",
]
