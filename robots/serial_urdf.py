"""A URDF of the chain alone, for libraries that read URDF files themselves.

It is written from the robot's own arrays, so it holds nothing that these parsers stumble over
(meshes, other branches, `<safety_controller>`, which makes pytracik read limits as 0), joints that
stand still are folded in, every library gets the limits of the robot, and continuous joints are
revolute. Only the names of base, tip and joints are those of the original.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from robots.errors import RobotError
from robots.rotations import rpy_from_matrix

if TYPE_CHECKING:
    from robots.robot import Robot

# These libraries insist on numbers, on which inverse kinematics does not depend.
EFFORT = 100.0
VELOCITY = 1.0
INERTIAL = (
    '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" '
    'ixy="0" ixz="0" iyz="0"/></inertial>'
)


def serial_urdf(robot: Robot) -> str:
    """URDF text of the serial chain from `robot.base` (its root) to `robot.tip`.

    Raises:
        RobotError: A joint of the chain mimics another one, which these libraries cannot express.
    """
    chain = robot.chain
    if len(chain.variable) != robot.dof:
        raise RobotError(
            f"'{robot.name}': a joint of the chain mimics another one, which libraries that read "
            f"URDF files cannot express; choose a tip above it or give the joint a posture"
        )
    links = [robot.base, *(f"link_{k}" for k in range(1, robot.dof + 1)), robot.tip]
    lines = [f'<robot name="{robot.name}">']
    # KDL warns about a root link that has inertia.
    lines += [f'<link name="{links[0]}"/>']
    lines += [f'<link name="{link}">{INERTIAL}</link>' for link in links[1:]]
    for k, (rotation, translation) in enumerate(
        zip(chain.rotations, chain.translations, strict=True)
    ):
        lines.append(
            f'<joint {_kind(robot, k)}><origin xyz="{_numbers(translation)}" '
            f'rpy="{_numbers(rpy_from_matrix(rotation))}"/>'
            f'<parent link="{links[k]}"/><child link="{links[k + 1]}"/>{_limit(robot, k)}</joint>'
        )
    return "\n".join([*lines, "</robot>\n"])


def _numbers(values: object) -> str:
    return " ".join(repr(float(value)) for value in values)  # type: ignore[attr-defined]


def _kind(robot: Robot, k: int) -> str:
    if k == robot.dof:
        return 'name="to_tip" type="fixed"'
    kind = "prismatic" if robot.chain.prismatic[k] else "revolute"
    return f'name="{robot.joint_names[k]}" type="{kind}"'


def _limit(robot: Robot, k: int) -> str:
    if k == robot.dof:
        return ""
    velocity = float(robot.velocity_limit[k])
    return (
        f'<axis xyz="0 0 1"/><limit lower="{float(robot.lower[k])!r}" '
        f'upper="{float(robot.upper[k])!r}" effort="{EFFORT}" '
        f'velocity="{velocity if math.isfinite(velocity) else VELOCITY}"/>'
    )
