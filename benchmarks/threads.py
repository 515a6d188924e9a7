"""What more cores gain on a batch, against what the machine lets them gain.

    python -m benchmarks.threads [--robots panda ...] [--poses 5000] [--rounds 50] [--threads 2]
                                 [--write]

`lm` and refined CycleIK answer the same poses on one thread and on several, in turns; times are
medians over the rounds, in wall time, and the gain is the ratio of these medians. At best it is
that of the fastest rounds, which other work on the machine has disturbed least. The limit is what
the machine gives to programs that have nothing to do with each other: the same solver on one thread
of as many processes at once, each with the whole batch, against one process alone. Run it on cores
that nobody else uses.
"""

from __future__ import annotations

import argparse
import multiprocessing
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from multiprocessing.connection import Connection

import numpy as np
import pandas as pd
import torch

from benchmarks.lanes import timed
from benchmarks.refined import SEED, reachable
from benchmarks.studies import write_study
from pipeline import load_solver
from robots import available_robots, load_robot

SOLVERS = ("lm", "cycleik_refined")


def main() -> None:
    """Measure, print and, with --write, write the study."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument("--poses", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=50)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="into results/studies")
    options = parser.parse_args()
    torch.set_num_threads(1)
    rows = [measured(name, solver, options) for name in options.robots for solver in SOLVERS]
    table = pd.DataFrame(rows)
    text = markdown(table, options.threads)
    print(text)
    for solver, group in table.groupby("solver", sort=False):
        gains = " and at best ".join(f"{group[key].median():.2f}" for key in ("gain", "at_best"))
        print(f"\n{solver}: {gains} times, medians of robots")
    if options.write:
        command = f"python -m benchmarks.threads --threads {options.threads} --write"
        write_study("threads", table.round(4), text, command, str(SEED))


def measured(name: str, solver: str, options: argparse.Namespace) -> dict[str, object]:
    """One row of the table."""
    robot = load_robot(name)
    poses = reachable(robot, options.poses)
    one, more = (load_solver(solver, robot, threads=n) for n in (1, options.threads))
    calls = partial(one.solve, poses), partial(more.solve, poses)
    rounds = timed(calls, options.rounds, time.perf_counter) * 1e6 / len(poses)
    times, fastest = np.median(rounds, axis=0), rounds.min(axis=0)
    with busy(name, solver, options.poses, options.threads - 1):
        beside = np.median(timed(calls[:1], options.rounds, time.perf_counter))
    return {
        "robot": name,
        "solver": solver,
        "threads": options.threads,
        "poses": len(poses),
        "one_us": times[0],
        "more_us": times[1],
        "gain": times[0] / times[1],
        "at_best": fastest[0] / fastest[1],
        "limit": options.threads * times[0] / (beside * 1e6 / len(poses)),
    }


@contextmanager
def busy(name: str, solver: str, poses: int, count: int) -> Iterator[None]:
    """Have so many other processes solve poses, one thread each, meanwhile."""
    context = multiprocessing.get_context("spawn")
    pairs = [context.Pipe() for _ in range(count)]
    others = [
        context.Process(target=_solve_on, args=(name, solver, poses, theirs)) for _, theirs in pairs
    ]
    for other in others:
        other.start()
    for ours, _ in pairs:
        ours.recv()
    try:
        yield
    finally:
        for (ours, _), other in zip(pairs, others, strict=True):
            ours.send(None)
            other.join()


def _solve_on(name: str, solver: str, count: int, connection: Connection) -> None:
    """Solve the same poses until something comes through the connection."""
    torch.set_num_threads(1)
    robot = load_robot(name)
    poses = reachable(robot, count)
    loaded = load_solver(solver, robot, threads=1)
    loaded.solve(poses)
    connection.send(None)
    while not connection.poll():
        loaded.solve(poses)


def markdown(table: pd.DataFrame, threads: int) -> str:
    """The table for readers."""
    lines = [
        f"| robot | solver | one thread us | {threads} threads us | gain | at best | limit |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row.robot} | `{row.solver}` | {row.one_us:.3f} | {row.more_us:.3f} | {row.gain:.2f} "
        f"| {row.at_best:.2f} | {row.limit:.2f} |"
        for row in table.itertuples()
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    main()
