"""`demo` ends with a film and a page."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.commands import run_command

pytestmark = pytest.mark.slow


def test_a_film_and_a_page_are_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command("demo", [f"results_dir={tmp_path}", "open=false"]) == 0
    *films, page = (Path(line) for line in capsys.readouterr().out.splitlines())
    assert [film.suffix for film in films] == [".mp4"]
    assert all(path.stat().st_size > 10_000 for path in (*films, page))
    rows = {path.stem for path in (tmp_path / "evaluate" / "nicol").glob("*.parquet")}
    assert {"cycleik", "cycleik_refined", "lm"} <= rows
