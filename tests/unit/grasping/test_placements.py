"""Pinned initial states: what the generator gives, whole, and the same for every run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from numpy.testing import assert_allclose

from benchmarks.placements import generated
from pipeline.config import compose
from pipeline.data.files import sha256
from pipeline.embodiment.row import row_setup
from pipeline.errors import GraspError
from pipeline.grasping import placements
from pipeline.grasping.placements import CHECKSUMS, FOLDER, check_pinned, pinned
from pipeline.grasping.trial import trial_setup

DRAWN = compose(["profile=smoke"]).grasp
PINNED = compose(["profile=smoke", "grasp.placements=pinned"]).grasp


@pytest.mark.parametrize("robot", DRAWN.scenes)
def test_the_generator_still_gives_the_version_that_is_committed(robot: str) -> None:
    known = pd.read_csv(CHECKSUMS, index_col="robot")
    path = FOLDER / f"{robot}.csv"
    assert sha256(path) == known.sha256[robot]
    assert generated(DRAWN, robot) == path.read_text(encoding="utf-8"), (
        "a changed generator is a new version: python -m benchmarks.placements --write"
    )


def test_pinned_trials_and_rows_are_those_of_seed_0_whatever_the_seed() -> None:
    for number in (0, 17, 99):
        drawn, kept = trial_setup(DRAWN, "nico", number, 0), trial_setup(PINNED, "nico", number, 5)
        assert (kept.number, kept.row, kept.name) == (number, drawn.row, drawn.name)
        assert_allclose([*kept.place, kept.yaw], [*drawn.place, drawn.yaw], rtol=0, atol=6e-10)
    for number in (0, 33):  # of three objects; the last one goes beyond a hundred trials
        row = row_setup(PINNED, "nico", number, seed=5)
        assert [each.number for each in row] == [3 * number, 3 * number + 1, 3 * number + 2]
        for kept, drawn in zip(row, row_setup(DRAWN, "nico", number, 0), strict=True):
            assert kept.name == drawn.name
            assert_allclose([*kept.place, kept.yaw], [*drawn.place, drawn.yaw], rtol=0, atol=6e-10)


def test_an_injected_error_is_drawn_beside_pinned_places() -> None:
    config = replace(PINNED, position_error=0.03)
    first, other = (trial_setup(config, "nico", 7, seed) for seed in (0, 1))
    assert first.place == other.place
    assert tuple(first.error) != tuple(other.error)
    assert_allclose([first.error @ first.error, other.error @ other.error], 0.03**2)


def test_what_is_not_pinned_is_refused_in_a_sentence() -> None:
    with pytest.raises(GraspError, match=r"no placements are pinned for 'fetch'; there are nico,"):
        pinned("fetch", "single", 0)
    with pytest.raises(GraspError, match=r"100 placements are pinned for 'nico' \(single\).* 100:"):
        trial_setup(PINNED, "nico", 100, 0)
    with pytest.raises(GraspError, match=r"are of grapes, lemon_half, tomato, and the scene has"):
        check_pinned("nico", ["orange"], 1)
    with pytest.raises(GraspError, match=r"got grasp.trials=101: choose fewer"):
        check_pinned("nico", DRAWN.scenes["nico"].objects, 101)


def test_a_changed_file_is_not_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (FOLDER / "nico.csv").read_text(encoding="utf-8")
    (tmp_path / "nico.csv").write_text(text.replace("0.270000000", "0.280000000", 1))
    monkeypatch.setattr(placements, "FOLDER", tmp_path)
    placements._read.cache_clear()
    try:
        with pytest.raises(GraspError, match="is missing or was changed"):
            pinned("nico", "single", 0)
    finally:
        placements._read.cache_clear()
