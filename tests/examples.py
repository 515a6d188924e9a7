"""The scripts of examples/, run as a reader would, but in this process and in a given folder."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
SLOW = ("06", "07", "09", "10")  # they train, make pose sets or simulate


def scripts() -> list[Path]:
    """All examples in order."""
    return sorted(EXAMPLES.glob("*.py"))


def run(
    number: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, folder: Path
) -> str:
    """Run the example of a number in a folder and return what it printed."""
    (path,) = EXAMPLES.glob(f"{number}_*.py")
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", [str(path)])
    monkeypatch.setattr(sys, "stdin", sys.stdin)  # an example may put another one in its place
    runpy.run_path(str(path), run_name="__main__")
    return capsys.readouterr().out


@pytest.fixture
def output(
    request: pytest.FixtureRequest,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> str:
    """What the example of the parameter's number prints in an empty folder."""
    return run(request.param, capsys, monkeypatch, tmp_path)
