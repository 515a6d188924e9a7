"""The map of an arm whose reach is known, orientations that are spread, and a killed run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import baselines
from pipeline.__main__ import main
from pipeline.data.files import read_json
from pipeline.data.tables import read_metadata, read_table
from pipeline.evaluation.cache import ChunkCache
from pipeline.reachability.config import ReachConfig
from pipeline.reachability.orientations import PSI, spread_orientations
from pipeline.reachability.voxels import grid, reach_map
from robots import Robot, load_robot
from robots.rotations import rotation_angle

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"
NOTHING_KEPT = ChunkCache(None, {})


def wanted(**changes: object) -> ReachConfig:
    values = {"solver": "lm", "spacing_m": 0.05, "orientations": 1, "freedom": "position"}
    return ReachConfig(**{**values, "iterations": 500, "chunk": 100, **changes})  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot(urdf=TWO_LINK)


@pytest.fixture(scope="module")
def rows(arm: Robot) -> pd.DataFrame:
    solver, places = baselines.load("lm", arm), grid(arm, wanted().spacing_m)
    return reach_map(arm, solver, places, wanted(), NOTHING_KEPT)


def test_two_links_reach_their_annulus_and_nothing_else(rows: pd.DataFrame) -> None:
    """From |0.4 + 0.3 exp(2.5 i)| = 0.240 to 0.7 m around the shoulder, at its height."""
    least = np.abs(0.4 + 0.3 * np.exp(2.5j))
    radius, angle = np.hypot(rows.x, rows.y), np.abs(np.arctan2(rows.y, rows.x))
    level = np.isclose(rows.z, 0.1)
    inside = level & (radius > least + 1e-3) & (radius < 0.7 - 1e-3) & (angle < 2.5)
    outside = ~level | (radius < least - 1e-3) | (radius > 0.7 + 1e-3)
    assert inside.sum() > 300
    assert (rows.share[inside] == 1.0).all()
    assert (rows["count"][outside] == 0).all()


def test_the_grid_lies_at_multiples_and_surrounds_the_reach(arm: Robot) -> None:
    places = grid(arm, 0.05)
    assert np.allclose(places / 0.05, np.round(places / 0.05), atol=1e-6)
    assert len(np.unique(places, axis=0)) == len(places)
    low, high = places.min(axis=0), places.max(axis=0)
    assert (low <= [-0.65, -0.7, 0.05]).all() and (high >= [0.7, 0.7, 0.15]).all()


def test_a_killed_run_goes_on_where_it_was(arm: Robot, rows: pd.DataFrame, tmp_path: Path) -> None:
    """What is kept is not asked again: a solver that fails would be noticed."""
    cache, solver = ChunkCache(tmp_path, {"map": 1}), baselines.load("lm", arm)
    calls: list[int] = []
    part, places = wanted(), grid(arm, wanted().spacing_m)

    def killed(count: int) -> None:
        calls.append(count)
        if len(calls) == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        reach_map(arm, solver, places, part, cache, killed)
    kept = len(list(tmp_path.glob("*.parquet")))
    assert kept == 3
    again = reach_map(arm, solver, places, part, cache)
    pd.testing.assert_frame_equal(again, rows)


def test_orientations_are_spread_better_than_random_ones() -> None:
    assert pytest.approx(PSI + 4.0) == PSI**4
    turns = spread_orientations(500)
    assert np.allclose(np.linalg.norm(turns, axis=1), 1.0)
    rng = np.random.default_rng(0)
    asked, others = rng.standard_normal((2, 500, 4))
    asked /= np.linalg.norm(asked, axis=1, keepdims=True)
    others /= np.linalg.norm(others, axis=1, keepdims=True)

    def farthest(points: np.ndarray) -> float:
        return float(rotation_angle(asked[:, None], points[None]).min(axis=1).max())

    assert farthest(turns) < 0.75 * farthest(others)


def test_the_command_writes_map_card_and_figure(tmp_path: Path) -> None:
    call = ["reach", "robot=nico", "profile=smoke", f"results_dir={tmp_path}"]
    assert main(call) == 0
    folder = tmp_path / "reach" / "nico"
    assert {path.name for path in folder.iterdir()} == {
        "map.parquet",
        "card.json",
        "map.png",
        "map.pdf",
    }
    rows = read_table(folder / "map.parquet")
    assert list(rows) == ["x", "y", "z", "share", "count"]
    assert (rows["count"] == 8 * rows.share).all() and rows["count"].max() >= 1
    card = read_json(folder / "card.json")
    assert card["reach"]["orientations"] == 8
    assert read_metadata(folder / "map.parquet")["solver_identity"] == card["solver_identity"]
    assert not (tmp_path / "checkpoint" / "reach-nico").exists()
    assert main([*call, "reach.solver=pinocchio", "reach.freedom=z"]) == 2
