"""Stage tune: a hyperparameter search that goes on where it stopped."""

from __future__ import annotations

from pathlib import Path

from omegaconf import OmegaConf

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.config import to_dict
from pipeline.data.dataset import CARD, read_split
from pipeline.data.files import read_json, write_json, write_text
from pipeline.errors import PipelineError
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts, dataset_of, robot_of
from pipeline.tuning.figures import write_figures
from pipeline.tuning.objective import Objective, draw
from pipeline.tuning.study import open_study, run_trials, study_name, trials_table


def run(config: Config) -> list[Path]:
    """Write trials.csv, best.yaml, metrics.json, figures, and the journal that Optuna reads.

    The journal grows outside the artifact, where a rerun does not delete it, and moves in when
    the study is complete.
    """
    robot = robot_of(config)
    data = dataset_of(config)
    folders = artifacts(config)
    folder = folders.tune(robot.name)
    digest = provenance.digest(read_json(data / CARD)["files"])
    growing = folders.root / "checkpoint" / f"tune-{study_name(config, digest)}.log"
    with exclusive(folder):
        kept = folder / "journal.log"
        if kept.exists() and not growing.exists():
            growing.parent.mkdir(parents=True, exist_ok=True)
            growing.write_bytes(kept.read_bytes())
        study = open_study(growing, config, digest)
        splits = [read_split(data, split, robot) for split in ("train", "validation")]
        run_trials(study, Objective(robot, config, *splits), config)
        if not any(trial.value is not None for trial in study.get_trials(deepcopy=False)):
            raise PipelineError(f"no trial of {study.study_name} ended well: look at tune.space")
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / "trials.csv", trials_table(study).to_csv(index=False))
        train, model = draw(study.best_trial, config)
        best = {"train": _searched(config, to_dict(train)), "model": _model(to_dict(model))}
        write_text(folder / "best.yaml", OmegaConf.to_yaml(OmegaConf.create(best)))
        write_json(folder / "metrics.json", {"objective": study.best_value})
        write_figures(study, folder, robot.name)
        growing.replace(kept)
    return [folder]


def _searched(config: Config, train: dict[str, object]) -> dict[str, object]:
    return {key: train[key] for key in config.tune.space if key in train}


def _model(model: dict[str, object]) -> dict[str, object]:
    return {key: model[key] for key in ("hidden", "tanh_layers")}
