"""All links of a robot, hung on the joints that its variables move.

Links that no variable moves apart are rigidly connected: they share a *frame*, numbered by the
driven joint below which they hang, or -1 for what stands still with the root.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.chain import Drive, DrivenJoints, driven_joints, turn_to_z
from robots.urdf import Joint, Urdf
from robots.urdf_writer import joint_motion

Array = NDArray[np.float64]


class BodyTree(NamedTuple):
    """Driven joints of the whole robot, parents first, as plain arrays for compiled code.

    As in `robots.chain` every frame is turned so that the joint axis is z.

    Attributes:
        parent: (m,) index of the driven joint above, -1 for the root.
        rotations: (m, 3, 3) and
        translations: (m, 3) of the constant transform from the parent's frame, m.
        driven: How the joints follow the variables.
    """

    parent: NDArray[np.int64]
    rotations: Array
    translations: Array
    driven: DrivenJoints


@dataclass(frozen=True)
class Bodies:
    """A `BodyTree` with what hangs on it.

    Attributes:
        tree: The driven joints.
        joint_names: (m,) names of the driven joints.
        frame: Frame of each link.
        pose: (4, 4) pose of each link in its frame, m.
    """

    tree: BodyTree
    joint_names: tuple[str, ...]
    frame: dict[str, int]
    pose: dict[str, Array]


def build_bodies(urdf: Urdf, driven: dict[str, Drive]) -> Bodies:
    """Hang every link of a robot on its driven joints.

    Args:
        urdf: The robot.
        driven: What moves each joint (`robots.chain.drives`).
    """
    frame, pose = {urdf.root: -1}, {urdf.root: np.eye(4)}
    names: list[str] = []
    parents: list[int] = []
    constants: list[Array] = []
    waiting = [urdf.root]
    while waiting:
        link = waiting.pop()
        for joint in (j for j in urdf.joints.values() if j.parent == link):
            waiting.append(joint.child)
            start = pose[link] @ joint.origin
            drive = driven[joint.name]
            if drive.variable < 0:
                frame[joint.child] = frame[link]
                pose[joint.child] = start @ joint_motion(joint, drive.offset)
                continue
            turn = turn_to_z(joint.axis)
            frame[joint.child], pose[joint.child] = len(names), turn.T.copy()
            names.append(joint.name)
            parents.append(frame[link])
            constants.append(start @ turn)
    stacked = np.stack(constants)
    tree = BodyTree(
        parent=np.array(parents, dtype=np.int64),
        rotations=np.ascontiguousarray(stacked[:, :3, :3]),
        translations=np.ascontiguousarray(stacked[:, :3, 3]),
        driven=driven_joints([urdf.joints[name] for name in names], driven),
    )
    return Bodies(tree, tuple(names), frame, pose)


def link_poses(urdf: Urdf, positions: Mapping[str, float]) -> dict[str, Array]:
    """Pose (4, 4) of every link in the root's frame, m.

    Args:
        urdf: The robot.
        positions: Of every joint, rad or m.
    """
    poses = {urdf.root: np.eye(4)}
    below: dict[str, list[Joint]] = {}
    for joint in urdf.joints.values():
        below.setdefault(joint.parent, []).append(joint)
    waiting = [urdf.root]
    while waiting:
        link = waiting.pop()
        for joint in below.get(link, []):
            motion = joint_motion(joint, positions[joint.name])
            poses[joint.child] = poses[link] @ joint.origin @ motion
            waiting.append(joint.child)
    return poses


def adjacent_pairs(urdf: Urdf, bodies: Bodies) -> set[frozenset[str]]:
    """Find pairs of links with shapes that a joint connects, so that they may touch there.

    A link without a collision shape counts as no link at all: its neighbours are each other's.

    Args:
        urdf: The robot.
        bodies: Its links.
    """
    pairs = set()
    for link in (name for name, body in urdf.links.items() if body.collisions):
        joint = urdf.parent_joint(link)
        while joint is not None and not urdf.links[joint.parent].collisions:
            joint = urdf.parent_joint(joint.parent)
        if joint is not None and bodies.frame[joint.parent] != bodies.frame[link]:
            pairs.add(frozenset((joint.parent, link)))
    return pairs


def separable_pairs(urdf: Urdf, bodies: Bodies) -> list[tuple[str, str]]:
    """Pairs of links with shapes that can move against each other and are not adjacent."""
    links = [name for name, body in urdf.links.items() if body.collisions]
    adjacent = adjacent_pairs(urdf, bodies)
    return [
        (first, second)
        for i, first in enumerate(links)
        for second in links[i + 1 :]
        if bodies.frame[first] != bodies.frame[second]
        and frozenset((first, second)) not in adjacent
    ]
