"""A robot for the simulator whose idle joints are rigid: what stands still need not be solved for.

Bullet treats every movable joint as a degree of freedom with a motor, in each iteration of each
step. A second arm or a head that only keeps its posture costs as much there as one that works.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from robots.meshes import resolve_mesh
from robots.rotations import rpy_from_matrix
from robots.urdf_writer import joint_motion

if TYPE_CHECKING:
    from robots import Robot


@contextmanager
def fix_idle_joints(robot: Robot) -> Iterator[Path]:
    """Write the robot's URDF once more, with every idle joint fixed where it rests.

    Idle is what belongs neither to the chain nor to the hand; it rests in the posture of the
    robot's description, at zero if that does not name it. All else is left as it is.

    Args:
        robot: The robot.

    Yields:
        The file, which is gone afterwards; the robot's own where no joint is idle.
    """
    working = {*robot.joint_names, *hand_joints(robot)}
    idle = {n: j for n, j in robot.urdf.joints.items() if j.movable and n not in working}
    if not idle:
        yield robot.urdf_path
        return
    tree = ElementTree.parse(robot.urdf_path)
    for element in tree.getroot().findall("joint"):
        joint = idle.get(element.get("name", ""))
        if joint is not None:
            rest = robot.description.posture.get(joint.name, 0.0)
            pose = joint.origin @ joint_motion(joint, rest)
            origin = element.find("origin")
            if origin is None:
                origin = ElementTree.SubElement(element, "origin")
            origin.set("xyz", " ".join(repr(float(number)) for number in pose[:3, 3]))
            angles = rpy_from_matrix(pose[:3, :3])
            origin.set("rpy", " ".join(repr(float(number)) for number in angles))
            element.set("type", "fixed")
    for mesh in tree.getroot().iter("mesh"):
        path = resolve_mesh(mesh.get("filename", ""), robot.urdf_path, "a link")
        mesh.set("filename", str(path))
    with TemporaryDirectory() as folder:
        path = Path(folder) / robot.urdf_path.name
        tree.write(path, encoding="utf-8")
        yield path


def hand_joints(robot: Robot) -> set[str]:
    """Names of the joints that the hand of the robot's description moves."""
    hand = robot.description.hand or {}
    tendons = hand.get("tendons", {}).values()
    return {*hand.get("joints", []), *(name for names in tendons for name in names)}
