"""Compiled forward kinematics and Jacobians of a `Chain`.

The device functions work on one configuration and on arrays that the caller owns, so that the
solvers of `baselines` can call them inside their own loops; the batched kernels at the end loop
over configurations. Positions in m, angles in rad, everything in the base frame, float64.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from robots.chain import Chain

Array = NDArray[np.float64]


@njit(cache=True, inline="always")
def apply_joint(R, p, prismatic, position):  # type: ignore[no-untyped-def]
    """Move a frame, in place, by its joint: turn about its z axis or slide along it.

    Args:
        R: (3, 3) rotation of the frame.
        p: (3,) origin of the frame, m.
        prismatic: Whether the joint slides.
        position: Joint position, rad or m.
    """
    if prismatic:
        for row in range(3):
            p[row] += R[row, 2] * position
    else:
        sine, cosine = math.sin(position), math.cos(position)
        for row in range(3):
            x, y = R[row, 0], R[row, 1]
            R[row, 0] = cosine * x + sine * y
            R[row, 1] = cosine * y - sine * x


@njit(cache=True, inline="always")
def apply_constant(R, p, rotation, translation):  # type: ignore[no-untyped-def]
    """Multiply a frame, in place, by a constant transform on its right.

    Args:
        R: (3, 3) rotation of the frame.
        p: (3,) origin of the frame, m.
        rotation: (3, 3) of the constant transform.
        translation: (3,) of the constant transform, m.
    """
    for row in range(3):
        x, y, z = R[row, 0], R[row, 1], R[row, 2]
        p[row] += x * translation[0] + y * translation[1] + z * translation[2]
        for column in range(3):
            R[row, column] = (
                x * rotation[0, column] + y * rotation[1, column] + z * rotation[2, column]
            )


@njit(cache=True)
def tip_frame(chain, q, R, p):  # type: ignore[no-untyped-def]
    """Pose of the tip for one configuration.

    Args:
        chain: The `Chain`.
        q: (dof,) joint positions, rad or m.
        R: (3, 3) receives the rotation of the tip.
        p: (3,) receives the position of the tip, m.
    """
    R[:] = chain.rotations[0]
    p[:] = chain.translations[0]
    for k in range(chain.prismatic.shape[0]):
        position = chain.multiplier[k] * q[chain.variable[k]] + chain.offset[k]
        apply_joint(R, p, chain.prismatic[k], position)
        apply_constant(R, p, chain.rotations[k + 1], chain.translations[k + 1])


@njit(cache=True)
def tip_frame_and_jacobian(chain, q, R, p, J):  # type: ignore[no-untyped-def]
    """Pose of the tip and its geometric Jacobian for one configuration.

    Args:
        chain: The `Chain`.
        q: (dof,) joint positions, rad or m.
        R: (3, 3) receives the rotation of the tip.
        p: (3,) receives the position of the tip, m.
        J: (6, dof) receives the Jacobian at the tip in axes of the base, linear rows first:
            J qdot = (velocity of the tip, angular velocity). Column of a turning joint with
            axis z and origin o: (z x (p - o), z); of a sliding one: (z, 0). Siciliano et al.,
            "Robotics: Modelling, Planning and Control", section 3.1.3.
    """
    joints = chain.prismatic.shape[0]
    axes = np.empty((joints, 3))
    origins = np.empty((joints, 3))
    R[:] = chain.rotations[0]
    p[:] = chain.translations[0]
    for k in range(joints):
        for row in range(3):
            axes[k, row] = R[row, 2]
            origins[k, row] = p[row]
        position = chain.multiplier[k] * q[chain.variable[k]] + chain.offset[k]
        apply_joint(R, p, chain.prismatic[k], position)
        apply_constant(R, p, chain.rotations[k + 1], chain.translations[k + 1])
    J[:] = 0.0
    for k in range(joints):
        column, scale = chain.variable[k], chain.multiplier[k]
        zx, zy, zz = scale * axes[k, 0], scale * axes[k, 1], scale * axes[k, 2]
        if chain.prismatic[k]:
            J[0, column] += zx
            J[1, column] += zy
            J[2, column] += zz
            continue
        dx, dy, dz = p[0] - origins[k, 0], p[1] - origins[k, 1], p[2] - origins[k, 2]
        J[0, column] += zy * dz - zz * dy
        J[1, column] += zz * dx - zx * dz
        J[2, column] += zx * dy - zy * dx
        J[3, column] += zx
        J[4, column] += zy
        J[5, column] += zz


@njit(cache=True)
def quaternion_of(R, quaternion):  # type: ignore[no-untyped-def]
    """Canonical unit quaternion of a rotation, after Shepperd (1978).

    Args:
        R: (3, 3) rotation.
        quaternion: (4,) receives w x y z, w >= 0.
    """
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    if trace > R[0, 0] and trace > R[1, 1] and trace > R[2, 2]:
        w, x, y, z = 1 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    elif R[0, 0] >= R[1, 1] and R[0, 0] >= R[2, 2]:
        w, x = R[2, 1] - R[1, 2], 1 + R[0, 0] - R[1, 1] - R[2, 2]
        y, z = R[1, 0] + R[0, 1], R[0, 2] + R[2, 0]
    elif R[1, 1] >= R[2, 2]:
        w, y = R[0, 2] - R[2, 0], 1 - R[0, 0] + R[1, 1] - R[2, 2]
        x, z = R[1, 0] + R[0, 1], R[2, 1] + R[1, 2]
    else:
        w, z = R[1, 0] - R[0, 1], 1 - R[0, 0] - R[1, 1] + R[2, 2]
        x, y = R[0, 2] + R[2, 0], R[2, 1] + R[1, 2]
    scale = 1.0 / math.sqrt(w * w + x * x + y * y + z * z)
    if w < 0.0:
        scale = -scale
    quaternion[0] = w * scale
    quaternion[1] = x * scale
    quaternion[2] = y * scale
    quaternion[3] = z * scale


@njit(cache=True)
def poses_kernel(chain, joints, poses):  # type: ignore[no-untyped-def]
    """Tip poses of a batch on one thread.

    Args:
        chain: The `Chain`.
        joints: (N, dof), rad or m.
        poses: (N, 7) receives x y z, qw qx qy qz.
    """
    R, p = np.empty((3, 3)), np.empty(3)
    for i in range(joints.shape[0]):
        tip_frame(chain, joints[i], R, p)
        poses[i, :3] = p
        quaternion_of(R, poses[i, 3:])


@njit(cache=True)
def jacobians_kernel(chain, joints, poses, jacobians):  # type: ignore[no-untyped-def]
    """Tip poses and Jacobians of a batch on one thread.

    Args:
        chain: The `Chain`.
        joints: (N, dof), rad or m.
        poses: (N, 7) receives x y z, qw qx qy qz.
        jacobians: (N, 6, dof) receives the Jacobians.
    """
    R, p = np.empty((3, 3)), np.empty(3)
    for i in range(joints.shape[0]):
        tip_frame_and_jacobian(chain, joints[i], R, p, jacobians[i])
        poses[i, :3] = p
        quaternion_of(R, poses[i, 3:])


@njit(cache=True, parallel=True)
def poses_kernel_parallel(chain, joints, poses):  # type: ignore[no-untyped-def]
    """Compute `poses_kernel` on all threads of numba; the results are bitwise the same."""
    block = 1024
    for b in prange((joints.shape[0] + block - 1) // block):
        rows = slice(b * block, min((b + 1) * block, joints.shape[0]))
        poses_kernel(chain, joints[rows], poses[rows])


def forward_kinematics(chain: Chain, joints: Array, parallel: bool = False) -> Array:
    """Tip poses of a batch.

    Args:
        chain: The chain.
        joints: (N, dof), rad or m.
        parallel: Whether to use all threads of numba.

    Returns:
        (N, 7) x y z in m and the canonical quaternion qw qx qy qz.
    """
    poses = np.empty((len(joints), 7))
    (poses_kernel_parallel if parallel else poses_kernel)(chain, joints, poses)
    return poses


def poses_and_jacobians(chain: Chain, joints: Array) -> tuple[Array, Array]:
    """Tip poses (N, 7) and Jacobians (N, 6, dof) of a batch, on one thread.

    Args:
        chain: The chain.
        joints: (N, dof), rad or m.
    """
    poses = np.empty((len(joints), 7))
    jacobians = np.empty((len(joints), 6, joints.shape[1]))
    jacobians_kernel(chain, joints, poses, jacobians)
    return poses, jacobians
