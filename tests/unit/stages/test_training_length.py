"""How many poses a training of some minutes sees, by the committed rates."""

from __future__ import annotations

import pandas as pd
import pytest

from pipeline.config import compose
from pipeline.errors import PipelineError
from pipeline.settings import Config
from pipeline.stages import forecast


@pytest.fixture
def config(monkeypatch: pytest.MonkeyPatch) -> Config:
    row = {"stage": "train", "what": "flow", "robot": "", "core_seconds": 2e-5}
    monkeypatch.setattr(forecast, "rates", lambda: pd.DataFrame([row]))
    return compose(["model=flow", "dataset.train=1000000"])


@pytest.mark.parametrize(
    ("minutes", "poses", "epochs"),
    [(0.1, 300_000, 1), (1.0, 1_000_000, 3), (1.5, 900_000, 5), (1e-6, 256, 1)],
)
def test_minutes_are_spent_on_as_many_poses_as_there_are(
    config: Config, minutes: float, poses: int, epochs: int
) -> None:
    train = forecast.with_minutes(minutes, config).train
    assert train.epochs == epochs
    assert abs(train.poses - poses) <= 1  # rounded down
    assert train.batch_size == config.train.batch_size


def test_a_model_that_nobody_timed_is_named(config: Config) -> None:
    with pytest.raises(PipelineError, match=r"rates\.csv has no rate of training for gan"):
        forecast.with_minutes(1.0, compose(["model=gan"]))
