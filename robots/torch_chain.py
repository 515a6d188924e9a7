"""The chain as pytorch-kinematics sees it, for learning."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from robots.serial_urdf import TIP, serial_urdf

if TYPE_CHECKING:
    import torch

    from robots.robot import Robot


def build_torch_chain(robot: Robot, dtype: torch.dtype, device: str) -> Any:
    """Build a `pytorch_kinematics.SerialChain` from base to tip.

    It is built from the chain's own arrays, one link per joint, so that frozen joints and
    the rest of the body cost nothing in training; its links have names of their own
    (`robots.serial_urdf`). The library reads constants in float32
    whatever dtype is requested, so that poses are within 1e-7 m of ours even in float64.

    Args:
        robot: The robot.
        dtype: Floating-point type of the transforms.
        device: Torch device.

    Raises:
        RobotError: If a joint of the chain mimics another; pytorch-kinematics has no couplings.
    """
    import pytorch_kinematics

    xml = serial_urdf(robot, robot.joint_names)
    chain = pytorch_kinematics.build_serial_chain_from_urdf(xml.encode(), TIP)
    return chain.to(dtype=dtype, device=device)
