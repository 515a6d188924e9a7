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
from baselines.registry import settings
from pipeline import provenance
from pipeline.config import bench_lists
from pipeline.errors import PipelineError
from pipeline.learning.weights import WeightsError
from pipeline.loading import find_weights
from pipeline.locations import need_checkout, results
from pipeline.packages import missing_parts
from pipeline.solvers import told_path
from robots import available_robots, load_robot
from robots.locations import home

HELP_FLAGS = ("-h", "--help")
ADD_USAGE = "python -m pipeline robot add my.urdf --base BASE --tip TIP [--name NAME]"
PICTURE_USAGE = "python -m pipeline robot picture NAME"


def _plain(command: Callable[[], int]) -> Callable[[list[str]], int]:
    """Make a command of a function that takes no arguments; it explains itself on --help."""

    @functools.wraps(command)
    def run(arguments: list[str]) -> int:
        name = command.__name__
        if any(flag in arguments for flag in HELP_FLAGS):
            print(f"python -m pipeline {name}\n\n{inspect.getdoc(command)}")
            return 0
        if arguments:
            raise PipelineError(f"`{name}` takes no arguments, got {' '.join(arguments)}")
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
        return told_path(find_weights("cycleik", load_robot(name)))
    except (SkippedSolver, WeightsError) as error:
        return str(error)


def robot(arguments: list[str]) -> int:
    """Bring a robot of one's own with `robot add`, or draw one anew with `robot picture`."""
    action, rest = arguments[:1], arguments[1:]
    if action in ([], ["-h"], ["--help"]):
        print(f"{ADD_USAGE}\n{PICTURE_USAGE}")
        return 0
    if action == ["add"]:
        return _add_robot(rest)
    if action == ["picture"]:
        return _draw_robot(rest)
    raise PipelineError(f"usage: {ADD_USAGE}, or {PICTURE_USAGE}")


def _add_robot(arguments: list[str]) -> int:
    if not arguments:
        raise PipelineError(f"usage: {ADD_USAGE}")
    options: dict[str, str] = {}
    rest = arguments[1:]
    while rest:
        key = rest[0].removeprefix("--")
        if key not in ("base", "tip", "name") or len(rest) < 2:
            raise PipelineError(f"'{rest[0]}' is not understood; usage: {ADD_USAGE}")
        options[key] = rest[1]
        rest = rest[2:]
    if missing := {"base", "tip"} - options.keys():
        raise PipelineError(f"--{' and --'.join(sorted(missing))} is missing; usage: {ADD_USAGE}")
    need_checkout("a robot of one's own (robots/<name>/ and conf/robot/<name>.yaml)")
    from robots.add import add_robot

    print(add_robot(arguments[0], options["base"], options["tip"], name=options.get("name")))
    return 0


def _draw_robot(arguments: list[str]) -> int:
    if len(arguments) != 1:
        raise PipelineError(f"usage: {PICTURE_USAGE}")
    robot = load_robot(arguments[0])
    from robots.picture import write_picture

    print(write_picture(robot))
    return 0


@_plain
def paths() -> int:
    """Print where the tables, figures and the report of the default profile are."""
    folder = results() / bench_lists()["profile"]
    for name, path in (("tables", "tables"), ("figures", "figures"), ("report", "report.html")):
        state = "" if (folder / path).exists() else "   (not made yet: make reproduce)"
        print(f"{name:<8} {folder / path}{state}")
    return 0
