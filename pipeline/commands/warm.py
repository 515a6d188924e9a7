"""`warm`: compile the kernels of robots, solvers and planner before somebody waits for them."""

from __future__ import annotations

import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

import numba

from pipeline.commands.arguments import command_parser
from pipeline.data.files import write_text
from pipeline.engine.cores import usable_cores
from pipeline.progress import bar
from robots import Obstacles, load_robot
from robots.compile_notice import stay_silent
from robots.compiled_cache import source_digest

DESCRIPTION = """\
Compiles the kernels that robots, solvers and the planner run, which otherwise happens when they are
first called. They are kept on disk: once a state of the sources is compiled, this returns at once.
"""
ROOT = Path(__file__).parents[2]
COMPILED = (
    "robots",
    "baselines",
    "pipeline/planning",
    "pipeline/learning",
    "pipeline/learning/cycleik",
    "pipeline/learning/cycleik/compiled",
)
STAMP = Path(__file__).parent / "__pycache__" / "kernels"
ROBOT = "panda"  # any will do: kernels are compiled for types, not for robots


def warm(arguments: list[str]) -> int:
    """Compile what this state of the sources has not compiled yet, on all cores."""
    command_parser("warm", DESCRIPTION).parse(arguments)
    state = _state()
    if STAMP.exists() and STAMP.read_text(encoding="utf-8") == state:
        return 0
    workers = min(usable_cores(), len(KERNELS))
    with (
        ProcessPoolExecutor(workers, get_context("spawn"), stay_silent) as pool,
        bar(len(KERNELS), "group", "compiling kernels, once") as shown,
    ):
        for future in as_completed([pool.submit(compile_kernels, name) for name in KERNELS]):
            future.result()
            shown.update()
    write_text(STAMP, state)
    return 0


def compile_kernels(name: str) -> None:
    """Compile one group of kernels by calling what needs them.

    Args:
        name: A key of `KERNELS`.
    """
    KERNELS[name]()


def _robot() -> None:
    robot = load_robot(ROBOT)
    joints = robot.sample(8)
    robot.forward_kinematics(joints)
    robot.jacobian(joints)


def _solver(name: str) -> None:
    import baselines
    from pipeline.loading import load_solver

    robot = load_robot(ROBOT)
    poses = robot.forward_kinematics(robot.home[None])
    many = poses.repeat(4, axis=0)
    if baselines.skip(name, robot):
        return
    solver = load_solver(name, robot)
    solver.solve(poses)
    solver.solve(poses, budget=baselines.Budget(time_s=1.0))  # another version of the query
    if "threads" in baselines.registry.settings(name):
        load_solver(name, robot, threads=2).solve(many)


def _freedoms() -> None:
    from pipeline.loading import load_solver

    robot = load_robot(ROBOT)
    load_solver("lm", robot).explain(robot.forward_kinematics(robot.home)[0])


def _avoid() -> None:
    from pipeline.loading import load_solver

    robot = load_robot(ROBOT)
    poses = robot.forward_kinematics(robot.home[None])
    load_solver("lm", robot).solve(poses, avoid=Obstacles())


def _planner() -> None:
    from pipeline.loading import load_solver
    from pipeline.planning import plan_motion

    robot = load_robot(ROBOT)
    solver = load_solver("lm", robot)
    start, target = robot.forward_kinematics(robot.sample(2))
    plan_motion(robot, solver, start, target)


KERNELS = {
    "avoid": _avoid,
    "planner": _planner,
    "cycleik_refined": lambda: _solver("cycleik_refined"),
    "cycleik": lambda: _solver("cycleik"),
    "robot": _robot,
    "bio_ik": lambda: _solver("bio_ik"),
    "lm": lambda: _solver("lm"),
    "freedoms": _freedoms,
}


def _state() -> str:
    """What compiled kernels depend on: the sources, Numba, and where it keeps them."""
    sources = source_digest(*(ROOT / package for package in COMPILED))
    return f"{sources} {numba.__version__} {os.environ.get('NUMBA_CACHE_DIR', '')}\n"
