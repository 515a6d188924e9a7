"""A file for each step that says what code it depends on: what DVC compares instead of sources."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.closure import SourceTree
from pipeline.config import bench_lists, compose
from pipeline.data.files import sha256, write_json
from pipeline.learning.card import CARD, ROBOTS
from pipeline.learning.registry import declared_modules
from pipeline.stages.graph import NETWORKS, STAGES, STEPS, Step
from pipeline.stages.solvers import solver_modules

if TYPE_CHECKING:
    from pipeline.settings import Config

FOLDER = "results/code"  # below the checkout


def file_name(step: Step, solver: str) -> str:
    """Return the name of a step's file, of one solver's where the step fans out over solvers."""
    return f"{step.name}-{solver}.json" if "solver" in step.over else f"{step.name}.json"


def roots(step: Step, solver: str = "", config: Config | None = None) -> tuple[str, ...]:
    """Return the modules whose closure a step runs: its stage, solvers, and networks.

    Args:
        step: Of the graph.
        solver: Value of the axis of that name, where the step has one.
        config: Of the run; that of conf/bench.yaml where left out.
    """
    stage = STAGES[step.stage]
    names = [solver] if "solver" in step.over else stage.solver_names(config or _composed(""))
    kinds = [(config or _composed(step.model)).model.kind] if "train" in stage.groups else []
    networks = [module for kind in kinds for module in declared_modules(kind)]
    return (stage.module, *solver_modules([*names, *step.settings]), *networks)


@cache
def _composed(model: str) -> Config:
    """The configuration of a whole run, or with a network of its own."""
    bench = bench_lists()
    return compose([f"profile={bench['profile']}", f"model={model or bench['model']}"])


def code_files(tree: SourceTree) -> dict[str, dict[str, Any]]:
    """Return the content of each step's file by name: one digest for all, and each module's.

    Args:
        tree: The code.
    """
    bench = bench_lists()
    found = {}
    for step in STEPS.values():
        for solver in bench[step.over["solver"]] if "solver" in step.over else [""]:
            modules = roots(step, solver)
            content = {"code": tree.digest(*modules), "modules": tree.digests(*modules)}
            if any(NETWORKS in override for override in step.overrides):
                content["networks"] = _networks()
            found[file_name(step, solver)] = content
    return found


def _networks() -> dict[str, str]:
    """Return a checksum for each card of a network that comes with the project."""
    cards = [path for kind in ("weights", "detector") for path in ROBOTS.glob(f"*/{kind}/{CARD}")]
    return {path.relative_to(ROBOTS).as_posix(): sha256(path) for path in sorted(cards)}


def write_code_files(tree: SourceTree, folder: Path) -> list[Path]:
    """Write the files of all steps and remove those of steps that are no more; return their paths.

    Args:
        tree: The code.
        folder: Receives them.
    """
    contents = code_files(tree)
    for path in folder.glob("*.json"):
        if path.name not in contents:
            path.unlink()
    for name, content in contents.items():
        write_json(folder / name, content)
    return [folder / name for name in contents]
