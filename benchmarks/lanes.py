"""What solving poses side by side in vector registers gains, against the same kernel one by one.

    python -m benchmarks.lanes [--robots panda ...] [--poses 5000] [--rounds 5] [--write]

Three solvers answer the same poses in one process, in turns: the scalar kernel, the kernel of
lanes (the solver `lm` as it is), and refined CycleIK with its network. Times are medians over the
rounds of processor time of one thread; ratios are medians of each round's ratio. Success is
recomputed from the joints by Pinocchio. The limit is the arithmetic of an iteration, with no joint
at a limit, at the rate at which this core does packed multiply-adds.
`--write` keeps the table as results/studies/lanes.{csv,md}.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence

import numba
import numpy as np
import pandas as pd
import torch
from numba import njit
from numpy.typing import NDArray

from baselines import Solution
from baselines.checks import check_initial, check_poses
from baselines.lanes import LANES, load, store
from baselines.lm import LevenbergMarquardt
from baselines.refine import refine
from benchmarks.refined import SEED, pair_of, reachable, success
from benchmarks.studies import write_study
from robots import Robot, available_robots, load_robot

Array = NDArray[np.float64]

# Sums and products of an iteration: those of a joint (sine and cosine 43, frames 83, Jacobian 15,
# matrix 48, step 12), and those of a configuration (error 100, system of six equations 157).
OPERATIONS_PER_JOINT, OPERATIONS = 201, 257


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument("--poses", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--write", action="store_true")
    return parser.parse_args()


def main() -> None:
    options = arguments()
    torch.set_num_threads(1)
    numba.set_num_threads(1)
    rate = packed_rate()
    print(f"{options.poses} poses, {rate / 1e9:.0f} GFLOP/s a core\n")
    rows = [measured(load_robot(name), options, rate) for name in options.robots]
    table = pd.DataFrame(rows)
    text = markdown(table)
    print(text)
    ratios = table[["lanes_of_scalar", "refined_of_lanes", "refined_of_scalar"]]
    means = np.exp(np.log(ratios).mean())
    print("\nGeometric means:", ", ".join(f"{key} {value:.3f}" for key, value in means.items()))
    if options.write:
        write_study("lanes", table.round(4), text, "python -m benchmarks.lanes --write", str(SEED))


def measured(robot: Robot, options: argparse.Namespace, rate: float) -> dict[str, object]:
    """One row of the table."""
    refined, lm = pair_of(robot, 1)
    assert isinstance(lm, LevenbergMarquardt)
    poses = reachable(robot, options.poses)
    solvers: tuple[Callable[[], Solution], ...] = (
        lambda: one_by_one(lm, poses),
        lambda: lm.solve(poses),
        lambda: refined.solve(poses),
    )
    answers = [solve() for solve in solvers]
    times = timed(solvers, options.rounds, time.process_time) / len(poses)
    scalar_s, lanes_s, refined_s = np.median(times, axis=0)
    iterations = [answer.iterations.mean() for answer in answers]
    joints = len(robot.chain.prismatic)
    limit_s = (OPERATIONS + OPERATIONS_PER_JOINT * joints) / rate
    return {
        "robot": robot.name,
        "poses": len(poses),
        "scalar_us": scalar_s * 1e6,
        "lanes_us": lanes_s * 1e6,
        "refined_us": refined_s * 1e6,
        "lanes_of_scalar": np.median(times[:, 1] / times[:, 0]),
        "refined_of_lanes": np.median(times[:, 2] / times[:, 1]),
        "refined_of_scalar": np.median(times[:, 2] / times[:, 0]),
        "lm_iterations": iterations[1],
        "refined_iterations": iterations[2],
        "scalar_ns_per_iteration": scalar_s / iterations[0] * 1e9,
        "lanes_ns_per_iteration": lanes_s / iterations[1] * 1e9,
        "limit_ns_per_iteration": limit_s * 1e9,
        "scalar_percent": success(robot, answers[0].joints, poses),
        "lanes_percent": success(robot, answers[1].joints, poses),
        "refined_percent": success(robot, answers[2].joints, poses),
    }


def timed(
    solvers: Sequence[Callable[[], Solution]], rounds: int, clock: Callable[[], float]
) -> Array:
    """Seconds (rounds, S) of calls in turns, each called once before."""
    for solve in solvers:
        solve()
    times = np.empty((rounds, len(solvers)))
    for turn in range(rounds):
        for index, solve in enumerate(solvers):
            start = clock()
            solve()
            times[turn, index] = clock() - start
    return times


def one_by_one(lm: LevenbergMarquardt, poses: Array) -> Solution:
    """What `lm.solve` does, by the scalar kernel."""
    robot = lm.robot
    targets = check_poses(poses)
    seeds = check_initial(None, len(targets), robot.home, robot.lower, robot.upper, robot.endless)
    options = lm.options(None)
    return refine(
        robot, targets, seeds[:, None], options, lm.threads, side_by_side=False
    ).solution()


@njit(fastmath={"contract"})
def _multiply_adds(lanes, rounds):  # type: ignore[no-untyped-def]
    """Run `rounds` times twelve multiply-adds of all lanes that do not wait for one another."""
    a, b, c, d = load(lanes, 0), load(lanes, 1), load(lanes, 2), load(lanes, 3)
    e, f, g, h = load(lanes, 4), load(lanes, 5), load(lanes, 6), load(lanes, 7)
    i, j, k, l = load(lanes, 8), load(lanes, 9), load(lanes, 10), load(lanes, 11)  # noqa: E741
    for _ in range(rounds):
        a, b, c, d = a * 0.5 + 0.1, b * 0.5 + 0.1, c * 0.5 + 0.1, d * 0.5 + 0.1
        e, f, g, h = e * 0.5 + 0.1, f * 0.5 + 0.1, g * 0.5 + 0.1, h * 0.5 + 0.1
        i, j, k, l = i * 0.5 + 0.1, j * 0.5 + 0.1, k * 0.5 + 0.1, l * 0.5 + 0.1  # noqa: E741
    store(lanes, 0, a + b + c + d + e + f + g + h + i + j + k + l)


def packed_rate() -> float:
    """Sums and products of float64 a second that one core does in vector registers."""
    lanes, rounds, times = np.ones((12, LANES)), 1_000_000, []
    for _ in range(10):
        start = time.process_time()
        _multiply_adds(lanes, rounds)
        times.append(time.process_time() - start)
    return 12 * 2 * LANES * rounds / min(times)


def markdown(table: pd.DataFrame) -> str:
    """The table for readers."""
    lines = [
        "| robot | scalar us | lanes us | refined us | lanes / scalar | refined / lanes "
        "| refined / scalar | scalar ns an iteration | lanes | limit | solved % |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in table.to_dict("records"):
        solved = " / ".join(f"{row[f'{s}_percent']:.2f}" for s in ("scalar", "lanes", "refined"))
        cells = [
            row["robot"],
            *(f"{row[key]:.2f}" for key in ("scalar_us", "lanes_us", "refined_us")),
            *(
                f"{row[key]:.3f}"
                for key in ("lanes_of_scalar", "refined_of_lanes", "refined_of_scalar")
            ),
            *(f"{row[f'{key}_ns_per_iteration']:.0f}" for key in ("scalar", "lanes", "limit")),
            solved,
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
