"""A command that is refused: one sentence, status 2, and nothing written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from pipeline.__main__ import main


def assert_refused(
    arguments: Sequence[str], words: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Run a command with results in a folder that there is not, and expect words of its refusal."""
    assert main([*arguments, "profile=smoke", f"results_dir={folder / 'out'}"]) == 2
    err = capsys.readouterr().err
    assert words in err
    assert err.count("\n") == 1
    assert not (folder / "out").exists()
