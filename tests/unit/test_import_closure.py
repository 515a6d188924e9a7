"""What a first import, and the help, must not import: libraries that only some runs use."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.commands import kept_help, stage_help
from pipeline.errors import ConfigError

ROOT = Path(__file__).parents[2]
LATER = (
    "hydra", "matplotlib", "omegaconf", "optuna", "pandas", "pinocchio", "pybullet", "pyarrow",
    "scipy.interpolate", "scipy.optimize", "scipy.special", "scipy.stats", "torch",
)  # fmt: skip
PRINTED = "; import sys; print(*sys.modules, file=sys.stderr)"


def imported(code: str) -> set[str]:
    """Names of the modules that a fresh interpreter has after it ran some code."""
    done = subprocess.run(
        [sys.executable, "-c", code + PRINTED], cwd=ROOT, check=True, capture_output=True, text=True
    )
    return set(done.stderr.split())


@pytest.mark.parametrize(
    "code",
    [
        "import pipeline",
        "from pipeline import load_robot, load_solver",
        "from pipeline import load_robot, load_solver; load_solver('lm', load_robot('panda'))",
        "from pipeline import plan_motion",
        "import pipeline.learning.card, pipeline.solvers, pipeline.planning",
    ],
)
def test_the_api_imports_what_it_needs(code: str) -> None:
    assert not imported(code) & set(LATER)


def test_the_command_line_lists_its_commands_without_a_library_for_numbers() -> None:
    found = imported("from pipeline.__main__ import main; main(['--help'])")
    assert not found & {*LATER, "numba", "numpy", "robots", "baselines"}


def test_the_help_of_a_stage_is_read_from_disk_the_second_time() -> None:
    code = "from pipeline.__main__ import main; main(['dataset', '--help'])"
    imported(code)
    assert not imported(code) & {*LATER, "numba", "numpy", "robots", "baselines"}


def test_help_is_kept_until_a_source_changes(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(kept_help, "FOLDER", tmp_path)
    made = []
    monkeypatch.setattr(stage_help, "stage_help", lambda *call: made.append(call) or "the text")
    source = tmp_path / "conf" / "train" / "a.yaml"
    source.parent.mkdir(parents=True)
    source.write_text("a: 1\n")
    monkeypatch.setattr(kept_help, "PACKAGES", tmp_path)
    for _ in range(2):
        assert kept_help.kept_help("train", ["robot=nico"]) == "the text"
    assert made == [("train", ["robot=nico"])]
    kept_help.kept_help("train")
    kept_help.kept_help("dataset")
    assert len(made) == 3
    source.write_text("a: 1  # explained\n")
    kept_help.kept_help("train", ["robot=nico"])
    assert len(made) == 4


def test_a_help_that_cannot_be_made_is_not_kept(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(kept_help, "FOLDER", tmp_path)
    for _ in range(2):
        with pytest.raises(ConfigError, match="did you mean 'nico'"):
            kept_help.kept_help("train", ["robot=nicoo"])
    assert not list(tmp_path.iterdir())
