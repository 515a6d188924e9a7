"""When does a neural seed pay? Refined CycleIK against the same kernel from home, in turns.

    python benchmarks/refined.py [--robots panda ...] [--poses 5000] [--rounds 7] [--threads 1]

Both solvers run in one process on the same threads, one after the other in every round; times are
medians over rounds and include the network, and the ratio is the median of each round's ratio.
Success is recomputed from the joints by Pinocchio. A second table repeats it for smaller batches,
down to single queries, and a third says how far the network is from the arithmetic it must do.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numba
import numpy as np
import pinocchio
import torch
from numpy.typing import NDArray

from baselines import Solution, Solver
from pipeline import load_solver
from pipeline.config import compose
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.refined import RefinedSolver
from robots import Robot, available_robots, load_robot

SEED = 11
QUERIES = 500  # at most, of a batch size; smaller batches run that many times
PEAK_SIZE = 768  # of the square matrices whose product stands for the peak of one core


@dataclass(frozen=True)
class Pair:
    """Times of both solvers on the same poses, and what the last round found."""

    refined_us: float
    lm_us: float
    ratio: float
    refined: Solution
    lm: Solution


def main() -> None:
    options = arguments()
    torch.set_num_threads(options.threads)
    numba.set_num_threads(options.threads)
    robots = [load_robot(name) for name in options.robots]
    solvers = {robot.name: pair_of(robot, options.threads) for robot in robots}
    poses = {robot.name: reachable(robot, options.poses) for robot in robots}
    print(f"Batches of {options.poses} poses, {options.threads} thread(s), network included\n")
    print("| robot | refined us | lm us | ratio | iterations | lm's | share | refined % | lm % |")
    print("|---|---|---|---|---|---|---|---|---|")
    ratios = []
    for robot in robots:
        pair = compare(*solvers[robot.name], poses[robot.name], options.poses, options.rounds)
        ratios.append(pair.ratio)
        print(whole_batch(robot, pair, poses[robot.name]))
    print(f"\nGeometric mean of the ratios: {np.exp(np.mean(np.log(ratios))):.3f}\n")
    smaller_batches(robots, solvers, poses, options.rounds)
    print("\nThe network alone against its products of matrices, one thread\n")
    print("| robot | multiplications | us a pose | GFLOP/s | peak GFLOP/s | share |")
    print("|---|---|---|---|---|---|")
    for robot in robots:
        print(network_limit(robot, solvers[robot.name][0], poses[robot.name]))


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument("--poses", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--threads", type=int, default=1)
    return parser.parse_args()


def pair_of(robot: Robot, threads: int) -> tuple[RefinedSolver, Solver]:
    refined = load_solver("cycleik_refined", robot, threads=threads)
    assert isinstance(refined, RefinedSolver)
    return refined, load_solver("lm", robot, threads=threads)


def reachable(robot: Robot, count: int) -> NDArray[np.float64]:
    """Poses (N, 7) as in the test sets, of configurations that no training has drawn."""
    inside = compose([f"robot={robot.name}"]).robot.workspace_filter
    joints = robot.sample(count, seed=SEED, collision_free=True, workspace_filter=inside)
    return robot.forward_kinematics(joints)


def compare(
    refined: Solver, lm: Solver, poses: NDArray[np.float64], size: int, rounds: int
) -> Pair:
    """Ask both solvers all poses in batches of a size, in turns."""
    times = np.empty((rounds, 2))
    answers: dict[int, Solution] = {}
    for solver in (refined, lm):
        solver.solve(poses[:size])
    batches = [poses[begin : begin + size] for begin in range(0, len(poses), size)]
    for turn in range(rounds):
        for index, solver in enumerate((refined, lm)):
            start = time.perf_counter()
            for batch in batches:
                answers[index] = solver.solve(batch)
            times[turn, index] = (time.perf_counter() - start) / len(poses) * 1e6
    middle = np.median(times, axis=0)
    ratio = float(np.median(times[:, 0] / times[:, 1]))
    return Pair(float(middle[0]), float(middle[1]), ratio, answers[0], answers[1])


def success(robot: Robot, joints: NDArray[np.float64], poses: NDArray[np.float64]) -> float:
    """Percent within 1 mm and 1 deg and inside the limits, by Pinocchio's kinematics."""
    model, frame = robot.pinocchio()
    data = model.createData()
    good = 0
    inside = np.all((joints >= robot.lower) & (joints <= robot.upper), axis=1)
    for row, pose in enumerate(poses):
        pinocchio.framesForwardKinematics(model, data, joints[row])
        reached = data.oMf[frame]
        goal = pinocchio.XYZQUATToSE3(pose[[0, 1, 2, 4, 5, 6, 3]])
        distance = np.linalg.norm(reached.translation - goal.translation)
        angle = np.linalg.norm(pinocchio.log3(reached.rotation.T @ goal.rotation))
        good += bool(inside[row] and distance <= 1e-3 and angle <= np.radians(1))
    return 100 * good / len(poses)


def whole_batch(robot: Robot, pair: Pair, poses: NDArray[np.float64]) -> str:
    mine, theirs = pair.refined.iterations.mean(), pair.lm.iterations.mean()
    cells = [
        robot.name,
        f"{pair.refined_us:.2f}",
        f"{pair.lm_us:.2f}",
        f"{pair.ratio:.3f}",
        f"{mine:.2f}",
        f"{theirs:.2f}",
        f"{mine / theirs:.2f}",
        f"{success(robot, pair.refined.joints, poses):.2f}",
        f"{success(robot, pair.lm.joints, poses):.2f}",
    ]
    return f"| {' | '.join(cells)} |"


def smaller_batches(
    robots: list[Robot],
    solvers: dict[str, tuple[RefinedSolver, Solver]],
    poses: dict[str, NDArray[np.float64]],
    rounds: int,
) -> None:
    sizes = (1, 10, 100, 1000)
    print("Microseconds a pose, refined / lm (ratio), by batch size\n")
    print(f"| robot | {' | '.join(str(size) for size in sizes)} |")
    print(f"|{'---|' * (len(sizes) + 1)}")
    for robot in robots:
        cells = []
        for size in sizes:
            requested = poses[robot.name][: min(size * QUERIES, len(poses[robot.name]))]
            pair = compare(*solvers[robot.name], requested, size, rounds)
            cells.append(f"{pair.refined_us:.1f} / {pair.lm_us:.1f} ({pair.ratio:.2f})")
        print(f"| {robot.name} | {' | '.join(cells)} |")


def network_limit(robot: Robot, solver: RefinedSolver, poses: NDArray[np.float64]) -> str:
    """Time of the network's answers, ranking by forward kinematics included, against the peak."""
    network = solver.proposer.network
    assert isinstance(network, Experts)
    products = sum(weight[0].numel() for weight in network.weights) + network.centres.numel()
    times = []
    for _ in range(7):
        start = time.perf_counter()
        solver.hypotheses(poses)
        times.append((time.perf_counter() - start) / len(poses))
    seconds = float(np.median(times))
    rate, peak = 2 * products / seconds / 1e9, matrix_peak()
    return (
        f"| {robot.name} | {products:,} | {seconds * 1e6:.2f} | {rate:.0f} | {peak:.0f} | "
        f"{rate / peak:.2f} |"
    )


def matrix_peak() -> float:
    """GFLOP/s of a float32 product of square matrices on the threads of torch."""
    left = torch.randn(PEAK_SIZE, PEAK_SIZE)
    times = []
    for _ in range(10):
        start = time.perf_counter()
        left @ left
        times.append(time.perf_counter() - start)
    return 2 * PEAK_SIZE**3 / min(times) / 1e9


if __name__ == "__main__":
    main()
