"""Compiled forward kinematics and Jacobians of a `Chain`.

The device functions work on one configuration and on arrays that the caller owns, so that the
solvers of `baselines` can call them inside their own loops; the batched kernels loop over
configurations. Positions in m, angles in rad, everything in the base frame, float64.

Frames are the tuples of `robots.frames`.
"""

from __future__ import annotations

import numpy as np
from numba import prange
from numpy.typing import NDArray

from robots.chain import Chain
from robots.compiled import njit
from robots.frames import (
    constant_frame,
    moved,
    multiplied,
    quaternion_of,
    store_frame,
)
from robots.trigonometry import sine_cosine

Array = NDArray[np.float64]

# Configurations per pass over the sines and cosines; a multiple of every vector width.
BLOCK = 64
# Configurations per thread and turn: long enough to outweigh starting a thread.
PARALLEL_BLOCK = 1024


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def add_column(J, column, frame, prismatic, scale):  # type: ignore[no-untyped-def]
    """Add a joint to the Jacobian at the origin of the base, from its frame before it moves.

    Args:
        J: (6, dof), linear rows first.
        column: The variable that drives the joint.
        frame: Frame tuple of the joint, its axis is z.
        prismatic: Whether the joint slides.
        scale: Joint movement per movement of the variable.
    """
    zx, zy, zz = scale * frame[2], scale * frame[5], scale * frame[8]
    if prismatic:
        J[0, column] += zx
        J[1, column] += zy
        J[2, column] += zz
    else:
        x, y, z = frame[9], frame[10], frame[11]
        J[0, column] += y * zz - z * zy
        J[1, column] += z * zx - x * zz
        J[2, column] += x * zy - y * zx
        J[3, column] += zx
        J[4, column] += zy
        J[5, column] += zz


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def move_to_tip(J, x, y, z):  # type: ignore[no-untyped-def]
    """Turn a Jacobian at the origin of the base into the one at the point x, y, z, in place."""
    for column in range(J.shape[1]):
        wx, wy, wz = J[3, column], J[4, column], J[5, column]
        J[0, column] += wy * z - wz * y
        J[1, column] += wz * x - wx * z
        J[2, column] += wx * y - wy * x


@njit(fastmath={"contract"}, forceinline=True)
def tip_frame(chain, q, R, p):  # type: ignore[no-untyped-def]
    """Pose of the tip for one configuration.

    Args:
        chain: The `Chain`.
        q: (dof,) joint positions, rad or m.
        R: (3, 3) receives the rotation of the tip.
        p: (3,) receives the position of the tip, m.
    """
    frame = constant_frame(chain.rotations[0], chain.translations[0])
    for k in range(chain.prismatic.shape[0]):
        position = chain.multiplier[k] * q[chain.variable[k]] + chain.offset[k]
        sine, cosine = sine_cosine(position)
        frame = moved(frame, chain.prismatic[k], position, sine, cosine)
        frame = multiplied(frame, chain.rotations[k + 1], chain.translations[k + 1])
    store_frame(frame, R, p)


@njit(fastmath={"contract"}, forceinline=True)
def tip_frame_and_jacobian(chain, q, R, p, J):  # type: ignore[no-untyped-def]
    """Pose of the tip and its geometric Jacobian for one configuration.

    Column of a turning joint with axis z and origin o: (z x (p - o), z); of a sliding one: (z, 0)
    (Siciliano et al., "Robotics: Modelling, Planning and Control", section 3.1.3). It is summed
    up as z x p + o x z, so that nothing but J has to be remembered on the way to the tip.

    Args:
        chain: The `Chain`.
        q: (dof,) joint positions, rad or m.
        R: (3, 3) receives the rotation of the tip.
        p: (3,) receives the position of the tip, m.
        J: (6, dof) receives the Jacobian at the tip in axes of the base, linear rows first:
            J qdot = (velocity of the tip, angular velocity).
    """
    J[:] = 0.0
    frame = constant_frame(chain.rotations[0], chain.translations[0])
    for k in range(chain.prismatic.shape[0]):
        add_column(J, chain.variable[k], frame, chain.prismatic[k], chain.multiplier[k])
        position = chain.multiplier[k] * q[chain.variable[k]] + chain.offset[k]
        sine, cosine = sine_cosine(position)
        frame = moved(frame, chain.prismatic[k], position, sine, cosine)
        frame = multiplied(frame, chain.rotations[k + 1], chain.translations[k + 1])
    store_frame(frame, R, p)
    move_to_tip(J, p[0], p[1], p[2])


@njit(no_cpython_wrapper=True, fastmath={"contract"}, forceinline=True)
def joint_positions(chain, joints, positions, sines, cosines):  # type: ignore[no-untyped-def]
    """Positions of the m driven joints of a block of configurations, with sine and cosine.

    Args:
        chain: The `Chain`.
        joints: (N, dof), N at most `BLOCK`, rad or m.
        positions: (BLOCK m,) receives the joint positions, configuration by configuration.
        sines: (BLOCK m,) receives their sines.
        cosines: (BLOCK m,) receives their cosines.
    """
    m = chain.prismatic.shape[0]
    for i in range(joints.shape[0]):
        for k in range(m):
            value = joints[i, chain.variable[k]]
            positions[i * m + k] = chain.multiplier[k] * value + chain.offset[k]
    for j in range(joints.shape[0] * m):
        sines[j], cosines[j] = sine_cosine(positions[j])


@njit(fastmath={"contract"})
def poses_kernel(chain, joints, poses):  # type: ignore[no-untyped-def]
    """Tip poses of a batch on one thread.

    Args:
        chain: The `Chain`.
        joints: (N, dof), rad or m.
        poses: (N, 7) receives x y z, qw qx qy qz.
    """
    m = chain.prismatic.shape[0]
    positions, sines, cosines = np.empty(BLOCK * m), np.empty(BLOCK * m), np.empty(BLOCK * m)
    R = np.empty((3, 3))
    for start in range(0, joints.shape[0], BLOCK):
        stop = min(start + BLOCK, joints.shape[0])
        joint_positions(chain, joints[start:stop], positions, sines, cosines)
        for i in range(start, stop):
            frame = constant_frame(chain.rotations[0], chain.translations[0])
            for k in range(m):
                j = (i - start) * m + k
                frame = moved(frame, chain.prismatic[k], positions[j], sines[j], cosines[j])
                frame = multiplied(frame, chain.rotations[k + 1], chain.translations[k + 1])
            store_frame(frame, R, poses[i])
            quaternion_of(R, poses[i, 3:])


@njit(fastmath={"contract"})
def jacobians_kernel(chain, joints, poses, jacobians):  # type: ignore[no-untyped-def]
    """Tip poses and Jacobians of a batch on one thread.

    Args:
        chain: The `Chain`.
        joints: (N, dof), rad or m.
        poses: (N, 7) receives x y z, qw qx qy qz.
        jacobians: (N, 6, dof) receives the Jacobians.
    """
    m = chain.prismatic.shape[0]
    positions, sines, cosines = np.empty(BLOCK * m), np.empty(BLOCK * m), np.empty(BLOCK * m)
    R = np.empty((3, 3))
    jacobians[:] = 0.0
    for start in range(0, joints.shape[0], BLOCK):
        stop = min(start + BLOCK, joints.shape[0])
        joint_positions(chain, joints[start:stop], positions, sines, cosines)
        for i in range(start, stop):
            J = jacobians[i]
            frame = constant_frame(chain.rotations[0], chain.translations[0])
            for k in range(m):
                j = (i - start) * m + k
                add_column(J, chain.variable[k], frame, chain.prismatic[k], chain.multiplier[k])
                frame = moved(frame, chain.prismatic[k], positions[j], sines[j], cosines[j])
                frame = multiplied(frame, chain.rotations[k + 1], chain.translations[k + 1])
            store_frame(frame, R, poses[i])
            quaternion_of(R, poses[i, 3:])
            move_to_tip(J, poses[i, 0], poses[i, 1], poses[i, 2])


@njit(parallel=True)
def poses_kernel_parallel(chain, joints, poses):  # type: ignore[no-untyped-def]
    """Compute `poses_kernel` on all threads of numba; the results are bitwise the same."""
    for b in prange((joints.shape[0] + PARALLEL_BLOCK - 1) // PARALLEL_BLOCK):
        stop = min((b + 1) * PARALLEL_BLOCK, joints.shape[0])
        rows = slice(b * PARALLEL_BLOCK, stop)
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
