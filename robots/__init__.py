"""What a robot is: descriptions, kinematics, collision and samples.

Public API:
    load_robot, available_robots, Robot and the errors, all of which are a `RobotError`.
"""

from robots.description import Description, available_robots
from robots.errors import (
    DescriptionError,
    RobotError,
    SamplingError,
    UnknownRobotError,
    UrdfError,
)
from robots.robot import Robot, load_robot

__all__ = [
    "Description",
    "DescriptionError",
    "Robot",
    "RobotError",
    "SamplingError",
    "UnknownRobotError",
    "UrdfError",
    "available_robots",
    "load_robot",
]
