"""Differentiable forward kinematics: joints to tip frames, by pytorch-kinematics or compiled."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from robots import Robot
from robots.chain import Chain
from robots.compiled import njit
from robots.kinematics import tip_frame_and_jacobian

Frames = tuple[Tensor, Tensor]


class ForwardKinematics(Protocol):
    """Joints (N, dof) to positions (N, 3) in metres and rotations (N, 3, 3), differentiable."""

    def __call__(self, joints: Tensor) -> Frames:
        """Return positions and rotations of the tip in the base frame."""


class LibraryKinematics:
    """The chain of pytorch-kinematics: any device, the reference that ours is held against.

    Args:
        robot: The robot; its chain is read once.
        device: Where the frames are computed.
        dtype: Precision; float32 is exact to about a micrometre.
    """

    def __init__(
        self, robot: Robot, device: str | torch.device = "cpu", dtype: torch.dtype = torch.float32
    ) -> None:
        self._chain = robot.torch_chain(dtype=dtype, device=str(device))

    def __call__(self, joints: Tensor) -> Frames:
        """Return positions (N, 3) and rotations (N, 3, 3) of the tip."""
        matrix = self._chain.forward_kinematics(joints).get_matrix()
        return matrix[:, :3, 3], matrix[:, :3, :3]


class CompiledKinematics:
    """Frame and Jacobian from one compiled pass; the gradient is the Jacobian's transpose.

    Several times faster on a processor than a chain of small tensor products.

    Args:
        robot: The robot.
        chain: A chain to another link than the tip, driven by the same joints.
    """

    def __init__(self, robot: Robot, chain: Chain | None = None) -> None:
        self._chain = robot.chain if chain is None else chain

    def __call__(self, joints: Tensor) -> Frames:
        """Return positions (N, 3) and rotations (N, 3, 3) of the tip, float32."""
        position, rotation = _TipFrame.apply(joints, self._chain)
        return position, rotation


class ChainKinematics:
    """Any chain of a robot by tensor products, on any device; gradients are torch's.

    Args:
        chain: The chain; its joints may be a part of the robot's.
        device: Where the frames are computed.
        dtype: Precision.
    """

    def __init__(
        self, chain: Chain, device: torch.device, dtype: torch.dtype = torch.float32
    ) -> None:
        def constant(values: NDArray[np.float64]) -> Tensor:
            return torch.as_tensor(values, dtype=dtype, device=device)

        self._rotations, self._translations = (
            constant(chain.rotations),
            constant(chain.translations),
        )
        self._multiplier, self._offset = constant(chain.multiplier), constant(chain.offset)
        self._variable = torch.as_tensor(chain.variable, device=device)
        self._prismatic = chain.prismatic.tolist()

    def __call__(self, joints: Tensor) -> Frames:
        """Return positions (N, 3) and rotations (N, 3, 3) of the chain's end."""
        values = self._multiplier * joints[:, self._variable] + self._offset
        rotation = self._rotations[0].expand(len(joints), 3, 3)
        position = self._translations[0].expand(len(joints), 3)
        for index, slides in enumerate(self._prismatic):
            value = values[:, index, None]
            x, y, z = rotation.unbind(dim=2)
            if slides:
                position = position + z * value
            else:
                cosine, sine = value.cos(), value.sin()
                rotation = torch.stack((x * cosine + y * sine, y * cosine - x * sine, z), dim=2)
            position = position + rotation @ self._translations[index + 1]
            rotation = rotation @ self._rotations[index + 1]
        return position, rotation


def make_link_kinematics(robot: Robot, link: str, device: torch.device) -> ForwardKinematics:
    """Return the kinematics of another link of the robot: compiled on a CPU, else in torch.

    Raises:
        UrdfError: There is no such link below the base.
    """
    chain = robot.chain_to(link)
    if device.type == "cpu":
        return CompiledKinematics(robot, chain)
    return ChainKinematics(chain, device)


def make_kinematics(robot: Robot, name: str, device: torch.device) -> ForwardKinematics:
    """Return what ``train.kinematics`` names; ``auto`` is compiled on the CPU, else products."""
    if name == "compiled" or (name == "auto" and device.type == "cpu"):
        return CompiledKinematics(robot)
    if name in ("auto", "products"):
        return ChainKinematics(robot.chain, device)
    return LibraryKinematics(robot, device)


class _TipFrame(torch.autograd.Function):
    """Tip frames with the vector-Jacobian product of a rigid body.

    A change dq moves the tip by dp = J_v dq and turns it by w = J_w dq, so that a column r of the
    rotation changes by w x r. With gradients g of p and G of R the gradient of q is therefore
    J_v^T g + J_w^T sum_k r_k x G_k (Siciliano et al., *Robotics*, section 3.1).
    """

    @staticmethod
    def forward(ctx: Any, joints: Tensor, chain: Any) -> Frames:
        values = joints.detach().to(torch.float64).numpy()
        count = len(values)
        position = np.empty((count, 3), dtype=np.float32)
        rotation = np.empty((count, 3, 3), dtype=np.float32)
        jacobian = np.empty((count, 6, values.shape[1]), dtype=np.float32)
        _frames(chain, values, position, rotation, jacobian)
        frames = torch.from_numpy(position), torch.from_numpy(rotation)
        ctx.save_for_backward(frames[1], torch.from_numpy(jacobian))
        return frames

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor, None]:
        rotation, jacobian = ctx.saved_tensors
        force, stress = gradients
        torque = torch.linalg.cross(rotation, stress, dim=1).sum(dim=2)
        wrench = torch.cat((force, torque), dim=1)
        return torch.bmm(wrench.unsqueeze(1), jacobian).squeeze(1), None


@njit()
def _frames(chain, joints, positions, rotations, jacobians):  # type: ignore[no-untyped-def]
    """Frames and Jacobians of joints (N, dof) on one thread, computed in float64."""
    R, p, J = np.empty((3, 3)), np.empty(3), np.empty((6, joints.shape[1]))
    for row in range(joints.shape[0]):
        tip_frame_and_jacobian(chain, joints[row], R, p, J)
        positions[row] = p
        rotations[row] = R
        jacobians[row] = J
