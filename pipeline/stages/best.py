"""Training as a run will do it: by its own values, or by what a search found."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.stages.inputs import artifacts
from pipeline.tuning.best import read_best

if TYPE_CHECKING:
    from pipeline.settings import Config


def trained_config(config: Config) -> Config:
    """Return the run's configuration with training and architecture as they will be used.

    That is the run's own, or with `train.from=best` what the search found.

    Raises:
        MissingArtifactError: `train.from=best` before there was a search.
    """
    if config.train.source != "best":
        return config
    folders = artifacts(config)
    path = folders.need(
        folders.tune(config.robot.name) / "best.yaml",
        f"python -m pipeline tune robot={config.robot.name} profile={config.profile}",
    )
    train, model = read_best(path, config)
    return replace(
        config, train=replace(config.train, **train), model=replace(config.model, **model)
    )
