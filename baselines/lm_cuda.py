"""Levenberg-Marquardt on an NVIDIA device: poses and seeds in, joints out.

Poses, seeds and answers may stay on the device, where a network or a planner works on with them:
whatever has `__cuda_array_interface__`, as torch's tensors do, is taken without a copy.
"""

from __future__ import annotations

import time
import warnings
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.errors import SettingError
from baselines.lm_kernel import LmOptions
from baselines.refine import Refined
from baselines.seed_library import SeedLibrary, empty_seed_library

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

MAPPINGS = ("auto", "lane", "block")
THREADS = 64  # of a block where each has a pose of its own
# Blocks that a multiprocessor holds of either kind: each thread takes all registers it can get.
LANE_BLOCKS, BLOCK_BLOCKS = 4, 16
# Poses up to which a block works at each; above, the device is full with a thread a pose.
MAX_BLOCK_POSES = 4096


def skip() -> str | None:
    """Say why there is no solving on a device here, or None if there is one."""
    try:
        from numba import cuda
    except ImportError as error:
        return f"not installed: {error.name}"
    return None if cuda.is_available() else "numba sees no CUDA device"


class DeviceAnswers(NamedTuple):
    """Arrays on the device that hold until the next call.

    Attributes:
        joints: (N, dof) best joints met, inside the limits [rad or m].
        facts: (3, N) status, iterations and starts, integers as float64; see `Refined`. Where
            the threads of a block share a pose, iterations are those of all of them.
    """

    joints: Any
    facts: Any


class _DeviceBuffers:
    """Arrays on the device for a number of poses, kept from call to call."""

    def __init__(self, count: int, dof: int, near: int) -> None:
        from numba import cuda

        self.poses = cuda.device_array((count, 7), dtype=np.float64)
        self.answers = cuda.device_array(count * (dof + 3), dtype=np.float64)
        self.joints = self.answers[: count * dof].reshape((count, dof))
        self.facts = self.answers[count * dof :].reshape((3, count))
        self.host = cuda.pinned_array(count * (dof + 3), dtype=np.float64)
        self.least = cuda.device_array(count, dtype=np.float64)
        self.left = cuda.device_array(count, dtype=np.int32)
        self.near = cuda.device_array((count, near), dtype=np.int32)
        self.graphs: dict[Any, Any] = {}


class LmCuda:
    """Levenberg-Marquardt of one robot on the current CUDA device.

    Args:
        robot: The robot.
        options: Tolerances, damping and budget; no time limit.
        library: Configurations to start from after the seeds.
        mapping: What works at a pose: lane (a thread, as on the CPU), block (the threads of a
            block, each from a start of its own), or auto: a block where poses are few.
        lanes: Threads of a block that work at one pose, a multiple of 32.
        near: Remembered configurations that a lane tries before it leaves the pose to a block.
        captured: Record the launches for a number of poses at the second call and replay them from
            then on, which spares the host most of its time; by torch, and not for seeds that are
            handed over.

    Raises:
        SettingError: A setting that is none, or there is no device.
    """

    def __init__(
        self,
        robot: Robot,
        options: LmOptions,
        library: SeedLibrary | None = None,
        mapping: str = "auto",
        lanes: int = 32,
        near: int = 2,
        captured: bool = False,
    ) -> None:
        if reason := skip():
            raise SettingError(f"device cuda was requested, but {reason}: use cpu")
        from numba import cuda

        from baselines import lm_cuda_kernels
        from baselines.lm_cuda_block import MAX_LANES
        from baselines.lm_cuda_device import COUNTERS, packed_constants

        if mapping not in MAPPINGS:
            raise SettingError(f"expected a mapping of {', '.join(MAPPINGS)}, got {mapping!r}")
        if not 1 <= lanes <= MAX_LANES:
            raise SettingError(f"expected 1 to {MAX_LANES} lanes a pose, got {lanes}")
        if options.time_ns > 0:
            raise SettingError("a CUDA device takes a budget of iterations only, got time_s")
        library = empty_seed_library(robot.dof) if library is None else library
        self.dof, self.mapping, self.lanes = robot.dof, mapping, lanes
        self._turned = robot.nearest_turns
        self.captured = captured
        self.remembers = len(library.joints) > 0
        self.near = min(near, lm_cuda_kernels.WARP)
        self._warp, self._cuda = lm_cuda_kernels.WARP, cuda
        self._kernels = lm_cuda_kernels.kernels(len(robot.chain.prismatic), robot.dof)
        reals, integers = packed_constants(robot.chain, options, library)
        self._constants = cuda.to_device(reals), cuda.to_device(integers)
        known = library.joints if self.remembers else np.zeros((1, robot.dof))
        features = library.features if self.remembers else np.zeros((1, 1), dtype=np.float32)
        self._known = cuda.to_device(np.ascontiguousarray(known))
        self._features = cuda.to_device(np.ascontiguousarray(features))
        self._counters = cuda.to_device(np.zeros(COUNTERS, dtype=np.int32))
        self._no_seeds = cuda.to_device(np.zeros((1, 1, robot.dof)))
        self._home = cuda.to_device(np.ascontiguousarray(robot.home, np.float64)[None, None])
        # The simulator of numba knows no device.
        device = getattr(cuda, "get_current_device", object)()
        self._processors = getattr(device, "MULTIPROCESSOR_COUNT", 1)
        self._kept_buffers: dict[int, _DeviceBuffers] = {}
        self._launches: dict[Any, Any] = {}
        self._stream: Any = 0

    def solve(self, poses: Any, seeds: Any = None, home: bool = False) -> Refined:
        """Solve poses and bring the answers to the host.

        Args:
            poses: (N, 7) float64 targets in the base frame, x y z in m, then unit qw qx qy qz; on
                the host or on the device.
            seeds: (N, K, dof) float64 configurations to start from first, in order, or
                (1, K, dof) for all poses; or what makes an array on the device of the poses on
                the device, and says how many of the K are tried.
            home: Start from the robot's home where no seeds are given.
        """
        began = time.perf_counter()
        count = len(poses)
        if count == 0:
            return self._refined(np.empty((0, self.dof)), np.empty((3, 0)), 0.0)
        self.solve_on_device(poses, seeds, home)
        buffers = self._kept_buffers[count]
        buffers.answers.copy_to_host(buffers.host)
        joints = buffers.host[: count * self.dof].reshape(count, self.dof).copy()
        facts = buffers.host[count * self.dof :].reshape(3, count)
        return self._refined(joints, facts, time.perf_counter() - began)

    def solve_on_device(self, poses: Any, seeds: Any = None, home: bool = False) -> DeviceAnswers:
        """Start solving poses; the answers are there when the device has come so far.

        Arguments are those of `solve`; N > 0.
        """
        count = len(poses)
        buffers = self._buffers_for(count)
        if not self.captured or not (seeds is None or callable(seeds)):
            targets = self._on_device(poses, buffers.poses)
            return self._descend(buffers, targets, seeds, home)
        if hasattr(poses, "__cuda_array_interface__"):
            poses = self._on_device(poses)
        else:
            poses = np.ascontiguousarray(poses, dtype=np.float64)
        buffers.poses.copy_to_device(poses)
        key = home, id(seeds)
        if key not in buffers.graphs:
            buffers.graphs[key] = None  # the first call compiles
            return self._descend(buffers, buffers.poses, seeds, home)
        if buffers.graphs[key] is None:
            buffers.graphs[key] = self._capture(buffers, seeds, home)
        buffers.graphs[key].replay()
        return DeviceAnswers(buffers.joints, buffers.facts)

    def _capture(self, buffers: _DeviceBuffers, seeds: Any, home: bool) -> Any:
        """Record the launches for the poses in some buffers."""
        import torch

        graph = torch.cuda.CUDAGraph()
        torch.cuda.synchronize()
        with torch.cuda.graph(graph, capture_error_mode="relaxed"):
            stream = torch.cuda.current_stream().cuda_stream
            self._stream = self._cuda.external_stream(stream)
            try:
                self._descend(buffers, buffers.poses, seeds, home)
            finally:
                self._stream = 0
        return graph

    def _descend(
        self, buffers: _DeviceBuffers, targets: Any, seeds: Any, home: bool
    ) -> DeviceAnswers:
        """Start all kernels for targets on the device."""
        count = len(targets)
        if seeds is None:
            seeds, given = (self._home, 1) if home else (self._no_seeds, 0)
        elif callable(seeds):
            seeds, given = seeds(targets)
        else:
            seeds = self._on_device(seeds)
            given = seeds.shape[1]
        kernels = self._kernels
        if self.mapping_for(count) == "block":
            self._by_block(buffers, targets, seeds, given, False, count)
            return DeviceAnswers(buffers.joints, buffers.facts)
        blocks = min(count, 8 * self._processors)
        self.launch(kernels.prepare, blocks, self._warp)(
            *self._constants, targets, self._features, buffers.near, self._counters
        )
        # By lanes alone all starts are tried, otherwise as many as most poses need.
        starts = given + self.near if self.mapping == "auto" and self.remembers else 2**62
        blocks = min(-(-count // THREADS), LANE_BLOCKS * self._processors)
        self.launch(kernels.by_lane, blocks, THREADS)(
            *self._constants,
            targets,
            seeds,
            given,
            self._known,
            buffers.near,
            starts,
            buffers.joints,
            buffers.least,
            buffers.facts,
            buffers.left,
            self._counters,
        )
        if starts < 2**62:
            self._by_block(buffers, targets, seeds, given, True, count)
        return DeviceAnswers(buffers.joints, buffers.facts)

    def mapping_for(self, count: int) -> str:
        """What works at a pose in a batch of `count`: lane (at first) or block."""
        if self.mapping == "auto":
            return "block" if count <= MAX_BLOCK_POSES else "lane"
        return self.mapping

    def blocks_for(self, count: int) -> int:
        """Blocks that keep the device busy where each takes `count` poses in turn."""
        return min(count, BLOCK_BLOCKS * self._processors)

    def launch(self, kernel: Any, blocks: int, threads: int) -> Any:
        """Return a kernel with its launch configuration."""
        if self._stream != 0:
            return kernel[blocks, threads, self._stream]
        key = kernel, blocks, threads
        if key not in self._launches:
            with warnings.catch_warnings():
                # A single pose cannot fill a device, and numba would say so.
                warnings.simplefilter("ignore")
                self._launches[key] = kernel[blocks, threads]
        return self._launches[key]

    def new_array(self, shape: tuple[int, ...]) -> Any:
        """Allocate float64 numbers on the device."""
        return self._cuda.device_array(shape, dtype=np.float64)

    def rank(self, poses: Any, seeds: Any, position_weight: float, rotation_weight: float) -> None:
        """Sort seeds on the device in place, the smallest error first, moved into the limits.

        Args:
            poses: (N, 7) float64, on the device.
            seeds: (N, K, dof) float64 on the device, K up to 16.
            position_weight: Of an error in m.
            rotation_weight: Of an error in rad.
        """
        blocks = -(-len(poses) // THREADS)
        self.launch(self._kernels.rank, blocks, THREADS)(
            *self._constants,
            self._on_device(poses),
            self._on_device(seeds),
            position_weight,
            rotation_weight,
        )

    def _by_block(
        self,
        buffers: _DeviceBuffers,
        targets: Any,
        seeds: Any,
        given: int,
        chosen: bool,
        count: int,
    ) -> None:
        self.launch(self._kernels.by_block, self.blocks_for(count), self.lanes)(
            *self._constants,
            targets,
            seeds,
            given,
            self._known,
            self._features,
            chosen,
            buffers.joints,
            buffers.least,
            buffers.facts,
            buffers.left,
            self._counters,
        )

    def _buffers_for(self, count: int) -> _DeviceBuffers:
        if count not in self._kept_buffers:
            if len(self._kept_buffers) >= 16:
                self._kept_buffers.clear()
            self._kept_buffers[count] = _DeviceBuffers(count, self.dof, max(self.near, 1))
        return self._kept_buffers[count]

    def _on_device(self, values: Any, buffers: Any = None) -> Any:
        """Values as an array of numba's on the device, copied only from the host."""
        if hasattr(values, "__cuda_ndarray__"):
            return values
        if hasattr(values, "__cuda_array_interface__"):
            return self._cuda.as_cuda_array(values)
        values = np.ascontiguousarray(values, dtype=np.float64)
        if buffers is None:
            return self._cuda.to_device(values)
        buffers.copy_to_device(values)
        return buffers

    def _refined(self, joints: Array, facts: Array, seconds: float) -> Refined:
        status, iterations, starts = facts.astype(np.int64)
        time_s = np.full(len(joints), seconds / max(len(joints), 1))
        return Refined(self._turned(joints), status, iterations, starts, time_s)
