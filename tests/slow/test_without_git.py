"""The project from an archive, below a folder with blanks: DVC reruns what an edit makes stale."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
import yaml

from tests.unpacked import unpack

pytestmark = pytest.mark.slow
BIN = Path(sys.executable).parent
FEW = {"robots": "[panda]", "numerical": "[lm, trac_ik]"}
STEPS = ("evaluate_numerical@panda-lm", "evaluate_numerical@panda-trac_ik")


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An unpacked archive with little to do and an environment that is ready."""
    folder = unpack(tmp_path_factory.mktemp("a folder with blanks") / "cycleik bench")
    path = folder / "conf" / "bench.yaml"
    text = path.read_text(encoding="utf-8")
    for key, value in FEW.items():
        text = re.sub(rf"^({key}: *)\[[^\]]*\]", rf"\g<1>{value}", text, flags=re.MULTILINE)
    path.write_text(text, encoding="utf-8")
    (folder / ".venv").mkdir()
    (folder / ".venv" / "bin").symlink_to(BIN)
    shell(folder, "bash", "-c", "cat requirements.lock pyproject.toml | cksum > .venv/.ready")
    shell(folder, ".ci/environment")
    shell(folder, sys.executable, "-m", "pipeline", "dvc", "profile=smoke")
    return folder


def shell(folder: Path, *command: str) -> str:
    environment = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}", "DVC_NO_ANALYTICS": "1"}
    environment |= {"OMP_NUM_THREADS": "1", "GIT_CEILING_DIRECTORIES": str(folder.parent)}
    environment.pop("PYTHONPATH", None)
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def repro(folder: Path, steps: Sequence[str] = STEPS) -> set[str]:
    """Run steps through DVC; those that were not skipped."""
    return set(re.findall(r"Running stage '([^']+)'", shell(folder, "dvc", "repro", *steps)))


def test_an_edit_of_code_reruns_the_steps_that_run_it_and_a_comment_none(copy: Path) -> None:
    assert (copy / ".dvc" / "config.local").exists()
    assert repro(copy) == {"code", "dataset@panda", *STEPS}
    assert repro(copy) == {"code"}
    solver, kinematics = copy / "baselines" / "trac_ik.py", copy / "robots" / "pinocchio_model.py"
    text = solver.read_text(encoding="utf-8")
    solver.write_text(f"# A remark.\n{text}", encoding="utf-8")
    assert repro(copy) == {"code"}
    solver.write_text(f"{text}\nEDITED = 1\n", encoding="utf-8")
    assert repro(copy) == {"code", STEPS[1]}
    kinematics.write_text(f"{kinematics.read_text(encoding='utf-8')}\nEDITED = 1\n")
    assert {*STEPS} <= repro(copy)


def test_nothing_says_a_commit(copy: Path) -> None:
    program = "from pipeline import provenance; print(provenance.commit())"
    assert shell(copy, sys.executable, "-c", program).strip() == "no commit"


def test_the_scale_stands_in_the_lists(copy: Path) -> None:
    bench = yaml.safe_load((copy / "conf" / "bench.yaml").read_text(encoding="utf-8"))
    assert (bench["profile"], bench["model"]) == ("smoke", "tiny")
