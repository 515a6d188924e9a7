"""Lines of the leaderboard of this machine: every suite, robot and solver, on one core, resumably.

    python benchmarks/leaderboard.py [--robots panda nico] [--solvers lm placo] [--machine NAME]
        [--folder FOLDER] [--plan] [key=value ...]

Prints first how many minutes are to be expected, adds robots of packages and trains their networks,
evaluates what has no rows yet (called again after a kill it goes on), judges all rows again and
writes results/leaderboard/MACHINE/SUITE_ROBOT.csv. To be run on a quiet machine; with --plan it
prints the expectation alone. Rows lie in results/PROFILE.

`lm` and refined CycleIK follow all trajectories of tracking, the others the first ones
(evaluate.trajectories): their lines say how many.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

import baselines
from benchmarks import package_robots
from benchmarks.studies import write_study
from pipeline.commands.leaderboard import FOLDER, Destination, add_file
from pipeline.commands.suites import suites_of
from pipeline.config import compose, group_choices
from pipeline.evaluation.config import row_name
from pipeline.leaderboard.boards import read_boards
from pipeline.leaderboard.standings import ranked
from pipeline.locations import results
from pipeline.settings import Config
from pipeline.site.boards import leads_table
from pipeline.stages.forecast import rates
from pipeline.stages.inputs import artifacts
from pipeline.suites.config import TRACKING
from robots import load_robot

ROBOTS = ("nicol", "nico", "valkyrie", "panda", "fetch", *package_robots.ROBOTS)
SOLVERS = ("cycleik", "cycleik_refined", "lm", "lookup", "pinocchio", "placo", "trac_ik", "bio_ik")
# Of the extra `solvers`, where they are installed.
LIBRARIES = ("optik", "pink", "mink", "frankik", "ssik", "eaik", "roboticstoolbox")
FOLLOW_ALL = ("lm", "cycleik_refined")
FOLLOWED = 20  # trajectories that the others follow: some take a millisecond for each waypoint
FEWER = f"evaluate.trajectories={FOLLOWED}"
WAYPOINTS = 1530.0  # of a trajectory, both rates together: 9,194 of six of NICO
OVERHEAD_S = 12.0  # of a suite of a robot: imports, kernels from the cache, generating the poses


def main() -> None:
    """Run what is missing, then write the lines."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--robots", nargs="+", default=list(ROBOTS))
    parser.add_argument("--solvers", nargs="+", default=[*SOLVERS, *LIBRARIES])
    parser.add_argument("--machine", help="name of the folder; from processor and threads if none")
    parser.add_argument("--folder", type=Path, help=f"of the boards; results/{FOLDER} if none")
    parser.add_argument("--plan", action="store_true", help="print what it will take, no more")
    options, overrides = parser.parse_known_args()
    # What stands behind a list of names belongs to it as far as argparse knows.
    overrides += [word for word in (*options.robots, *options.solvers) if "=" in word]
    options.robots = [name for name in options.robots if "=" not in name]
    options.solvers = [name for name in options.solvers if "=" not in name]
    if unknown := {*options.robots} - {*ROBOTS} | {*options.solvers} - {*baselines.names()}:
        parser.error(f"no robot or solver of the leaderboard: {', '.join(sorted(unknown))}")
    config = compose(overrides)
    per_robot = expected_minutes(config, options.solvers)
    minutes = per_robot * len(options.robots)
    print(f"expected: {minutes:.0f} min of one core, {per_robot:.0f} a robot, without what is kept")
    if options.plan:
        return
    to = Destination(options.folder or results() / FOLDER, options.machine)
    for robot in options.robots:
        package_robots.ensure(robot)
        able = solvers_of(robot, options.solvers)
        for names, fewer in (
            ([name for name in able if name in FOLLOW_ALL], []),
            ([name for name in able if name not in FOLLOW_ALL], [FEWER]),
        ):
            if names:
                solvers = f"evaluate.solvers=[{','.join(names)}]"
                suites_of([f"robot={robot}", solvers, *fewer, *overrides])
        for path in rows_of(config, robot, able):
            board, notes = add_file(path, to, overrides)
            print(*notes, f"{path.name} -> {board}", sep="\n", flush=True)
    if options.folder is None:
        write_leads(to.folder, config)


def write_leads(folder: Path, config: Config) -> None:
    """Write results/studies/suite_leads: who is ahead on each board, and within what time."""
    lines = ranked(read_boards(folder), config.report.confidence)
    table = leads_table(lines, config.report)
    text = table.to_markdown().partition("\n")[2]  # without the line on the report
    command = "python -m benchmarks.leaderboard"
    write_study("suite_leads", pd.DataFrame(table.records()), text, command, str(config.seed))


def expected_minutes(config: Config, solvers: Sequence[str]) -> float:
    """Return the minutes of one core that all suites of a robot are expected to take.

    Without those of training, where a network is missing.
    """
    table = rates()
    evaluate = table[(table.stage == "evaluate") & (table.what == "")]
    a_pose = float(evaluate.core_seconds.iloc[0])
    names = group_choices("suite")
    poses: float = config.suite.poses * sum(name != TRACKING for name in names) * len(solvers)
    most = config.suite.trajectories
    poses += WAYPOINTS * sum(most if n in FOLLOW_ALL else min(most, FOLLOWED) for n in solvers)
    return (poses * a_pose + len(names) * OVERHEAD_S) / 60


def solvers_of(robot: str, names: Sequence[str]) -> list[str]:
    """Return the solvers that can run here for a robot; the others are named with the reason."""
    reasons = {name: baselines.skip(name, load_robot(robot)) for name in names}
    for name, reason in reasons.items():
        if reason:
            print(f"{robot} goes on without {name}: {reason}")
    return [name for name, reason in reasons.items() if reason is None]


def rows_of(config: Config, robot: str, solvers: Sequence[str]) -> Iterator[Path]:
    """Yield the files of rows of a robot that there are."""
    folders = artifacts(config)
    for suite in group_choices("suite"):
        for solver in solvers:
            label = row_name(solver, config.evaluate.pinned)
            path = folders.evaluate_suite(robot, suite, label)
            if path.exists():
                yield path


if __name__ == "__main__":
    main()
