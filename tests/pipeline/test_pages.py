"""Every command and snippet of README and docs/ runs.

Commands of the pipeline run here up to their configuration, in tests/slow to their end. Snippets in
Python run as they stand; what a `print` is said to print, it prints. Files that a page shows work
where they would be put.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml

import baselines
import pipeline
from baselines import registry
from pipeline.__main__ import main
from pipeline.commands import COMMANDS
from pipeline.commands.export import KEYS as EXPORT_KEYS
from pipeline.commands.instructions import EXECUTE
from pipeline.commands.protocols import NAME as PROTOCOLS
from pipeline.commands.site import COMPARE, DIR
from pipeline.commands.suites import NAME as SUITES
from pipeline.commands.view import with_group
from pipeline.commands.whole import OWN
from pipeline.config import compose, sweep
from pipeline.locations import CONF_DIR
from pipeline.stages.graph import STAGES
from robots import load_robot
from tests.examples import scripts
from tests.pages import PAGES, README, ROOT, blocks, commands, files, snippets

PIPELINE = ["python", "-m", "pipeline"]
OF_PIPELINE = [words[3:] for words in commands() if words[:3] == PIPELINE and words[3:]]
OTHERS = [words for words in commands() if words[:3] != PIPELINE]
ACTIONS = (
    "model=none",
    "plan=true",
    "processes=16",
    "robots=[panda,nico]",
)  # keys of commands, see their help
PRINTED = re.compile(r"^ *print\(.*\)  # (.*)$", re.MULTILINE)
WITH_SNIPPETS = [page for page in PAGES if snippets(page)]
SOLVER_PAGE = ROOT / "docs" / "tutorials" / "solver.md"


def test_there_are_commands_of_every_kind() -> None:
    assert len(OF_PIPELINE) > 20
    assert {words[0] for words in OTHERS} == {"make", "dvc", "python"}
    assert {words[0] for words in OF_PIPELINE} >= {*STAGES, "chat", "doctor", "benchmark"}


def test_every_block_is_of_a_kind_that_is_run_or_checked() -> None:
    kinds = {each.language for page in PAGES for each in blocks(page)}
    assert kinds == {"sh", "python", "yaml", "math"}


@pytest.mark.parametrize("words", OF_PIPELINE, ids=" ".join)
def test_a_command_of_the_pipeline_is_one_and_its_keys_compose(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    name, *arguments = words
    assert name in STAGES or name in COMMANDS
    if name not in STAGES:
        assert main([name, "--help"]) == 0
        assert capsys.readouterr().out
    its_own = {
        "export": EXPORT_KEYS,
        "instructions": (EXECUTE,),
        "paper": (*OWN,),
        "suites": (SUITES,),
        "protocols": (PROTOCOLS,),
        "site": (DIR, COMPARE),
    }
    own = its_own.get(name, ())
    keys = [
        item
        for item in arguments
        if "=" in item and item.partition("=")[0] not in own and item not in ACTIONS
    ]
    flags = [item for item in arguments if item.startswith("-m")]
    assert set(flags) <= {"-m", "--multirun"}
    if name in STAGES:
        assert [item for item in arguments if item not in (*keys, *flags, "--help")] == []
    if name in ("view", "watch"):
        keys = with_group(keys)
    if flags:
        runs = sweep(keys)
        assert len(runs) > 1
        assert compose(runs[0]) != compose(runs[-1])
    elif name in STAGES or keys:
        compose(keys)


@pytest.mark.parametrize("words", OTHERS, ids=" ".join)
def test_a_command_of_another_program_is_one(words: list[str]) -> None:
    if words[:2] == ["python", "-m"]:  # a measurement: its own test says what it does
        assert find_spec(words[2]) is not None
        return
    if words[0] == "python":  # tests of the examples run them
        assert [words[0], ROOT / words[1]] in [["python", path] for path in scripts()]
        return
    tool = shutil.which(words[0]) or str(Path(sys.executable).with_name(words[0]))
    if words[0] == "make":
        done = subprocess.run([tool, "-n", *words[1:]], cwd=ROOT, capture_output=True)
        assert done.returncode == 0, done.stderr
        return
    options = [item for item in words[1:] if not item.startswith("-")]
    subcommands = options[: 2 if options[0] in ("exp", "metrics", "plots") else 1]
    done = subprocess.run([tool, *subcommands, "--help"], capture_output=True)
    assert done.returncode == 0, done.stderr
    for edit in (item for item in options if ".yaml:" in item):
        assert (CONF_DIR.parent / edit.partition(":")[0]).exists(), edit


@pytest.mark.parametrize("page", WITH_SNIPPETS, ids=lambda page: page.stem)
def test_the_snippets_of_a_page_run_and_print_what_they_say(
    page: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "__main__"}
    for code in snippets(page):
        exec(compile(code, str(page), "exec"), names)
        printed = capsys.readouterr().out.splitlines()
        for said in PRINTED.findall(code):
            assert said in printed, f"{page.name}: {said} is not among {printed}"
    assert not list(tmp_path.iterdir())


def test_the_example_of_readme_finds_its_solutions() -> None:
    (code,) = snippets(README)
    names: dict[str, object] = {}
    exec(compile(code, str(README), "exec"), names)
    assert names["solution"].found.mean() > 0.99  # type: ignore[attr-defined]


def test_the_solver_in_the_tree_works_where_the_page_puts_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    shown = files(SOLVER_PAGE)
    assert set(shown) == {"baselines/nearest.py", "conf/solver/nearest.yaml"}
    for name, text in shown.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    shutil.copytree(registry.FOLDER, tmp_path / "conf" / "solver", dirs_exist_ok=True)
    monkeypatch.setattr(registry, "FOLDER", tmp_path / "conf" / "solver")
    monkeypatch.setattr(baselines, "__path__", [*baselines.__path__, str(tmp_path / "baselines")])
    robot = load_robot("panda")
    solver = baselines.load("nearest", robot, count=100)
    # A remembered configuration is the nearest one to its own pose.
    poses = robot.forward_kinematics(robot.sample(100, seed=1, collision_free=False)[:5])
    assert solver.solve(poses).joints == pytest.approx(
        robot.sample(100, seed=1, collision_free=False)[:5]
    )
    assert not solver.solve(poses).found.any()
    with pytest.raises(baselines.SettingError):
        baselines.load("nearest", robot, count="many")
    assert compose(["evaluate.solvers=[nearest]", "solver.nearest.count=9"]).solver["nearest"] == {
        "count": 9
    }


def test_an_object_that_a_page_shows_is_one() -> None:
    page = ROOT / "docs" / "tutorials" / "grasping.md"
    (text,) = [each.text for each in blocks(page) if each.language == "yaml"]
    for name, values in yaml.safe_load(text).items():
        inline = yaml.safe_dump(values, default_flow_style=True, width=10_000).strip()
        compose([f"+grasp.objects.{name}={inline}", f"grasp.scenes.panda.objects=[{name}]"])


def test_the_page_of_the_api_has_every_public_name() -> None:
    text = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    documented = {name.rpartition(".")[2] for name in re.findall(r"^::: (\S+)", text, re.MULTILINE)}
    errors = {name for name in baselines.__all__ if hasattr(baselines.errors, name)}
    by_another_name = {"load", "names", "skip"}  # load_solver, `python -m pipeline solvers`
    assert documented >= {*pipeline.__all__} | ({*baselines.__all__} - errors - by_another_name)


def commands_of_conf() -> list[str]:
    """Commands in the headers of files under conf/."""
    found = []
    for path in sorted(CONF_DIR.rglob("*.yaml")):
        text = path.read_text(encoding="utf-8").replace("\\\n#", "")
        lines = (line.lstrip("# ") for line in text.splitlines() if line.startswith("#  "))
        found += [line for line in lines if line.startswith("python -m pipeline ")]
    return list(dict.fromkeys(found))


@pytest.mark.parametrize("line", commands_of_conf())
def test_commands_in_headers_of_conf_compose(line: str) -> None:
    words = line.partition("  #")[0].split()[3:]
    keys = [item for item in words[1:] if "=" in item]
    assert words[0] in STAGES or words[0] in COMMANDS
    for run in sweep(keys)[:1] if "-m" in words else [keys]:
        compose(run)
