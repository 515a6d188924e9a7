"""Time and accuracy of the calls of a solver."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from baselines.lm_cuda import LmCuda
from baselines.lm_kernel import LmOptions
from baselines.refine import refine
from baselines.seed_library import SeedLibrary
from benchmarks.accelerator_solvers.poses import Poses, sampled
from benchmarks.accelerator_solvers.rows import Rows, processor
from benchmarks.accelerator_solvers.solvers import TOLERANCES, Calls, can_capture, options_of
from robots import Robot
from robots.rotations import rotation_angle

Array = NDArray[np.float64]

MEASURED_S, MOST_CALLS = 0.15, 25


def measured(
    robot: Robot,
    calls: Calls,
    poses: Poses,
    size: int,
    options: LmOptions,
    row: Callable[..., None],
) -> None:
    """Measure one solver at one size and write its row."""
    targets = poses.poses[:size]
    began = time.perf_counter()
    answers = calls.on_host(targets)
    first_s = time.perf_counter() - began
    third, host_ms = timed(partial(calls.on_host, targets))
    device_ms = None
    if calls.on_device is not None:
        on_device = to_device(targets)
        third, device_ms = timed(partial(_finished, calls.on_device, on_device))
    row(
        protocol="batch",
        batch=size,
        poses=size,
        collision_free=poses.free,
        third_ms=third,
        device_ms=device_ms,
        host_ms=host_ms,
        us_a_pose=1e3 * (host_ms if device_ms is None else device_ms) / size,
        first_s=first_s,
        **accuracy(robot, answers, targets, options),
    )


def timed(call: Callable[[], Any]) -> tuple[float, float]:
    """Milliseconds of the third call and the median of those after it."""
    times = []
    began = time.perf_counter()
    while len(times) < 4 or (
        time.perf_counter() - began < MEASURED_S and len(times) < MOST_CALLS + 3
    ):
        start = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - start))
    return times[2], statistics.median(times[3:])


def _finished(call: Callable[[Any], Any], poses: Any) -> None:
    from numba import cuda

    call(poses)
    cuda.synchronize()


def to_device(poses: Array) -> Any:
    from numba import cuda

    return cuda.to_device(np.ascontiguousarray(poses))


def accuracy(robot: Robot, answers: Any, poses: Array, options: LmOptions) -> dict[str, Any]:
    """Errors of the answers, recomputed; joints outside the limits are no success."""
    joints = np.asarray(answers.joints)
    reached = robot.forward_kinematics(joints)
    distance = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
    angle = rotation_angle(reached[:, 3:], poses[:, 3:])
    inside = ((joints >= robot.lower) & (joints <= robot.upper)).all(axis=1)
    coarse = inside & (distance < 5e-3) & (angle < 0.05)
    # A millionth more than the tolerance: the errors come from other sums in another order.
    slack = 1 + 1e-6
    tight = (
        inside
        & (distance <= slack * options.position_tolerance_m + 1e-12)
        & (angle <= slack * options.rotation_tolerance_rad + 1e-12)
    )
    good = coarse if coarse.any() else np.ones_like(coarse)
    return {
        "tolerance_m": options.position_tolerance_m,
        "success_5mm_0.05rad": float(100 * coarse.mean()),
        "success_1mm_1deg": float(
            100 * (inside & (distance < 1e-3) & (angle < np.radians(1.0))).mean()
        ),
        "within_tolerance": float(100 * tight.mean()),
        "found": float(100 * np.mean(answers.found)),
        "p98_mm": float(1e3 * np.percentile(distance[good], 98)),
        "p98_rad": float(np.percentile(angle[good], 98)),
        "mean_mm": float(1e3 * distance.mean()),
        "iterations": float(np.mean(answers.iterations)),
    }


def one_at_a_time(
    robot: Robot,
    options: LmOptions,
    library: SeedLibrary,
    width: int,
    poses: Array,
    row: Callable[..., None],
) -> None:
    """HJCD-IK's protocol: one pose a call, `width` candidates of it side by side."""
    solver = LmCuda(robot, options, library, mapping="block", lanes=width, captured=can_capture())
    times, on_device, answers = [], [], []
    for turn in range(2):
        for index in range(len(poses)):
            start = time.perf_counter()
            answer = solver.solve(poses[index : index + 1])
            if turn:
                times.append(1e3 * (time.perf_counter() - start))
                answers.append(answer)
    for index in range(len(poses)):
        target = to_device(poses[index : index + 1])
        start = time.perf_counter()
        _finished(solver.solve_on_device, target)
        on_device.append(1e3 * (time.perf_counter() - start))
    joined = type(answers[0])(
        *(
            np.concatenate([getattr(answer, field) for answer in answers])
            for field in ("joints", "status", "iterations", "starts", "time_s")
        )
    )
    row(
        protocol="candidates",
        batch=width,
        poses=len(poses),
        third_ms=times[min(2, len(times) - 1)],
        device_ms=statistics.mean(on_device),
        host_ms=statistics.mean(times),
        us_a_pose=1e3 * statistics.mean(times),
        note=f"median {statistics.median(times):.4f} ms",
        **accuracy(robot, joined, poses, options),
    )


def on_processor(robot: Robot, sizes: Sequence[int], masks: Path | None, rows: Rows) -> None:
    """The compiled kernel on one core of this machine and on all of them."""
    poses = sampled(robot, max(sizes), masks)
    cores = len(os.sched_getaffinity(0))
    for position, rotation in TOLERANCES:
        options = options_of(robot, position, rotation)
        for threads in sorted({1, cores}):

            def solve(poses: Array, threads: int = threads, options: LmOptions = options) -> Any:
                home = np.broadcast_to(robot.home, (len(poses), 1, robot.dof))
                return refine(robot, poses, home, options, threads)

            for size in sizes:
                if not rows.open:
                    return
                if threads == 1 and size > 10_000:
                    continue
                name = f"{processor()}, {threads} of {cores} cores"
                row = partial(rows.add, device=name, robot=robot.name, solver="lm")
                measured(robot, Calls("lm", solve, None), poses, size, options, row)
