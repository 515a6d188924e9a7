"""Standard output of a process carries its results alone."""

from __future__ import annotations

import subprocess
import sys

import pytest

CHATTER = """
import ctypes
from robots.native_output import stdout_elsewhere
print("before")
with stdout_elsewhere(shown={shown}):
    ctypes.CDLL(None).printf(b"chatter\\n")
print("after")
"""


@pytest.mark.parametrize(("shown", "error"), [(True, "chatter\n"), (False, "")])
def test_what_c_prints_stays_away_from_the_results(shown: bool, error: str) -> None:
    code = CHATTER.format(shown=shown)
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert (done.stdout, done.stderr) == ("before\nafter\n", error)


def test_the_physics_engine_starts_in_silence() -> None:
    code = "from pipeline.grasping.scene import _connect; _connect(gui=False); print('done')"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    assert done.stdout == "done\n"
    assert "argv" not in done.stderr
