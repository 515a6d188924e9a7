"""The stages: each calls the library and writes one artifact with its card."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import cast

from pipeline.settings import Config

STAGES = {
    "dataset": "collision-filtered poses for training, validation and test",
    "tune": "hyperparameter search with Optuna",
    "compare-tuned": "the best of a search against Table I, at equal training budget",
    "train": "a network through differentiable forward kinematics",
    "evaluate": "solvers on the test poses, one raw row a pose",
    "sample": "many solutions of one pose, and how they spread",
    "plan": "Bezier motions between random poses",
    "detector": "a network that finds a robot's things in the picture of its eye",
    "grasp": "pick-and-drop trials in simulation",
    "report": "tables, figures and report.html from everything on disk",
}
EXPERIMENTS = ("sample", "compare-tuned")  # on demand: not among what `all` runs
PER_ROBOT = tuple(name for name in STAGES if name not in ("report", *EXPERIMENTS))


def run_stage(name: str, config: Config) -> list[Path]:
    """Run one stage and return what it wrote."""
    return cast(Callable[[Config], list[Path]], stage_module(name).run)(config)


def stage_module(name: str) -> ModuleType:
    """Return the module of a stage; a dash in its name is an underscore there."""
    return import_module(f"pipeline.stages.{name.replace('-', '_')}")
