"""Compiled answers of `Experts`: poses in, hypotheses out, best first, on processors.

A call of a tensor library costs more than all arithmetic of a small network. Here one compiled pass
finds the cell of every pose, sorts poses by cell so that the weights of an expert stay in cache,
takes four poses at a time through its layers, and ranks the hypotheses by forward kinematics.

Every number of a row is computed by the same operations in the same order whatever rows stand
around it, so an answer does not depend on the batch.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.cycleik.layers_kernel import (
    DEPTH,
    FAST,
    ROWS,
    gelu_rows,
    linear_rows,
    tanh_rows,
)
from pipeline.learning.networks import MATRIX_POSE_SIZE
from robots.kinematics import tip_frame
from robots.rows import copy_row

Array32 = NDArray[np.float32]

PASSED = 16  # cells of poses a thread takes in turn: enough to even out their sizes


class CompiledExperts(NamedTuple):
    """The arrays of an `Experts` network as the kernel takes them, float32.

    Attributes:
        position_centre: (3,) middle of the workspace box [m].
        position_scale: (3,) half its size [m].
        centres: (E, 12) centres of the cells in the metric of the cells.
        metric: (12,) that metric.
        half_squares: (E,) half the squared length of each centre.
        sizes: (L + 1,) width of the input and of each layer, inputs of layers as multiples of
            `DEPTH`.
        layers: (E, size) for each expert its layers one after another, bias and then weights.
        joint_centre: (dof,) middle of the limits [rad or m].
        joint_scale: (dof,) half their distance.
    """

    position_centre: Array32
    position_scale: Array32
    centres: Array32
    metric: Array32
    half_squares: Array32
    sizes: NDArray[np.int64]
    layers: Array32
    joint_centre: Array32
    joint_scale: Array32


def compiled_experts(network: Experts) -> CompiledExperts:
    """Return the arrays of a network, with the scaling of its inputs folded into the weights."""

    def array(tensor: Any) -> Array32:
        return np.ascontiguousarray(tensor.detach().cpu().numpy(), dtype=np.float32)

    blocks, sizes = [], [MATRIX_POSE_SIZE + -MATRIX_POSE_SIZE % DEPTH]
    folded = network.folded()
    for index, (weight, bias) in enumerate(folded):
        missing = sizes[-1] - weight.shape[1]
        more = 0 if index == len(folded) - 1 else -weight.shape[2] % DEPTH
        padded = np.pad(weight, ((0, 0), (0, missing), (0, more)))
        blocks += [np.pad(bias, ((0, 0), (0, more))), padded.reshape(len(padded), -1)]
        sizes.append(padded.shape[2])
    centres = array(network.centres)
    return CompiledExperts(
        array(network.position_centre),
        array(network.position_scale),
        centres,
        array(network.metric),
        (centres.astype(np.float64) ** 2).sum(axis=1).astype(np.float32) / np.float32(2),
        np.array(sizes, dtype=np.int64),
        np.ascontiguousarray(np.concatenate(blocks, axis=1), dtype=np.float32),
        array(network.joint_centre),
        array(network.joint_scale),
    )


@njit(cache=True)
def find_features(experts, pose, features):  # type: ignore[no-untyped-def]
    """Write what the experts see of a pose (7,), the scaled position and the rotation matrix."""
    for axis in range(3):
        shift = pose[axis] - experts.position_centre[axis]
        features[axis] = shift / experts.position_scale[axis]
    w, x, y, z = pose[3], pose[4], pose[5], pose[6]
    features[3] = 1 - 2 * (y * y + z * z)
    features[4] = 2 * (x * y - w * z)
    features[5] = 2 * (x * z + w * y)
    features[6] = 2 * (x * y + w * z)
    features[7] = 1 - 2 * (x * x + z * z)
    features[8] = 2 * (y * z - w * x)
    features[9] = 2 * (x * z - w * y)
    features[10] = 2 * (y * z + w * x)
    features[11] = 1 - 2 * (x * x + y * y)


@njit(cache=True, no_cpython_wrapper=True, fastmath=FAST)
def find_cell(experts, features):  # type: ignore[no-untyped-def]
    """Return the nearest cell of features (12,)."""
    nearest, least = 0, np.float32(np.inf)
    for cell in range(experts.centres.shape[0]):
        total = experts.half_squares[cell]
        for k in range(12):
            total -= features[k] * experts.metric[k] * experts.centres[cell, k]
        if total < least:
            nearest, least = cell, total
    return nearest


@njit(cache=True, no_cpython_wrapper=True)
def _through(experts, cell, first, second):  # type: ignore[no-untyped-def]
    """Take the four rows in `first` through an expert; returns the array with the result."""
    packed = experts.layers[cell]
    count = experts.sizes.shape[0] - 1
    begin = 0
    for layer in range(count):
        n, m = experts.sizes[layer], experts.sizes[layer + 1]
        bias = packed[begin : begin + m]
        weight = packed[begin + m : begin + m + n * m].reshape((n, m))
        begin += m + n * m
        linear_rows(first, weight, bias, second)
        if layer < count - 1:
            gelu_rows(second, m)
        else:
            tanh_rows(second, m)
        first, second = second, first
    return first


@njit(cache=True, no_cpython_wrapper=True)
def _rank(chain, experts, pose, output, weights, joints, errors, scratch):  # type: ignore[no-untyped-def]
    """Unpack the heads of one pose and sort them by error, best first.

    Args:
        chain: The robot's `Chain`.
        experts: Gives the scale of the joints.
        pose: (7,) target.
        output: (K dof,) in [-1, 1].
        weights: (2,) of an error in m and in rad when hypotheses are compared.
        joints: (K, dof) receives the hypotheses.
        errors: (K, 2) receives distance [m] and angle [rad] of each.
        scratch: A goal (3, 3), a rotation (3, 3), a position (3,), joints (dof,).
    """
    goal, R, p, q = scratch
    heads, dof = joints.shape
    for head in range(heads):
        for k in range(dof):
            value = experts.joint_centre[k] + experts.joint_scale[k] * output[head * dof + k]
            q[k] = min(max(np.float64(value), chain.lower[k]), chain.upper[k])
        tip_frame(chain, q, R, p)
        distance2 = chord2 = 0.0
        for i in range(3):
            distance2 += (p[i] - pose[i]) ** 2
            for j in range(3):
                chord2 += (R[i, j] - goal[i, j]) ** 2
        distance = np.sqrt(distance2)
        # |R - G|² = 8 sin²(angle / 2) for rotations R and G.
        angle = 2 * np.arcsin(min(np.sqrt(chord2 / 8), 1.0))
        cost = weights[0] * distance + weights[1] * angle
        place = head
        while place > 0 and cost < (
            weights[0] * errors[place - 1, 0] + weights[1] * errors[place - 1, 1]
        ):
            copy_row(errors[place - 1], errors[place])
            copy_row(joints[place - 1], joints[place])
            place -= 1
        errors[place, 0], errors[place, 1] = distance, angle
        copy_row(q, joints[place])


@njit(cache=True, no_cpython_wrapper=True)
def _answer_cells(chain, experts, poses, rows, starts, cells, weights, joints, errors):  # type: ignore[no-untyped-def]
    """Answer the poses of some cells; rows[starts[c] : starts[c + 1]] are those of cell c."""
    widest = experts.sizes.max()
    first = np.zeros((ROWS, widest), dtype=np.float32)
    second = np.zeros((ROWS, widest), dtype=np.float32)
    features = np.zeros(12)  # in float64: errors are measured against the goal in it
    goal = np.empty((3, 3))
    scratch = (goal, np.empty((3, 3)), np.empty(3), np.empty(joints.shape[2]))
    for cell in cells:
        for begin in range(starts[cell], starts[cell + 1], ROWS):
            count = min(ROWS, starts[cell + 1] - begin)
            for i in range(count):
                find_features(experts, poses[rows[begin + i]], features)
                copy_row(features, first[i, :12])
                first[i, 12:16] = 0.0
            output = _through(experts, cell, first, second)
            for i in range(count):
                row = rows[begin + i]
                pose = poses[row]
                find_features(experts, pose, features)
                for k in range(9):
                    goal[k // 3, k % 3] = features[3 + k]
                _rank(chain, experts, pose, output[i], weights, joints[row], errors[row], scratch)


@njit(cache=True, no_cpython_wrapper=True)
def _sorted_by_cell(experts, poses):  # type: ignore[no-untyped-def]
    """Return the rows of poses in the order of their cells and where each cell starts."""
    count, cells = poses.shape[0], experts.centres.shape[0]
    cell = np.empty(count, dtype=np.int32)
    starts = np.zeros(cells + 1, dtype=np.int64)
    features = np.empty(12, dtype=np.float32)
    for row in range(count):
        find_features(experts, poses[row], features)
        cell[row] = find_cell(experts, features)
        starts[cell[row] + 1] += 1
    for c in range(cells):
        starts[c + 1] += starts[c]
    rows = np.empty(count, dtype=np.int64)
    filled = starts.copy()
    for row in range(count):
        rows[filled[cell[row]]] = row
        filled[cell[row]] += 1
    return rows, starts


@njit(cache=True)
def answer_rows(chain, experts, poses, weights, joints, errors):  # type: ignore[no-untyped-def]
    """Answer poses on one thread.

    Args:
        chain: The robot's `Chain`.
        experts: `CompiledExperts`.
        poses: (N, 7) targets, unit quaternions.
        weights: (2,) of an error in m and in rad when hypotheses are compared.
        joints: (N, K, dof) receives the hypotheses, best first [rad or m].
        errors: (N, K, 2) receives distance [m] and angle [rad].
    """
    rows, starts = _sorted_by_cell(experts, poses)
    cells = np.flatnonzero(starts[1:] > starts[:-1])
    _answer_cells(chain, experts, poses, rows, starts, cells, weights, joints, errors)


@njit(cache=True, parallel=True)
def answer_rows_parallel(chain, experts, poses, weights, joints, errors):  # type: ignore[no-untyped-def]
    """Compute `answer_rows` on all threads of numba; the same bits."""
    rows, starts = _sorted_by_cell(experts, poses)
    cells = np.flatnonzero(starts[1:] > starts[:-1])
    for part in prange(PASSED):
        _answer_cells(
            chain, experts, poses, rows, starts, cells[part::PASSED], weights, joints, errors
        )
