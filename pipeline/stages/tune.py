"""Stage tune: a hyperparameter search that goes on where it stopped, with any number of workers."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.closure import source_tree
from pipeline.data.dataset import CARD
from pipeline.data.files import read_json
from pipeline.errors import PipelineError
from pipeline.learning.registry import declared_modules
from pipeline.progress import LOGGER
from pipeline.stages.inputs import artifacts, dataset_of, robot_of
from pipeline.tuning.journal import fetch_journal, keep_journal
from pipeline.tuning.objective import TrialObjective, check_search
from pipeline.tuning.outputs import write_outputs, write_trials
from pipeline.tuning.storage import STORAGE_ERRORS, storage_errors_named
from pipeline.tuning.study import open_study, study_name
from pipeline.tuning.worker import SearchJob, search

if TYPE_CHECKING:
    from pipeline.settings import Config


def check(config: Config) -> None:
    """Refuse a search that cannot be, before anything is made."""
    check_search(config)


def run(config: Config) -> list[Path]:
    """Write trials.csv, best.yaml, metrics.json, figures, a table, and the journal of the study.

    The journal grows outside the artifact, where a rerun does not delete it, and moves in when
    the last worker is done. The same command in another terminal joins the study.
    """
    robot = robot_of(config)
    data = dataset_of(config)
    folders = artifacts(config)
    folder = folders.tune(robot.name)
    networks = declared_modules(config.model.kind)
    code = source_tree().digest(TrialObjective.__module__, *networks)
    digest = provenance.digest([read_json(data / CARD)["files"], code])
    name = study_name(config, digest)
    growing = folders.root / "checkpoint" / f"tune-{name}.log"
    kept = folder / "journal.log"
    job = SearchJob(config, data, digest, growing)
    with exclusive(folder):
        fetch_journal(kept, growing, name)
        store = job.store()
    try:
        with storage_errors_named(store):
            study = open_study(store, config, digest)
            LOGGER.info("watch the study with: optuna-dashboard '%s'", store.address)
            try:
                search(job, study)
            except PipelineError:
                with exclusive(folder), suppress(*STORAGE_ERRORS):
                    write_trials(study, folder)
                raise
            with exclusive(folder):
                write_outputs(study, folder, config)
                keep_journal(store, kept)
    finally:
        store.close()
    return [folder]
