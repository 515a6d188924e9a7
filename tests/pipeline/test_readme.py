"""Every command of README runs: here up to its configuration, in tests/slow to its end."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.commands import COMMANDS
from pipeline.commands.paper import OWN
from pipeline.commands.protocols import NAME as PROTOCOLS
from pipeline.commands.suites import NAME
from pipeline.config import compose, sweep
from pipeline.locations import CONF_DIR
from pipeline.stages.graph import STAGES
from tests.readme import README, blocks, commands

PIPELINE = ["python", "-m", "pipeline"]
OF_PIPELINE = [words[3:] for words in commands() if words[:3] == PIPELINE and words[3:]]
OTHERS = [words for words in commands() if words[:3] != PIPELINE]


def test_there_are_commands_of_every_kind() -> None:
    assert len(OF_PIPELINE) > 20
    assert {words[0] for words in OTHERS} == {"make", "dvc"}
    assert {words[0] for words in OF_PIPELINE} >= {*STAGES, "chat", "doctor", "benchmark"}


@pytest.mark.parametrize("words", OF_PIPELINE, ids=" ".join)
def test_a_command_of_the_pipeline_is_one_and_its_keys_compose(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    name, *arguments = words
    assert name in STAGES or name in COMMANDS
    if name not in STAGES:
        assert main([name, "--help"]) == 0
        assert capsys.readouterr().out
    own = {"paper": (*OWN,), "suites": (NAME,), "protocols": (PROTOCOLS,)}.get(
        name, ()
    )  # the command's own keys
    keys = [item for item in arguments if "=" in item and item.partition("=")[0] not in own]
    flags = [item for item in arguments if item.startswith("-m")]
    assert set(flags) <= {"-m", "--multirun"}
    if name in STAGES:
        assert [item for item in arguments if item not in (*keys, *flags)] == []
    if flags:
        runs = sweep(keys)
        assert len(runs) > 1
        assert compose(runs[0]) != compose(runs[-1])
    elif name in STAGES or keys:
        compose(keys)


@pytest.mark.parametrize("words", OTHERS, ids=" ".join)
def test_a_command_of_make_or_dvc_is_one(words: list[str]) -> None:
    tool = shutil.which(words[0]) or str(Path(sys.executable).with_name(words[0]))
    if words[0] == "make":
        done = subprocess.run([tool, "-n", *words[1:]], cwd=README.parent, capture_output=True)
        assert done.returncode == 0, done.stderr
        return
    options = [item for item in words[1:] if not item.startswith("-")]
    subcommands = options[: 2 if options[0] in ("exp", "metrics", "plots") else 1]
    done = subprocess.run([tool, *subcommands, "--help"], capture_output=True)
    assert done.returncode == 0, done.stderr
    for edit in (item for item in options if ".yaml:" in item):
        assert (CONF_DIR.parent / edit.partition(":")[0]).exists(), edit


def test_the_example_in_python_runs() -> None:
    (code,) = blocks("python")
    names: dict[str, object] = {}
    exec(compile(code, str(README), "exec"), names)
    assert names["solution"].found.mean() > 0.99  # type: ignore[attr-defined]


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
