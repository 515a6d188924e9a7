"""`.ci/environment` on machines that lack something; programs in its reach write down calls."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TOOLS = shlex.split("bash cat cp chmod cksum dirname env git grep head mkdir mktemp rm sed tail")
# A Python of some version: it makes environments, and pip in them succeeds unless it is refused.
PYTHON = """#!/usr/bin/env bash
echo "python $*" | head -n 1 >>CALLS
case "$*" in
*platform*) [ VERSION = 3.11 ] ;;
*version_info*) true ;;
--version) echo Python VERSION ;;
"-m venv "*) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" && cp UV "$3/bin/uv" ;;
*) [ ! -e REFUSED ] ;;
esac
"""
UV = """#!/usr/bin/env bash
echo "uv $*" >>CALLS
case "$*" in
"python install"*)
    [ -e OFFLINE ] && { echo "error: no such host" >&2; exit 1; }
    bin=$UV_PYTHON_INSTALL_DIR/cpython/bin
    mkdir -p "$bin" && cp FETCHED "$bin/python3.11" ;;
"python find"*) echo "$UV_PYTHON_INSTALL_DIR/cpython/bin/python3.11" ;;
esac
"""


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """A checkout, and a folder of programs that is all there is."""
    (tmp_path / "checkout" / ".dvc").mkdir(parents=True)
    (tmp_path / "checkout" / ".ci").mkdir()
    shutil.copy(ROOT / ".ci" / "environment", tmp_path / "checkout" / ".ci")
    for name in ("requirements.lock", "requirements.hashes", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path / "checkout")
    (tmp_path / "bin").mkdir()
    for tool in TOOLS:
        found = shutil.which(tool)
        assert found is not None
        (tmp_path / "bin" / tool).symlink_to(found)
    write(tmp_path, "uv", UV)
    write(tmp_path, "fetched", PYTHON.replace("VERSION", "3.11"))
    return tmp_path


def write(machine: Path, name: str, text: str) -> None:
    marks = {"CALLS": "calls", "UV": "uv", "FETCHED": "fetched"}
    marks |= {"OFFLINE": "offline", "REFUSED": "refused"}
    for mark, file in marks.items():
        text = re.sub(rf"\b{mark}\b", str(machine / file), text)
    (machine / name).write_text(text)
    (machine / name).chmod(0o755)


def python(machine: Path, name: str, version: str) -> None:
    write(machine, f"bin/{name}", PYTHON.replace("VERSION", version))


def run(machine: Path, **variables: str) -> tuple[int, str, str]:
    """Status, what is said, and what was called."""
    environment = {"PATH": str(machine / "bin"), "TMPDIR": str(machine), **variables}
    script = machine / "checkout" / ".ci" / "environment"
    done = subprocess.run([script], env=environment, capture_output=True, text=True)
    calls = machine / "calls"
    text = calls.read_text() if calls.exists() else ""
    calls.unlink(missing_ok=True)
    return done.returncode, done.stderr, text


def test_a_machine_with_another_python_gets_the_right_one_by_uv(machine: Path) -> None:
    python(machine, "python3", "3.13")
    status, said, calls = run(machine)
    assert status == 0, said
    assert "there is no CPython 3.11 here: getting one by uv into .python" in said
    assert "uv python install --no-bin 3.11" in calls
    assert "uv pip install --python .venv/bin/python --no-deps --require-hashes" in calls
    assert (machine / "checkout" / ".venv" / ".ready").exists()
    assert run(machine) == (0, "", "python -c \n"), "the second call finds all of it"
    (machine / "checkout" / ".venv" / ".ready").unlink()
    assert "getting one" not in run(machine)[1], "the Python is kept"
    assert not list(machine.glob("tmp.*")), "uv is gone"


def test_without_a_network_it_says_so_in_one_sentence(machine: Path) -> None:
    python(machine, "python3", "3.13")
    (machine / "offline").touch()
    status, said, _ = run(machine)
    assert status == 1
    assert [line for line in said.splitlines() if line.startswith("error: ")] == [
        "error: CPython 3.11 is needed (pybullet has wheels for no newer one), and uv could not "
        "download it: error: no such host. Install python3.11, or name it: "
        "make PYTHON=/path/to/python3.11"
    ]
    (machine / "refused").touch()
    status, said, _ = run(machine)
    assert status == 1
    assert "found: Python 3.13, and uv, which would get it, could not be installed" in said


def test_without_any_python_it_says_so(machine: Path) -> None:
    status, said, _ = run(machine)
    assert status == 1
    assert "no Python is here to get it with" in said


def test_a_python_that_is_named_must_be_the_right_one(machine: Path) -> None:
    python(machine, "python3.12", "3.12")
    status, said, calls = run(machine, PYTHON="python3.12")
    assert (status, said) == (1, "error: PYTHON=python3.12 is no CPython 3.11\n")
    assert "install" not in calls


@pytest.mark.parametrize(("torch", "index"), [("cpu", True), ("cuda", False)], ids=["cpu", "cuda"])
def test_one_variable_chooses_the_build_of_pytorch(machine: Path, torch: str, index: bool) -> None:
    python(machine, "python3.11", "3.11")
    status, said, calls = run(machine, TORCH=torch)
    assert status == 0, said
    assert ("--index-url" in calls) == index
    assert re.search(r"--no-deps.* torch==\d", calls)
    (machine / "checkout" / ".venv" / ".ready").unlink()
    status, said, _ = run(machine, TORCH="rocm")
    assert status == 1
    assert said.endswith("error: TORCH takes cpu or cuda, got rocm\n")


def test_pip_does_it_where_uv_cannot_be_had(machine: Path) -> None:
    python(machine, "python3.11", "3.11")
    write(machine, "uv", UV + "exit 1\n")
    status, said, calls = run(machine)
    assert status == 0, said
    assert (
        "-m pip --disable-pip-version-check install --prefer-binary --no-deps --require-hashes"
        in calls
    )


def test_the_checksums_are_those_of_the_lock() -> None:
    """`.ci/hashes` renews them; PyTorch has none, whose builds share a version."""
    locked = pinned(ROOT / "requirements.lock")
    hashed = pinned(ROOT / "requirements.hashes")
    assert [line.split()[0] for line in hashed] == [
        line for line in locked if not line.startswith("torch==")
    ]
    assert all(re.fullmatch(r"\S+==\S+ --hash=sha256:[0-9a-f]{64}", line) for line in hashed)


def pinned(path: Path) -> list[str]:
    lines = path.read_text(encoding="utf-8").splitlines()
    return [line for line in lines if not line.startswith("#")]
