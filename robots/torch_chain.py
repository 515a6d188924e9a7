"""The chain as pytorch-kinematics sees it, for learning."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robots.errors import RobotError
from robots.rotations import rpy_from_matrix

if TYPE_CHECKING:
    import torch

    from robots.robot import Robot


def build_torch_chain(robot: Robot, dtype: torch.dtype, device: str) -> Any:
    """Build a `pytorch_kinematics.SerialChain` from base to tip.

    It is built from the chain's own arrays, one link per joint, so that frozen joints and
    the rest of the body cost nothing in training. The library reads constants in float32
    whatever dtype is asked for, so that poses are within 1e-7 m of ours even in float64.

    Args:
        robot: The robot.
        dtype: Floating-point type of the transforms.
        device: Torch device.

    Raises:
        RobotError: If a joint of the chain mimics another; pytorch-kinematics has no couplings.
    """
    import pytorch_kinematics

    if len(robot.chain.variable) != robot.dof:
        raise RobotError(
            f"'{robot.name}': a joint of the chain mimics another one, which pytorch-kinematics "
            f"cannot express; choose a tip above it or give the joint a posture"
        )
    xml = _serial_urdf(robot).encode()
    tip = f"link{robot.dof + 1}"
    return pytorch_kinematics.build_serial_chain_from_urdf(xml, tip).to(dtype=dtype, device=device)


def _serial_urdf(robot: Robot) -> str:
    """URDF of the bare chain, every axis z, as in `robots.chain`."""
    chain = robot.chain
    lines = [f'<robot name="{robot.name}">', '<link name="link0"/>']
    for k, (rotation, translation) in enumerate(
        zip(chain.rotations, chain.translations, strict=True)
    ):
        xyz = " ".join(repr(float(v)) for v in translation)
        rpy = " ".join(repr(float(v)) for v in rpy_from_matrix(rotation))
        name, kind, limit = "tip", "fixed", ""
        if k < robot.dof:
            name = robot.joint_names[k]
            kind = "prismatic" if chain.prismatic[k] else "revolute"
            bounds = f'lower="{float(robot.lower[k])!r}" upper="{float(robot.upper[k])!r}"'
            limit = f'<axis xyz="0 0 1"/><limit {bounds} velocity="1" effort="1"/>'
        lines += [
            f'<link name="link{k + 1}"/>',
            f'<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="{rpy}"/>'
            f'<parent link="link{k}"/><child link="link{k + 1}"/>{limit}</joint>',
        ]
    return "\n".join([*lines, "</robot>"])
