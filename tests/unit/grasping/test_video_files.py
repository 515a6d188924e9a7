"""Films on a disk that is full or in a folder that takes nothing: named, and nothing is left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.grasping.config import VideoConfig
from pipeline.grasping.video import Recorder
from tests.disks import full_disk

CONFIG = VideoConfig(width=64, height=48, rate=12.0, closeup=0, gif_width=64, gif_rate=6.0)


@pytest.fixture
def film() -> Recorder:
    recorder = Recorder(CONFIG)
    noise = np.random.default_rng(0)
    recorder.frames = [noise.integers(0, 255, (48, 64, 3), dtype=np.uint8) for _ in range(40)]
    return recorder


@pytest.mark.parametrize("room", [0, 100, 3_000, 20_000, 70_000])
def test_a_film_that_does_not_fit_is_named_and_not_left_half_written(
    film: Recorder, tmp_path: Path, room: int
) -> None:
    path = tmp_path / "trial_000.mp4"
    sizes = {each.name: each.stat().st_size for each in film.write(tmp_path / "whole" / path.name)}
    assert room < max(sizes.values())
    with full_disk(room), pytest.raises(OSError, match=r"\S") as caught:
        film.write(path)
    assert caught.value.filename in (str(path), str(path.with_suffix(".gif")))
    left = [each.name for each in tmp_path.iterdir() if each.name != "whole"]
    assert left == [name for name in left if (tmp_path / name).stat().st_size == sizes[name]]
    assert {each.name: each.stat().st_size for each in film.write(path)} == sizes
