"""README's figure and table of error against time are those of the committed lines."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest
from PIL import Image

from pipeline.commands.overview import (
    digest_of,
    draw,
    in_words,
    lines_of,
    over_robots,
)
from pipeline.errors import MissingArtifactError

ROOT = Path(__file__).parents[3]
RENEW = "python -m pipeline readme --figure"
COLUMNS = ["robot", "solver", "position_mean_mm", "time_median_us", "good_poses", "poses"]
LINES = pd.DataFrame(
    [
        ["a", "lm", 1.0, 10.0, 9, 10],
        ["b", "lm", 4.0, 40.0, 10, 10],
        ["a", "placo", 100.0, 5.0, 0, 10],
        ["b", "placo", 100.0, 5.0, 5, 10],
        ["a", "optik", 1.0, 1.0, 10, 10],
    ],
    columns=COLUMNS,
)


def test_means_over_robots_by_hand() -> None:
    means = over_robots(LINES)
    assert [*means.index] == ["placo", "lm"], "the quickest first; optik lacks a robot"
    assert means.loc["lm"].to_list() == pytest.approx([2.0, 20.0, 0.95])
    assert in_words(LINES).splitlines()[-1] == "| LM, compiled | 95.0 % | 2.0 mm | 20 µs |"


def test_the_picture_carries_what_it_was_drawn_from(tmp_path: Path) -> None:
    draw(LINES, tmp_path / "figure.png")
    with Image.open(tmp_path / "figure.png") as picture:
        assert picture.info["Source"] == digest_of(LINES)
        assert picture.width > 1000


def test_readme_shows_the_committed_lines() -> None:
    lines = lines_of(ROOT / "results")
    assert in_words(lines) in (ROOT / "README.md").read_text(encoding="utf-8"), RENEW
    with Image.open(ROOT / "results" / "readme" / "error_time.png") as picture:
        assert picture.info["Source"] == digest_of(lines), RENEW


def test_without_lines_there_is_no_figure(tmp_path: Path) -> None:
    with pytest.raises(MissingArtifactError, match="has no lines of uniform"):
        lines_of(tmp_path)


def test_readme_is_a_screen_and_a_half_and_its_pictures_are_small() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 95
    for picture in (ROOT / "results" / "readme").iterdir():
        assert f"results/readme/{picture.name}" in text
        assert picture.stat().st_size < 2_000_000
