"""Stages at the smoke scale as the attacks run them: in a process forked from one that is warm.

A fork has the modules that a stage needs, so that a signal at a random moment meets work and not
imports.
"""

from __future__ import annotations

import io
import os
import sys
import traceback
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from pipeline.stages.graph import STAGES

ROBOT = "nico"  # the smallest robot that grasps and has a detector
COMMON = (
    f"robot={ROBOT}",
    "profile=smoke",
    "dataset.workers=1",
    "train.checkpoint_s=0.02",
    "evaluate.iterations=60",  # the same answers at any speed
    "evaluate.time_s=null",
    "evaluate.chunk=20",
    "evaluate.solvers=[cycleik,pinocchio]",
    "report.dpi=40",
    *(f"grasp.recording.{key}" for key in ("width=160", "height=120", "closeup=0")),
)
COMPARISON = tuple(  # by poses seen: seconds are of this machine, and many
    f"tune.comparison.{key}"
    for key in ("currency=poses", "amount=4000", "replicates=2", "candidates=[best,default]")
)
# Stage, what it is called here, and further overrides; later ones read what earlier ones leave.
RUNS: dict[str, tuple[str, ...]] = {
    "dataset": (),
    "tune": (),
    "train": (),
    "evaluate": (),
    "sample": ("model=null_space", "train.epochs=1"),
    "plan": ("plan.solvers=[cycleik,cycleik_refined,lm]",),  # those that no clock stops
    "detector": (),
    "grasp": (),
    "grasp_agent": ("perception=camera", "agent=policy"),
    "compare_tuned": COMPARISON,
    "report": (),
}
# What a run leaves below the results folder, where that is not a folder of its name.
LEAVES = {
    "train": (f"train/{ROBOT}/tiny",),  # beside it lies what `sample` trained
    "report": ("tables", "figures", "report.html", "metrics.json"),
}


def stage_of(run: str) -> str:
    """The stage of a run: some stages run twice."""
    return {"grasp_agent": "grasp", "compare_tuned": "compare-tuned"}.get(run, run)


def command(run: str, folder: Path) -> list[str]:
    """The arguments of a run, written to a results folder."""
    return [stage_of(run), *COMMON, *RUNS[run], f"results_dir={folder}"]


def leaves(run: str) -> tuple[str, ...]:
    """Files and folders below the results folder that a run writes."""
    return LEAVES.get(run, (run,))


def warm_up() -> None:
    """Import what every stage needs, so that forks begin with their work."""
    for stage in STAGES.values():
        import_module(stage.module)
    for name in ("pipeline.commands.run", "pybullet", "pinocchio", "matplotlib.pyplot"):
        import_module(name)


def forked(call: Callable[[], int], log: Path) -> int:
    """Run a call in a process of a group of its own; its status is what the call returns.

    Args:
        call: Runs in the fork.
        log: Receives what it says.

    Returns:
        The number of the process.
    """
    sys.stdout.flush()
    number = os.fork()
    if number:
        return number
    status = 70
    try:
        os.setsid()
        stream = os.open(log, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
        os.dup2(stream, 1)
        os.dup2(stream, 2)
        sys.stdout, sys.stderr = (
            io.TextIOWrapper(os.fdopen(each, "wb", 0), write_through=True) for each in (1, 2)
        )
        status = call()
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def run_main(arguments: list[str]) -> Callable[[], int]:
    """The command line as a call."""

    def call() -> int:
        from pipeline.__main__ import main

        return main(arguments)

    return call


def ended(number: int) -> int:
    """Wait for a process and return its status, negative for a signal."""
    return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])
