"""Solvers on a CUDA device, in the protocols of cuRobo and PyRoki and of HJCD-IK.

    python -m benchmarks.accelerator_solvers prepare --masks masks.npz          # where coal is
    python -m benchmarks.accelerator_solvers run --masks masks.npz --out rows.csv --budget-s 240

`prepare` keeps which uniform samples are free of collision, a bit each, so that the machine with
the device needs no collision checker. A row is written as soon as it is measured, and none is begun
after the budget.

Protocol "batch" (cuRobo, PyRoki): B poses of collision-free samples in one call. Protocol
"candidates" (HJCD-IK): 100 poses of a Halton sequence one at a time, B candidates of each side by
side. Times are those of a whole call: `device_ms` with poses and answers on the device,
`host_ms` with both on the host, copies included; each the median of calls after the third,
`third_ms` the third call's. Errors are recomputed from the joints in float64.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from baselines import lm_cuda
from baselines.seed_library import build_seed_library
from benchmarks.accelerator_solvers.measure import measured, on_processor, one_at_a_time
from benchmarks.accelerator_solvers.poses import halton, prepare, sampled
from benchmarks.accelerator_solvers.rows import Rows, device_name
from benchmarks.accelerator_solvers.solvers import TOLERANCES, options_of, solvers_of
from robots import available_robots, load_robot

Array = NDArray[np.float64]

ROBOTS = ("panda", "fetch", "nicol", "nico", "valkyrie")
SIZES = (1, 10, 100, 1000, 2000, 10_000, 100_000)
CANDIDATES = (32, 64, 128, 256)
HALTON = 100
REMEMBERED, NEIGHBOURS = 2048, 6


def run(
    out: Path,
    robots: Sequence[str] = ROBOTS,
    sizes: Sequence[int] = SIZES,
    budget_s: float = 240.0,
    masks: Path | None = None,
    candidates: Sequence[int] = CANDIDATES,
    halton_poses: int = HALTON,
) -> None:
    """Measure all solvers; see the text above.

    Args:
        out: Table to write.
        robots: Names of robots, the most important first.
        sizes: Batches B.
        budget_s: Seconds after which no row begins.
        masks: What `prepare` has written.
        candidates: Candidates of one pose, B of HJCD-IK's protocol.
        halton_poses: Poses of that protocol.
    """
    rows = Rows(out, budget_s)
    if reason := lm_cuda.skip():
        rows.add(protocol="batch", solver="lm_cuda", note=reason)
        return
    device = device_name()
    for index, name in enumerate(robots):
        robot = load_robot(name)
        poses = sampled(robot, max(sizes), masks)
        library = build_seed_library(robot, REMEMBERED, NEIGHBOURS, 0)
        for position, rotation in TOLERANCES:
            options = options_of(robot, position, rotation)
            for calls in solvers_of(robot, options, library, index == 0 and position == 1e-4):
                for size in sizes:
                    if not rows.open:
                        return
                    row = partial(rows.add, device=device, robot=name, solver=calls.name)
                    guarded(row, measured, robot, calls, poses, size, options, row)
            for width in candidates:
                row = partial(rows.add, device=device, robot=name, solver="lm_cuda")
                targets = halton(robot, halton_poses)
                if rows.open:
                    guarded(row, one_at_a_time, robot, options, library, width, targets, row)
    for name in robots:
        on_processor(load_robot(name), sizes, masks, rows)


def guarded(row: Callable[..., None], measure: Callable[..., None], *arguments: Any) -> None:
    """Measure one row; a fault is written in its place, for the device is here but once."""
    try:
        measure(*arguments)
    except Exception as error:
        row(note=f"Error: {type(error).__name__}: {' '.join(str(error).split())[:300]}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("prepare", "run"))
    parser.add_argument("--masks", type=Path)
    parser.add_argument("--out", type=Path, default=Path("accelerator_solvers.csv"))
    parser.add_argument("--robots", nargs="+", default=ROBOTS, choices=available_robots())
    parser.add_argument("--sizes", nargs="+", type=int, default=SIZES)
    parser.add_argument("--budget-s", type=float, default=240.0)
    options = parser.parse_args()
    if options.what == "prepare":
        prepare(options.masks, options.robots, max(options.sizes))
    else:
        run(options.out, options.robots, options.sizes, options.budget_s, options.masks)


if __name__ == "__main__":
    main()
