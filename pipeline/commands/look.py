"""Commands for someone who has just arrived: robots, solvers, doctor; and a robot of one's own."""

from __future__ import annotations

import functools
import inspect
import os
import platform
import shutil
from collections.abc import Callable

import numpy as np

import baselines
from baselines import SkippedSolver
from baselines.outside import installed
from baselines.registry import settings
from pipeline import provenance
from pipeline.commands.arguments import command_parser
from pipeline.config import bench_lists
from pipeline.learning.card import WeightsError
from pipeline.loading import find_weights
from pipeline.locations import need_checkout, results
from pipeline.packages import missing_parts
from pipeline.solvers import displayed_path
from robots import available_robots, load_robot
from robots.locations import home


def _plain(command: Callable[[], int]) -> Callable[[list[str]], int]:
    """Make a command of a function that takes no arguments; it explains itself on --help."""

    @functools.wraps(command)
    def run(arguments: list[str]) -> int:
        command_parser(command.__name__, inspect.getdoc(command) or "").parse(arguments)
        return command()

    return run


@_plain
def robots() -> int:
    """List the robots with their chains."""
    for name in available_robots():
        robot = load_robot(name)
        low, high = np.round(robot.workspace, 2)
        print(f"{name}: {robot.description.title}")
        print(
            f"  {robot.dof} joints from {robot.base} to {robot.tip}: {', '.join(robot.joint_names)}"
        )
        print(f"  workspace of the tip, m: {low.tolist()} to {high.tolist()}")
    return 0


@_plain
def solvers() -> int:
    """List the solvers and say which cannot run here."""
    for name in baselines.names():
        target = settings(name)["_target_"]
        kind = "neural" if target.startswith("pipeline.") else "numerical"
        print(f"{name:<20} {kind:<10} {baselines.skip(name) or 'ready'}")
    for name, target in sorted(installed().items()):
        print(f"{name:<20} {'outside':<10} {target}")
    return 0


@_plain
def doctor() -> int:
    """Print versions, threads and accelerator, and what is missing; status 1 if anything is."""
    import torch

    found = provenance.versions()
    print(f"python {platform.python_version()} on {provenance.machine()['system']}")
    print(f"processor: {provenance.machine()['processor']}")
    print(f"cores: {provenance.machine()['cores']}, torch threads: {torch.get_num_threads()}")
    accelerator = (
        torch.cuda.get_device_name() if torch.cuda.is_available() else "none (CPU is used)"
    )
    print(f"accelerator: {accelerator}")
    free = shutil.disk_usage(home()).free / 1e9
    print(f"free disk: {free:.0f} GB, commit {provenance.commit()}, process {os.getpid()}")
    for package, version in found.items():
        print(f"  {package:<20} {version}")
    missing = [package for package, version in found.items() if version == "not installed"]
    for name in baselines.names():
        if reason := baselines.skip(name):
            print(f"  solver {name:<13} is skipped: {reason} (pip install .[solvers])")
    for name in available_robots():
        print(f"  weights for {name:<10} {_weights_of(name)}")
    for setting, reason in missing_parts().items():
        print(f"  {setting}: {reason}")
    if missing:
        print(f"missing: {', '.join(missing)}; run `make environment`")
    else:
        print("everything that the pipeline needs is here")
    return 1 if missing else 0


def _weights_of(name: str) -> str:
    """The trained weights that `load_solver` takes for a robot where none are named."""
    try:
        return displayed_path(find_weights("cycleik", load_robot(name)))
    except (SkippedSolver, WeightsError) as error:
        return str(error)


def robot(arguments: list[str]) -> int:
    """Bring a robot of one's own with `robot add`, or draw one anew with `robot picture`."""
    parser = command_parser("robot", inspect.getdoc(robot) or "")
    actions = parser.add_subparsers(dest="action", metavar="action", required=True)
    add = actions.add_parser("add", help="make a robot of a URDF")
    add.add_argument("urdf", metavar="FILE", help="the URDF; it is copied with its meshes")
    proposed = "where base or tip is left out, a chain is proposed"
    add.add_argument("--base", metavar="LINK", help=f"link that poses are relative to; {proposed}")
    add.add_argument("--tip", metavar="LINK", help=f"link that is brought to a pose; {proposed}")
    add.add_argument("--name", help="of the robot, and of its folder; the URDF's where left out")
    picture = actions.add_parser("picture", help="draw a robot anew")
    picture.add_argument("name", metavar="NAME", help="of the robot")
    options = parser.parse_args(arguments)
    if options.action == "add":
        need_checkout("a robot of one's own (robots/<name>/ and conf/robot/<name>.yaml)")
        from robots.add import add_robot

        print(add_robot(options.urdf, options.base, options.tip, name=options.name))
    else:
        from robots.picture import write_picture

        print(write_picture(load_robot(options.name)))
    return 0


@_plain
def paths() -> int:
    """Print where the tables, figures and the report of the default profile are."""
    folder = results() / bench_lists()["profile"]
    for name, path in (("tables", "tables"), ("figures", "figures"), ("report", "report.html")):
        state = "" if (folder / path).exists() else "   (not made yet: make reproduce)"
        print(f"{name:<8} {folder / path}{state}")
    return 0
