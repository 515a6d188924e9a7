"""Answers of `Experts` as a CUDA kernel: poses in, hypotheses out, on the device.

A pass through a tensor library starts some thirty kernels, which for a hundred poses takes longer
than all descents from the answers. Here a block takes a pose: its threads find the cell, then each
computes neurons of a layer, reading weights side by side.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numba import cuda, types

from pipeline.learning.cycleik.compiled.activations import GELU_CUBE, GELU_SLOPE, tanh_rational
from pipeline.learning.cycleik.compiled.answers import find_features
from pipeline.learning.cycleik.experts import Experts, host
from pipeline.learning.networks import MATRIX_POSE_SIZE

THREADS = 128
WIDEST, MOST_EXPERTS = 512, 1024  # neurons of a layer and cells that fit into shared memory
# Where the parts of the array of constants begin.
CENTRE, SCALE, METRIC, JOINTS = 0, 3, 6, 18


class DeviceExperts:
    """A network on the current CUDA device.

    Args:
        network: The network.

    Attributes:
        heads: Hypotheses K for each pose.

    Raises:
        ValueError: It is too large for the shared memory of a block.
    """

    def __init__(self, network: Experts) -> None:
        folded = network.folded()
        sizes = [MATRIX_POSE_SIZE, *(bias.shape[1] for _, bias in folded)]
        centres = host(network.centres)
        if max(sizes) > WIDEST or len(centres) > MOST_EXPERTS:
            raise ValueError(
                f"expected at most {WIDEST} neurons in a layer and {MOST_EXPERTS} experts, got "
                f"{max(sizes)} and {len(centres)}"
            )
        self.heads, self.dof = network.heads, network.dof
        constants = (
            network.position_centre,
            network.position_scale,
            network.metric,
            network.joint_centre,
            network.joint_scale,
        )
        # Of each expert bias and weights of one layer after another.
        layers = [part.reshape(len(bias), -1) for weight, bias in folded for part in (bias, weight)]
        arrays = (
            np.concatenate([host(part) for part in constants]).astype(np.float32),
            centres.astype(np.float32),
            ((centres**2).sum(axis=1) / 2).astype(np.float32),
            np.array(sizes, dtype=np.int64),
            np.concatenate(layers, axis=1).astype(np.float32),
        )
        self._arrays = tuple(cuda.to_device(np.ascontiguousarray(array)) for array in arrays)

    def answer(self, poses: Any, joints: Any, launch: Callable[..., Any], blocks: int) -> None:
        """Write the hypotheses (N, K, dof) float64 for poses (N, 7) float64, both on the device.

        Args:
            poses: Targets with unit quaternions.
            joints: Receives the hypotheses in the order of the heads [rad or m].
            launch: Makes a kernel with a launch configuration, see `LmCuda.launch`.
            blocks: Blocks of threads, which take the poses in turn.
        """
        launch(_kernel(self.dof), blocks, THREADS)(*self._arrays, poses, joints)


@lru_cache
def _kernel(dof: int) -> Any:
    @cuda.jit
    def answer(reals, centres, half_squares, sizes, layers, poses, joints):  # type: ignore[no-untyped-def]
        lane, width = cuda.threadIdx.x, cuda.blockDim.x
        values = cuda.shared.array((2, WIDEST), types.float32)
        distances = cuda.shared.array(MOST_EXPERTS, types.float32)
        pose = cuda.local.array((1, 7), types.float64)
        features = cuda.local.array(12, types.float32)
        box = cuda.local.array((2, 3), types.float32)
        for i in range(3):
            box[0, i], box[1, i] = reals[CENTRE + i], reals[SCALE + i]
        half, one = np.float32(0.5), np.float32(1.0)
        slope, cube = np.float32(GELU_SLOPE), np.float32(GELU_CUBE)
        last = sizes.shape[0] - 2
        for row in range(cuda.blockIdx.x, poses.shape[0], cuda.gridDim.x):
            for i in range(7):
                pose[0, i] = poses[row, i]
            find_features(box, pose, 0, features, 0)
            for cell in range(lane, centres.shape[0], width):
                total = half_squares[cell]
                for k in range(12):
                    total -= features[k] * reals[METRIC + k] * centres[cell, k]
                distances[cell] = total
            for k in range(lane, sizes[0], width):
                values[0, k] = features[k]
            cuda.syncthreads()
            nearest = 0
            for cell in range(1, centres.shape[0]):
                if distances[cell] < distances[nearest]:
                    nearest = cell
            begin, source = 0, 0
            for layer in range(last + 1):
                n, m = sizes[layer], sizes[layer + 1]
                for j in range(lane, m, width):
                    total = layers[nearest, begin + j]
                    for k in range(n):
                        total += values[source, k] * layers[nearest, begin + m + k * m + j]
                    if layer < last:
                        inner = slope * (total + cube * total * total * total)
                        values[1 - source, j] = half * total * (one + tanh_rational(inner))
                    else:
                        k = j % dof
                        scaled = reals[JOINTS + dof + k] * tanh_rational(total)
                        joints[row, j // dof, k] = reals[JOINTS + k] + scaled
                begin += m + n * m
                source = 1 - source
                cuda.syncthreads()

    return answer
