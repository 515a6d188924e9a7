"""The code that a result depends on: what is in its closure, and which edits its digest notices."""

from __future__ import annotations

import ast
import json
import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

from pipeline.closure import SourceTree
from pipeline.stages.code_files import code_files, file_name, roots
from pipeline.stages.graph import STAGES, STEPS
from pipeline.stages.solvers import solver_modules
from robots.locations import FOLDER

OURS = ("pipeline", "baselines", "robots")
NAMED = (
    "robots/pinocchio_model.py",
    "robots/rotations.py",
    "robots/limits.py",
    "pipeline/seeding.py",
)
TREE = SourceTree()
IMPORTER = """
import importlib, json, sys

def ours():
    packages = ("pipeline", "baselines", "robots")
    return [name for name in sys.modules if name.split(".")[0] in packages]

found = {}
for module in sys.argv[1:]:
    for name in ours():
        del sys.modules[name]
    importlib.import_module(module)
    found[module] = ours()
print(json.dumps(found))
"""


def sources() -> list[str]:
    paths = (path for top in OURS for path in (FOLDER / top).rglob("*.py"))
    return sorted(path.relative_to(FOLDER).as_posix() for path in paths)


SAMPLED = random.Random(15).sample(sorted({*sources()} - {*NAMED}), 15)


def edited(file: str, edit: Callable[[str], str]) -> SourceTree:
    """The tree with an edit of one file, none of which touches the disk."""

    def read(path: Path) -> bytes:
        text = path.read_bytes()
        return edit(text.decode()).encode() if path == FOLDER / file else text

    return SourceTree(read)


def digests(tree: SourceTree) -> dict[str, str]:
    return {name: content["code"] for name, content in code_files(tree).items()}


@cache
def as_they_are() -> dict[str, str]:
    return digests(TREE)


@cache
def imports(file: str) -> frozenset[str]:
    """Files of ours that a file imports, by a reading of its syntax that is not grimp's."""
    tree = ast.parse((FOLDER / file).read_text(encoding="utf-8"))
    found = set()
    for name in imported_names(tree):
        parts = name.split(".")
        for end in range(1, len(parts) + 1):
            place = FOLDER.joinpath(*parts[:end])
            for path in (place / "__init__.py", place.with_suffix(".py")):
                if path.is_file():
                    found.add(path.relative_to(FOLDER).as_posix())
    return frozenset(found)


def imported_names(node: ast.AST) -> Iterator[str]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
            continue
        if isinstance(child, ast.ImportFrom) and (child.module or "").split(".")[0] in OURS:
            yield from (f"{child.module}.{alias.name}" for alias in child.names)
        elif isinstance(child, ast.Import):
            yield from (alias.name for alias in child.names if alias.name.split(".")[0] in OURS)
        else:
            yield from imported_names(child)


def reached(modules: tuple[str, ...]) -> set[str]:
    """Files that some modules run, found from their syntax."""
    waiting = [f"{module.replace('.', '/')}.py" for module in modules]
    parted = [module.split(".") for module in modules]
    waiting += [f"{'/'.join(m[:n])}/__init__.py" for m in parted for n in range(1, len(m) + 1)]
    found: set[str] = set()
    while waiting:
        file = waiting.pop()
        if file not in found and (FOLDER / file).is_file():
            found.add(file)
            waiting += imports(file)
    return found


def stale_by_reading(file: str) -> set[str]:
    """Names of the code files of the steps that run a file."""
    solvers = {name.removesuffix(".json").partition("-")[2] for name in as_they_are()}
    return {
        file_name(step, solver)
        for step in STEPS.values()
        for solver in (solvers if "solver" in step.over else {""})
        if file_name(step, solver) in as_they_are() and file in reached(roots(step, solver))
    }


@pytest.mark.parametrize("file", [*NAMED, *SAMPLED])
def test_an_edit_of_code_makes_exactly_those_steps_stale_that_run_it(file: str) -> None:
    after = digests(edited(file, lambda text: f"{text}\nEDITED = 1\n"))
    changed = {name for name, digest in as_they_are().items() if after[name] != digest}
    assert changed == stale_by_reading(file)


@pytest.mark.parametrize("file", [*NAMED, *SAMPLED])
def test_a_comment_or_a_docstring_makes_none_stale(file: str) -> None:
    def speak(text: str) -> str:
        tree = ast.parse(text)
        first = tree.body[0] if tree.body else None
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            lines = text.splitlines()
            text = "\n".join(['"""Something else is said."""', *lines[first.end_lineno :]])
        return f"# A remark.\n\n{text}  # and another\n"

    assert digests(edited(file, speak)) == as_they_are()


def test_what_the_issue_names_counts_where_it_is_run() -> None:
    everywhere = stale_by_reading("robots/limits.py")
    assert {"dataset.json", "train.json", "plan.json", "grasp.json"} <= everywhere
    assert "evaluate_numerical-lm.json" in stale_by_reading("robots/pinocchio_model.py")
    assert {"train.json", "plan.json"} <= stale_by_reading("pipeline/seeding.py")


def test_a_solver_counts_for_its_own_evaluation() -> None:
    after = digests(edited("baselines/trac_ik.py", lambda text: f"{text}\nEDITED = 1\n"))
    changed = {name for name, digest in as_they_are().items() if after[name] != digest}
    evaluations = {name for name in changed if name.startswith("evaluate")}
    assert evaluations == {"evaluate_numerical-trac_ik.json", "evaluate_seeded-trac_ik.json"}
    assert "plan.json" in changed  # plan.solvers names it


def test_a_network_that_is_named_only_counts_where_it_is_trained_and_answers() -> None:
    flow = edited("pipeline/learning/flow/network.py", lambda text: f"{text}\nEDITED = 1\n")
    changed = {name for name, digest in as_they_are().items() if digests(flow)[name] != digest}
    assert changed == {"train_flow.json", "evaluate_flow-flow.json"}
    experts = edited("pipeline/learning/cycleik/experts.py", lambda text: f"{text}\nEDITED = 1\n")
    changed = {name for name, digest in as_they_are().items() if digests(experts)[name] != digest}
    assert {"train.json", "evaluate_neural-cycleik_refined.json"} <= changed
    assert "train_flow.json" not in changed


def test_a_kernel_and_a_template_count() -> None:
    for module, file in (
        ("pipeline.stages.plan", "pipeline/planning/follow_kernel.py"),
        ("pipeline.reporting.page", "pipeline/reporting/report.html.jinja"),
    ):
        before = TREE.digest(module)
        assert edited(file, lambda text: f"{text}\nEDITED = 1\n").digest(module) != before


def test_the_code_of_an_evaluation_leaves_reporting_and_planning_alone() -> None:
    closure = TREE.closure(STAGES["evaluate"].module, *solver_modules(["lm"]))
    assert not {name for name in closure if name.startswith("pipeline.reporting")}
    assert not {name for name in closure if name.startswith("pipeline.planning")}


def test_closures_hold_what_is_imported_when_the_stages_are() -> None:
    modules = [stage.module for stage in STAGES.values()]
    command = [sys.executable, "-c", IMPORTER, *modules, "baselines.bio_ik"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=FOLDER)
    for module, loaded in json.loads(done.stdout).items():
        assert not set(loaded) - TREE.closure(module), module


def test_a_package_of_ones_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "tiny_tree"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "a.py").write_text("def f():\n    from tiny_tree import b\n    return b\n")
    (folder / "b.py").write_text(
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import tiny_tree.c\n"
    )
    (folder / "c.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    tree = SourceTree(packages=["tiny_tree"])
    assert tree.closure("tiny_tree.a") == {"tiny_tree", "tiny_tree.a", "tiny_tree.b"}
    first = tree.digest("tiny_tree.a")
    (folder / "b.py").write_text("x = 1\n")
    assert SourceTree(packages=["tiny_tree"]).digest("tiny_tree.a") != first
