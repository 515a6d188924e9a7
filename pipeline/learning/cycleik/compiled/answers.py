"""Compiled answers of `Experts`: poses in, hypotheses out, best first, on processors.

A call of a tensor library costs more than all arithmetic of a small network. Here one compiled pass
finds the cell of every pose, sorts poses by cell so that the weights of an expert stay in cache,
takes the poses of a cell through its layers, and ranks the hypotheses by forward kinematics.

Every number of a row is computed by the same operations in the same order whatever rows stand
around it, so an answer does not depend on the batch.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from pipeline.learning.cycleik.compiled.activations import gelu_values, tanh_values
from pipeline.learning.cycleik.compiled.products import VECTOR, linear, pack_layer
from pipeline.learning.cycleik.compiled.ranking import (
    ERRORS,
    FRAME,
    LANES,
    measure_outputs,
    rank_lanes,
)
from pipeline.learning.cycleik.experts import Experts, host
from pipeline.learning.networks import MATRIX_POSE_SIZE
from robots.chain import Chain
from robots.compiled import njit
from robots.threads import on_threads, shares

Array = NDArray[np.float64]
Array32 = NDArray[np.float32]
Real = NDArray[np.floating]  # float32 or float64

# Poses that go through the layers together: a multiple of the rows of a tile on any processor.
CHUNK = 60
SHARE = 250  # poses that are worth a thread, whose start takes as long as some thirty of them
ALIGNMENT = 64  # bytes of a cache line, which no load of weights is to cross


class CompiledExperts(NamedTuple):
    """The arrays of an `Experts` network as the kernel takes them.

    Attributes:
        box: (2, 3) float32, middle of the workspace box and half its size [m].
        gate: A layer whose outputs are the distances to the cells, see `pack_layer`.
        means: (E, 12) subtracted from the inputs of an expert: in float64, because a cell may be
            so small that the differences have few digits left in float32.
        sizes: (L + 1,) width of the input and of each layer, a multiple of `VECTOR`.
        widest: The largest of them.
        layers: (E size,) for each expert its layers one after another. Gate and layers are float32
            or float64, in which they compute.
        scaling: (2, dof) float64, middle of the limits and half their distance [rad or m].
        heads: Hypotheses of an expert.
    """

    box: Array32
    gate: Real
    means: Array
    sizes: NDArray[np.int64]
    widest: int
    layers: Real
    scaling: Array
    heads: int


class Work(NamedTuple):
    """Arrays that a call works in.

    Attributes:
        values: Inputs and outputs of a layer for a chunk of poses, of the layers' type.
        order: (2, N) cell of each pose, and rows in the order of their cells.
        starts: (E + 1,) where in that order a cell begins.
        features: (12,) of a pose.
        joints: Hypotheses of a chunk of poses in lanes [rad or m].
        errors: Their errors.
        goals: Targets of a block of lanes.
        frames: Tips of a block of lanes.
    """

    values: Real
    order: NDArray[np.int64]
    starts: NDArray[np.int64]
    features: Array
    joints: Array
    errors: Array
    goals: Array
    frames: Array


def compiled_experts(network: Experts, dtype: DTypeLike) -> CompiledExperts:
    """Return the arrays of a network, with the scaling of its inputs folded into the weights.

    Args:
        network: Whose weights they are.
        dtype: float32 or float64, in which the layers compute.
    """
    blocks, sizes = [], [MATRIX_POSE_SIZE]
    for weight, bias in network.folded(centred=True):
        missing, more = sizes[-1] - weight.shape[1], -weight.shape[2] % VECTOR
        padded = np.pad(weight, ((0, 0), (0, missing), (0, more)))
        blocks.append(pack_layer(padded, np.pad(bias, ((0, 0), (0, more))), dtype))
        sizes.append(padded.shape[2])
    return CompiledExperts(
        np.stack([host(network.position_centre), host(network.position_scale)]).astype("f4"),
        _gate(network, dtype),
        host(network.mean),
        np.array(sizes, dtype=np.int64),
        max(sizes),
        _aligned(np.concatenate(blocks, axis=1).ravel()),
        np.stack([host(network.joint_centre), host(network.joint_scale)]),
        network.heads,
    )


def _gate(network: Experts, dtype: DTypeLike) -> Real:
    """Half the squared distance of features to each centre, without what all cells share."""
    centres = host(network.centres)
    weight = -(centres * host(network.metric)).T
    half_squares = (centres**2).sum(axis=1) / 2
    more = -len(centres) % VECTOR
    far = np.pad(half_squares, (0, more), constant_values=np.finfo(np.float32).max)
    return _aligned(pack_layer(np.pad(weight, ((0, 0), (0, more)))[None], far[None], dtype)[0])


def _aligned(array: Real) -> Real:
    """Return a copy that begins with a cache line."""
    size = array.itemsize
    room = np.empty(array.size + ALIGNMENT // size, dtype=array.dtype)
    begin = -room.ctypes.data % ALIGNMENT // size
    copy = room[begin : begin + array.size].reshape(array.shape)
    copy[:] = array
    return copy


@njit(_nrt=False)
def find_features(box, poses, row, features, begin):  # type: ignore[no-untyped-def]
    """Write what the experts see of a pose, the scaled position and the rotation matrix.

    Args:
        box: (2, 3) middle of the workspace box and half its size [m].
        poses: (N, 7).
        row: Of the pose.
        features: Flat, receives 12 numbers.
        begin: Where in it.
    """
    for axis in range(3):
        features[begin + axis] = (poses[row, axis] - box[0, axis]) / box[1, axis]
    w, x, y, z = poses[row, 3], poses[row, 4], poses[row, 5], poses[row, 6]
    features[begin + 3] = 1 - 2 * (y * y + z * z)
    features[begin + 4] = 2 * (x * y - w * z)
    features[begin + 5] = 2 * (x * z + w * y)
    features[begin + 6] = 2 * (x * y + w * z)
    features[begin + 7] = 1 - 2 * (x * x + z * z)
    features[begin + 8] = 2 * (y * z - w * x)
    features[begin + 9] = 2 * (x * z - w * y)
    features[begin + 10] = 2 * (y * z + w * x)
    features[begin + 11] = 1 - 2 * (x * x + y * y)


@njit(inline="always")
def _nearest(distances, begin, count):  # type: ignore[no-untyped-def]
    """Return the index of the smallest of some distances, the first of equal ones."""
    nearest, least = 0, distances[begin]
    for cell in range(1, count):
        if distances[begin + cell] < least:
            nearest, least = cell, distances[begin + cell]
    return nearest


@njit(inline="always")
def _sort_rows(order, starts):  # type: ignore[no-untyped-def]
    """Write into order[1] the rows in the order of their cells, which order[0] holds."""
    cells = starts.shape[0] - 1
    for cell in range(cells + 1):
        starts[cell] = 0
    for row in range(order.shape[1]):
        starts[order[0, row] + 1] += 1
    for cell in range(cells):
        starts[cell + 1] += starts[cell]
    for row in range(order.shape[1]):
        cell = order[0, row]
        order[1, starts[cell]] = row
        starts[cell] += 1


@njit(_nrt=False)
def _find_cells(experts, poses, nearer, work):  # type: ignore[no-untyped-def]
    """Sort poses (N, 7) by their cells, into work.order; so many cells are nearer to each."""
    box, gate, values, order = experts.box, experts.gate, work.values, work.order
    depth, (count, place) = experts.means.shape[1], (poses.shape[0], values.shape[0] // 2)
    width = gate.shape[0] // (depth + 1)
    for begin in range(0, count, CHUNK):
        some = min(CHUNK, count - begin)
        for i in range(some):
            find_features(box, poses, begin + i, values, i * depth)
        linear(values, np.int64(0), some, depth, gate, np.int64(0), width, place)
        for i in range(some):
            at = place + i * width
            for _ in range(nearer):
                values[at + _nearest(values, at, width)] = np.inf
            order[0, begin + i] = _nearest(values, at, width)
    _sort_rows(order, work.starts)


@njit(inline="always")
def _run_layers(experts, cell, poses, begin, end, work):  # type: ignore[no-untyped-def]
    """Take sorted rows of poses through the expert of a cell; returns where the outputs begin."""
    box, means, sizes, layers = experts.box, experts.means, experts.sizes, experts.layers
    values, order, features, half = (
        work.values,
        work.order,
        work.features,
        work.values.shape[0] // 2,
    )
    depth, last = means.shape[1], sizes.shape[0] - 2
    for i in range(end - begin):
        find_features(box, poses, order[1, begin + i], features, np.int64(0))
        for k in range(depth):
            values[i * depth + k] = features[k] - means[cell, k]
    source, place = cell * (layers.shape[0] // means.shape[0]), np.int64(0)
    for layer in range(last + 1):
        n, m = sizes[layer], sizes[layer + 1]
        # Inputs and outputs take turns in the two halves.
        linear(values, place, end - begin, n, layers, source, m, half - place)
        source, place = source + (n + 1) * m, half - place
        if layer < last:
            gelu_values(values, place, place + (end - begin) * m)
        else:
            tanh_values(values, place, place + (end - begin) * m)
    return place


@njit(_nrt=False)
def answer(chain, experts, poses, weights, nearer, joints, errors, work):  # type: ignore[no-untyped-def]
    """Answer poses, see `answer_rows`, in arrays of the caller: `make_work(experts, N)`."""
    _find_cells(experts, poses, nearer, work)
    order, sizes = work.order, experts.sizes
    count, heads, width = poses.shape[0], experts.heads, sizes[sizes.shape[0] - 1]
    begin = np.int64(0)
    while begin < count:
        cell, end = order[0, order[1, begin]], begin + 1
        while end < min(begin + CHUNK, count) and order[0, order[1, end]] == cell:
            end += 1
        place = _run_layers(experts, cell, poses, begin, end, work)
        measure_outputs(
            chain, experts.scaling, poses, order, begin, end, heads,
            work.values, place, width, weights, work,
        )  # fmt: skip
        rank_lanes(order, begin, end, heads, work, joints, errors)
        begin = end


@njit()
def make_work(experts, count):  # type: ignore[no-untyped-def]
    """Return `Work` for so many poses."""
    cells, depth = experts.means.shape
    widest, most = max(experts.gate.shape[0] // (depth + 1), experts.widest), min(CHUNK, count)
    lanes = (most * experts.heads + LANES - 1) // LANES * LANES
    return Work(
        np.empty(2 * most * widest, dtype=experts.layers.dtype),
        np.empty((2, count), dtype=np.int64),
        np.empty(cells + 1, dtype=np.int64),
        np.empty(depth),
        # What nobody has written is computed too.
        np.zeros(experts.scaling.shape[1] * lanes),
        np.empty(ERRORS * lanes),
        np.zeros(FRAME * LANES),
        np.empty(FRAME * LANES),
    )


@njit(nogil=True)
def answer_rows(chain, experts, poses, weights, nearer, joints, errors):  # type: ignore[no-untyped-def]
    """Answer poses on one thread; other threads of Python run meanwhile.

    Args:
        chain: The robot's `Chain`.
        experts: `CompiledExperts`.
        poses: (N, 7) targets, unit quaternions.
        weights: (2,) of an error in m and in rad when hypotheses are compared.
        nearer: Cells that are nearer to a pose than the one whose expert answers it: 0, or less
            than there are cells.
        joints: (N, K, dof) receives the K best hypotheses, the best first [rad or m].
        errors: (N, K, 2) receives distance [m] and angle [rad].
    """
    work = make_work(experts, poses.shape[0])
    answer(chain, experts, poses, weights, nearer, joints, errors, work)


@njit()
def in_domain(experts, pose):  # type: ignore[no-untyped-def]
    """Whether a pose (7,) lies in the box that the network was trained in."""
    for axis in range(3):
        shift = pose[axis] - experts.box[0, axis]
        if not abs(shift / experts.box[1, axis]) <= 1.0:
            return False
    return True


@njit(nogil=True)
def seed_rows(chain, experts, poses, weights, home, seeds):  # type: ignore[no-untyped-def]
    """Write the best hypotheses of poses as seeds, and home for poses outside the network's box.

    Args:
        chain: The robot's `Chain`.
        experts: `CompiledExperts`.
        poses: (N, 7) targets, unit quaternions.
        weights: (2,) of an error in m and in rad when hypotheses are compared.
        home: (dof,) [rad or m].
        seeds: (N, K, dof) receives the K best of each pose, the best first [rad or m].
    """
    count, wanted = poses.shape[0], seeds.shape[1]
    inside = np.empty(count, dtype=np.int64)
    known = 0
    for row in range(count):
        if in_domain(experts, poses[row]):
            inside[known] = row
            known += 1
        else:
            seeds[row] = home
    errors = np.empty((known, wanted, 2))
    if known == count:
        answer_rows(chain, experts, poses, weights, 0, seeds, errors)
    elif known > 0:
        some = np.empty((known, wanted, home.shape[0]))
        answer_rows(chain, experts, poses[inside[:known]], weights, 0, some, errors)
        seeds[inside[:known]] = some


def answer_on_threads(
    count: int, chain: Chain, experts: CompiledExperts, poses: Array, weights: Array,
    nearer: int, joints: Array, errors: Array,
) -> None:  # fmt: skip
    """Compute `answer_rows` on so many threads, each with a share of the poses; the same bits."""
    parts = shares(len(poses), count, SHARE)

    def answer(index: int) -> None:
        rows = parts[index]
        answer_rows(chain, experts, poses[rows], weights, nearer, joints[rows], errors[rows])

    on_threads(len(parts), answer)
