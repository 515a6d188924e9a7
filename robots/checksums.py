"""What a robot is, as checksums: of its kinematics alone, and of all that shapes its samples."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from robots.robot import Robot


def chain_checksum(robot: Robot) -> str:
    """Return the SHA-256 of base, tip, joints, constant transforms, limits and workspace box.

    Weights are bound to it: they survive an edit of a colour or a comment, but no other chain.
    """
    digest = hashlib.sha256(repr((robot.base, robot.tip, robot.joint_names)).encode())
    chain = robot.chain._replace(lower=robot.lower, upper=robot.upper)
    for array in (*chain, robot.lower, robot.upper, robot.workspace):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def sampling_checksum(robot: Robot) -> str:
    """Return the SHA-256 of the chain, the shapes of all links, and the pairs that may touch.

    Pose sets are bound to it.
    """
    description = robot.description
    facts = (
        chain_checksum(robot),
        robot.urdf_checksum,
        sorted(description.posture.items()),
        description.allowed_collisions,
    )
    return hashlib.sha256(repr(facts).encode()).hexdigest()
