"""The Levenberg-Marquardt refinement in torch: large batches at once, on an accelerator.

The algorithm, its options, its random numbers and so its rows are those of `baselines.refine`, up
to rounding. On processors the compiled kernel is many times faster.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from baselines.errors import SettingError
from baselines.linearise_torch import TorchChain
from baselines.lm_kernel import LmOptions
from baselines.refine import Refined
from baselines.rounds_torch import DeviceChain, solve_rounds
from baselines.seed_library import SeedLibrary

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

# Poses side by side: what memory and caches bear.
BATCH = {"cpu": 4096, "cuda": 1 << 18}
DEVICES, PRECISIONS = ("auto", "cpu", "cuda"), ("float64", "mixed")
# In float32 a chain of ten joints is exact to a few micrometres; below this it would only stall.
LEAST_MIXED_TOLERANCE = 2.0e-5


def refine_place(robot: Robot, device: str, precision: str) -> DeviceChain:
    """Bring a robot's chain to a device.

    Args:
        robot: The robot.
        device: cpu, cuda, or auto: cuda where there is one.
        precision: float64, or mixed: descents in float32, each solution completed in float64.

    Raises:
        SettingError: An unknown device or precision, or one that is not there.
    """
    if device not in DEVICES or precision not in PRECISIONS:
        raise SettingError(
            f"expected a device of {', '.join(DEVICES)} and a precision of "
            f"{', '.join(PRECISIONS)}, got {device!r} and {precision!r}"
        )
    if device == "cuda" and not torch.cuda.is_available():
        raise SettingError("device cuda was asked for, but torch sees none: use auto or cpu")
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    place = torch.device(device)
    exact = TorchChain(robot.chain, torch.float64, place)
    mixed = precision == "mixed"
    fast = TorchChain(robot.chain, torch.float32, place) if mixed else exact
    return DeviceChain(place, exact, fast, robot)


def refine_torch(
    place: DeviceChain,
    poses: Array | Tensor,
    seeds: Array | Tensor,
    options: LmOptions,
    library: SeedLibrary | None = None,
) -> Refined:
    """Descend from each pose's seeds in order, then from random configurations, until solved.

    A time limit is one of the batch: N poses get N times `options.time_ns`, and the clock is read
    between rounds of descents only. `Refined.time_s` is the batch's time shared evenly.

    Args:
        place: Robot, device and precision.
        poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz; an array, or a
            tensor on any device.
        seeds: (N, K, dof) configurations to start from, moved into the limits; K may be 0.
        options: Tolerances, damping and budget.
        library: Configurations to start from after the seeds, the nearest first.

    Raises:
        SettingError: The tolerances are too fine for mixed precision.
    """
    began = time.perf_counter()
    finest = min(options.position_tolerance_m, options.rotation_tolerance_rad)
    if place.fast is not place.exact and finest < LEAST_MIXED_TOLERANCE:
        raise SettingError(
            f"precision mixed takes tolerances of {LEAST_MIXED_TOLERANCE} m and rad at least, got "
            f"{finest}: use float64"
        )
    targets = torch.as_tensor(poses, dtype=torch.float64, device=place.device)
    given = torch.as_tensor(seeds, dtype=torch.float64, device=place.device)
    deadline = began + options.time_ns * 1e-9 * len(targets) if options.time_ns else None
    solved = [
        solve_rounds(place, part, first, options, deadline, library)
        for part, first in zip(
            targets.split(BATCH[place.device.type]),
            given.split(BATCH[place.device.type]),
            strict=True,
        )
    ]
    joints, status, iterations, starts = (
        torch.cat(parts).cpu().numpy()
        for parts in zip(*((o.joints.T, o.status, o.used, o.starts) for o in solved), strict=True)
    )
    joints = np.ascontiguousarray(joints)
    if place.robot is not None:
        joints = place.robot.nearest_turns(joints)
    elapsed = (time.perf_counter() - began) / max(1, len(targets))
    return Refined(joints, status, iterations, starts, np.full(len(targets), elapsed))
