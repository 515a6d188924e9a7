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
import csv
import os
import platform
import statistics
import time
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

import baselines
from baselines import lm_cuda
from baselines.lm_cuda import LmCuda
from baselines.lm_kernel import LmOptions
from baselines.refine import refine
from baselines.seed_library import SeedLibrary, build_seed_library
from robots import Robot, available_robots, load_robot
from robots.rotations import rotation_angle

Array = NDArray[np.float64]

ROBOTS = ("panda", "fetch", "nicol", "nico", "valkyrie")
SIZES = (1, 10, 100, 1000, 2000, 10_000, 100_000)
CANDIDATES = (32, 64, 128, 256)
BLOCKS = (32, 64, 128)  # threads that share a pose
HALTON = 100
SEED, CHUNK = 11, 2048
REMEMBERED, NEIGHBOURS = 2048, 6
# Tolerances of the solvers [m, rad]: those of conf/solver/lm.yaml, and a ten-thousandth of a mm.
TOLERANCES = ((1e-4, 1e-4), (1e-7, 1e-7))
MEASURED_S, MOST_CALLS = 0.15, 25
FIELDS = [
    *("device", "robot", "protocol", "solver", "tolerance_m", "batch", "poses", "collision_free"),
    *("third_ms", "device_ms", "host_ms", "us_a_pose"),
    *("success_5mm_0.05rad", "success_1mm_1deg", "within_tolerance", "found"),
    *("p98_mm", "p98_rad", "mean_mm", "iterations", "first_s", "note"),
]


class Poses(NamedTuple):
    """Poses (N, 7), and whether their configurations are known to be free of collision."""

    poses: Array
    free: bool


class Rows:
    """The table, written row by row, and the time that is left for it."""

    def __init__(self, path: Path, budget_s: float) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path, self.end = path, time.perf_counter() + budget_s
        with path.open("w", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, FIELDS).writeheader()

    @property
    def open(self) -> bool:
        """Whether another row may begin."""
        return time.perf_counter() < self.end

    def add(self, **values: Any) -> None:
        """Write a row."""
        rounded = {k: f"{v:.6g}" if isinstance(v, float) else v for k, v in values.items()}
        with self.path.open("a", newline="", encoding="utf-8") as file:
            csv.DictWriter(file, FIELDS).writerow(rounded)
        shown = ("robot", "protocol", "solver", "tolerance_m", "batch", "device_ms", "host_ms")
        more = ("success_1mm_1deg", "within_tolerance", "p98_mm", "note")
        print(*(f"{key}={rounded.get(key)}" for key in (*shown, *more)), flush=True)


class Calls(NamedTuple):
    """One way to solve poses.

    Attributes:
        name: Of the solver.
        on_host: Takes poses on the host, returns a `Refined` there.
        on_device: Takes poses on the device, and returns once the answers are there; None for a
            processor.
    """

    name: str
    on_host: Callable[[Any], Any]
    on_device: Callable[[Any], Any] | None


def prepare(masks: Path, robots: Sequence[str], count: int) -> None:
    """Find which uniform samples are free of collision, for the first `count` that are."""
    bits = {}
    for name in robots:
        robot, parts, found = load_robot(name), [], 0
        while found < count:
            joints = _uniform(robot, len(parts))
            parts.append(~robot.in_collision(joints))
            found += int(parts[-1].sum())
        bits[name] = np.packbits(np.concatenate(parts))
        print(name, found, "of", CHUNK * len(parts), flush=True)
    np.savez_compressed(masks, **bits)


def _uniform(robot: Robot, number: int) -> Array:
    generator = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(number,)))
    return generator.uniform(robot.lower, robot.upper, (CHUNK, robot.dof))


def sampled(robot: Robot, count: int, masks: Path | None) -> Poses:
    """Poses of collision-free samples, or of any where no file says which are free."""
    chunks = -(-count // CHUNK)
    if masks is None:
        joints = np.concatenate([_uniform(robot, k) for k in range(chunks)])[:count]
        return Poses(robot.forward_kinematics(joints), False)
    with np.load(masks) as stored:
        free = np.unpackbits(stored[robot.name]).astype(bool)
    joints = np.concatenate([_uniform(robot, k) for k in range(len(free) // CHUNK)])
    joints = joints[free[: len(joints)]]
    if len(joints) < count:
        raise SystemExit(f"{masks} holds {len(joints)} samples of {robot.name}, not {count}")
    return Poses(robot.forward_kinematics(joints[:count]), True)


def halton(robot: Robot, count: int) -> Array:
    """Poses (N, 7) of the configurations of a Halton sequence."""
    shares = qmc.Halton(robot.dof, scramble=False).random(count + 1)[1:]
    return robot.forward_kinematics(robot.lower + shares * (robot.upper - robot.lower))


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


def options_of(robot: Robot, position: float, rotation: float) -> LmOptions:
    solver = baselines.load("lm", robot)
    assert isinstance(solver, baselines.lm.LevenbergMarquardt)
    return solver.options(None)._replace(
        position_tolerance_m=position, rotation_tolerance_rad=rotation
    )


def solvers_of(
    robot: Robot, options: LmOptions, library: SeedLibrary, all_ways: bool
) -> list[Calls]:
    """The solvers to measure; with `all_ways` also every way to share the work on the device."""
    made = [_lm("lm_cuda", robot, options, library)]
    refined = _refined(robot, options, library)
    made += [refined] if refined else []
    if all_ways:
        made += [
            _lm("lm_cuda[not captured]", robot, options, library, captured=False),
            _lm("lm_cuda[lane]", robot, options, library, near=2, way="lane"),
            *(
                _lm(f"lm_cuda[block {n}]", robot, options, library, way="block", lanes=n)
                for n in BLOCKS
            ),
        ]
        twin = _torch_twin(robot, options, library)
        made += [twin] if twin else []
    return made


def _lm(
    name: str, robot: Robot, options: LmOptions, library: SeedLibrary, **settings: Any
) -> Calls:
    settings = {"captured": can_capture(), **settings}
    solver = LmCuda(robot, options, library, **settings)
    return Calls(name, solver.solve, solver.solve_on_device)


def _refined(robot: Robot, options: LmOptions, library: SeedLibrary) -> Calls | None:
    try:
        from pipeline.learning.card import shipped_weights
        from pipeline.learning.refined_cuda import RefinedCuda
        from pipeline.learning.weights import load_network

        network = load_network(shipped_weights(robot.name), robot)
        solver = RefinedCuda(robot, network, options, library, captured=can_capture())
    except (ImportError, ValueError, OSError) as error:
        print(f"no cycleik_refined_cuda for {robot.name}: {error}", flush=True)
        return None
    return Calls("cycleik_refined_cuda", solver.solve, solver.solve_on_device)


def _torch_twin(robot: Robot, options: LmOptions, library: SeedLibrary) -> Calls | None:
    try:
        import torch

        from baselines.refine_torch import refine_place, refine_torch
    except ImportError as error:
        print(f"no lm_torch: {error}", flush=True)
        return None
    if not torch.cuda.is_available():
        return None
    place = refine_place(robot, "cuda", "float64")

    def solve(poses: Any) -> Any:
        home = np.broadcast_to(robot.home, (len(poses), 1, robot.dof))
        return refine_torch(place, poses, home, options, library)

    return Calls("lm_torch", solve, None)


def measured(
    robot: Robot,
    calls: Calls,
    poses: Poses,
    size: int,
    options: LmOptions,
    row: Callable[..., None],
) -> None:
    """Measure one solver at one size and write its row."""
    asked = poses.poses[:size]
    began = time.perf_counter()
    answers = calls.on_host(asked)
    first_s = time.perf_counter() - began
    third, host_ms = timed(partial(calls.on_host, asked))
    device_ms = None
    if calls.on_device is not None:
        on_device = to_device(asked)
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
        **accuracy(robot, answers, asked, options),
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
    solver = LmCuda(robot, options, library, way="block", lanes=width, captured=can_capture())
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

            def solve(asked: Array, threads: int = threads, options: LmOptions = options) -> Any:
                home = np.broadcast_to(robot.home, (len(asked), 1, robot.dof))
                return refine(robot, asked, home, options, threads)

            for size in sizes:
                if not rows.open:
                    return
                if threads == 1 and size > 10_000:
                    continue
                name = f"{processor()}, {threads} of {cores} cores"
                row = partial(rows.add, device=name, robot=robot.name, solver="lm")
                measured(robot, Calls("lm", solve, None), poses, size, options, row)


@cache
def can_capture() -> bool:
    """Whether torch is there to record launches, and records them."""
    robot = load_robot("panda")
    poses = robot.forward_kinematics(robot.home[None])
    try:
        import torch

        if not torch.cuda.is_available():
            return False
        solver = LmCuda(robot, options_of(robot, *TOLERANCES[0]), captured=True)
        answers = [solver.solve(poses).joints for _ in range(3)]
    except Exception as error:
        print(f"launches are not recorded: {type(error).__name__}: {error}", flush=True)
        return False
    return bool(np.array_equal(answers[0], answers[2]))


def device_name() -> str:
    from numba import cuda

    device = getattr(cuda, "get_current_device", object)()
    name = getattr(device, "name", "simulator")
    return name.decode() if isinstance(name, bytes) else str(name)


def processor() -> str:
    """Name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


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
