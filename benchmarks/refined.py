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
from numba import njit
from numpy.typing import NDArray

from baselines import Solution, Solver
from pipeline import load_solver
from pipeline.config import compose
from pipeline.learning.cycleik.compiled.answers import CHUNK, answer, make_work
from pipeline.learning.cycleik.compiled.products import linear, pack_layer
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.cycleik.solver import CycleIk
from pipeline.learning.refined import RefinedSolver
from robots import Robot, available_robots, load_robot

SEED = 11
QUERIES = 500  # at most, of a batch size; smaller batches run that many times
NETWORK_SIZES = (1, 100, 5000)  # batches that the network alone is timed with
PEAK_SIZE, LAYERS = 768, 200  # of the products that stand for the rate of one core


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
    print(
        "\nThe network alone on one thread, by batch size, without Python; the limit is its "
        "products at this core's rate\n"
    )
    print("| robot | batch | us a pose | GFLOP/s | limit us | times the limit |")
    print("|---|---|---|---|---|---|")
    for robot in robots:
        print("\n".join(network_limits(robot, solvers[robot.name][0], poses[robot.name])))


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


def network_limits(robot: Robot, solver: RefinedSolver, poses: NDArray[np.float64]) -> list[str]:
    """Time of the network's answers, cells and ranking included, against its products alone."""
    proposer = solver.proposer
    assert isinstance(proposer, CycleIk)
    assert isinstance(proposer.network, Experts)
    assert proposer.compiled is not None
    network, experts = proposer.network, proposer.compiled
    flops = 2 * (sum(weight[0].numel() for weight in network.weights) + network.centres.numel())
    rate, rows = product_rate(), []
    for size in NETWORK_SIZES:
        shown = poses[: min(len(poses), size * QUERIES) // size * size]
        joints = np.empty((len(shown), network.heads, robot.dof))
        errors = np.empty((len(shown), network.heads, 2))
        work = make_work(experts, size)
        weights = np.array([100.0, 180 / np.pi])
        arguments = robot.chain, experts, shown, weights, joints, errors, work, size
        answer_in_batches(*arguments)
        times = []
        for _ in range(15):
            start = time.thread_time()
            answer_in_batches(*arguments)
            times.append((time.thread_time() - start) / len(shown))
        seconds = float(np.median(times))
        limit = flops / rate
        rows.append(
            f"| {robot.name} | {size} | {seconds * 1e6:.3f} | {flops / seconds / 1e9:.0f} | "
            f"{limit * 1e6:.3f} | {seconds / limit:.1f} |"
        )
    return rows


@njit
def answer_in_batches(chain, experts, poses, weights, joints, errors, work, size):  # type: ignore[no-untyped-def]
    """Answer poses in batches without Python between them."""
    for begin in range(0, len(poses), size):
        rows = slice(begin, begin + size)
        answer(chain, experts, poses[rows], weights, 0, joints[rows], errors[rows], work)


def product_rate() -> float:
    """Multiplications and additions a second of one core, float32, by the faster of two methods.

    Of large square matrices by torch, and of a chunk of rows with one layer by `linear`, whose
    weights stay in the first two caches.
    """
    left = torch.randn(PEAK_SIZE, PEAK_SIZE)
    random = np.random.default_rng(SEED)
    layer = random.normal(size=(1, 128, 128)), random.normal(size=(1, 128))
    packed = pack_layer(*layer, np.float32)[0]
    values = random.normal(size=2 * CHUNK * 128).astype(np.float32)
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    rates = []
    for _ in range(20):
        start = time.thread_time()
        left @ left
        rates.append(2 * PEAK_SIZE**3 / (time.thread_time() - start))
        start = time.thread_time()
        for _ in range(LAYERS):
            linear(values, 0, CHUNK, 128, packed, 0, 128, CHUNK * 128)
        rates.append(LAYERS * 2 * CHUNK * 128 * 128 / (time.thread_time() - start))
    torch.set_num_threads(threads)
    return max(rates)


if __name__ == "__main__":
    main()
