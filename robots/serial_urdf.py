"""A URDF of the chain alone, for libraries that read URDF files themselves.

It is written from the robot's own arrays, so it holds nothing that these parsers stumble over
(meshes, other branches, `<safety_controller>`, which makes pytracik read limits as 0), joints that
stand still are folded in, every library gets the limits of the robot, and joints that turn for ever
are revolute with a turn more on either side (`robots.limits.search_range`). Links and joints have
plain names of their own, all different: those of the robot may clash with each other, or with what
a library calls its world.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from robots.errors import RobotError
from robots.rotations import rpy_from_matrix

if TYPE_CHECKING:
    from robots.robot import Robot

# What base, tip and joints are called, the latter with their number from 0.
BASE, TIP, JOINT = "chain_base", "chain_tip", "chain_joint_{}"
# These libraries insist on numbers, on which inverse kinematics does not depend.
EFFORT = 100.0
VELOCITY = 1.0
INERTIA = dict.fromkeys(("ixx", "iyy", "izz"), "0.01") | dict.fromkeys(("ixy", "ixz", "iyz"), "0")


def serial_urdf(robot: Robot, joint_names: Sequence[str] | None = None) -> str:
    """URDF text of the serial chain from `robot.base` (its root) to `robot.tip`.

    Args:
        robot: The robot.
        joint_names: (dof,) names of the joints, for a library that keeps them apart from those of
            links; plain ones if not given.

    Raises:
        RobotError: A joint of the chain mimics another one, which these libraries cannot express.
    """
    chain = robot.chain
    if len(chain.variable) != robot.dof:
        raise RobotError(
            f"'{robot.name}': a joint of the chain mimics another one, which libraries that read "
            f"URDF files cannot express; choose a tip above it or give the joint a posture"
        )
    links = [BASE, *(f"chain_link_{k}" for k in range(1, robot.dof + 1)), TIP]
    document = ElementTree.Element("robot", name="chain")
    # KDL warns about a root link that has inertia.
    document.append(ElementTree.Element("link", name=links[0]))
    document.extend(_link(name) for name in links[1:])
    joints = [*(joint_names or map(JOINT.format, range(robot.dof))), "chain_to_tip"]
    for k in range(robot.dof + 1):
        document.append(_joint(robot, k, joints[k], (links[k], links[k + 1])))
    ElementTree.indent(document)
    return ElementTree.tostring(document, encoding="unicode") + "\n"


def _link(name: str) -> ElementTree.Element:
    link = ElementTree.Element("link", name=name)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", value="1")
    ElementTree.SubElement(inertial, "inertia", INERTIA)
    return link


def _joint(robot: Robot, k: int, name: str, links: tuple[str, str]) -> ElementTree.Element:
    """The k-th joint; the one behind the last variable is fixed and leads to the tip."""
    chain = robot.chain
    moves = k < robot.dof
    kind = "fixed" if not moves else "prismatic" if chain.prismatic[k] else "revolute"
    joint = ElementTree.Element("joint", name=name, type=kind)
    rpy = rpy_from_matrix(chain.rotations[k])
    ElementTree.SubElement(joint, "origin", xyz=_numbers(chain.translations[k]), rpy=_numbers(rpy))
    ElementTree.SubElement(joint, "parent", link=links[0])
    ElementTree.SubElement(joint, "child", link=links[1])
    if moves:
        velocity = float(robot.velocity_limit[k])
        values = {
            "lower": float(chain.lower[k]),
            "upper": float(chain.upper[k]),
            "effort": EFFORT,
            "velocity": velocity if math.isfinite(velocity) else VELOCITY,
        }
        ElementTree.SubElement(joint, "axis", xyz="0 0 1")
        ElementTree.SubElement(joint, "limit", {key: repr(v) for key, v in values.items()})
    return joint


def _numbers(values: np.ndarray) -> str:
    return " ".join(repr(float(value)) for value in values)
