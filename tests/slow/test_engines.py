"""Pose sets, studies, evaluations and grasps on every engine: the rows of one process, but times.

    pytest -m slow tests/slow/test_engines.py

SLURM is submitit's local mode, and Ray a runtime on this machine; each is left out where its
package is not installed.
"""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pipeline.config import compose
from pipeline.data.tables import read_table
from pipeline.engine.running import run_tasks
from pipeline.errors import EngineError
from pipeline.stages.running import run_stage
from robots import sampling
from tests import engine_tasks

pytestmark = pytest.mark.slow
TOY = [
    "robot=panda",
    "profile=smoke",
    "dataset.train=9000",
    "dataset.validation=60",
    "dataset.test=120",
    "dataset.workers=1",
]
STUDY = [
    "tune.trials=4",
    "tune.poses=300",
    "tune.startup=10",  # drawn at random: a draw of TPE hangs on what was finished before it
    "tune.space.hidden={kind: layers, low: 1, high: 2, neurons: {low: 8, high: 16, step: 8}}",
]
EVALUATION = [
    "model=compact",  # weights that come with the project
    "evaluate.solvers=[cycleik,pinocchio,lm]",
    "evaluate.poses=60",
    "evaluate.iterations=60",
    "evaluate.batch_sizes=[1,20]",
    "evaluate.latency_poses=20",
    "evaluate.warm_up=2",
]
GRASPS = ["robot=nico", "grasp.trials=2", "grasp.video=none"]
TIMES = ["time_per_pose_us", "solver_time_us", "seed_time_us"]
HERE = ("engine=local", "engine.cpus=1")


def engine(*arguments: str, package: str = "") -> object:
    missing = bool(package) and importlib.util.find_spec(package) is None
    reason = f"{package} is not installed"
    return pytest.param(
        (*arguments, "engine.workers=2", "engine.cpus=1", "engine.start_up_s=0"),
        id=arguments[0].removeprefix("engine="),
        marks=pytest.mark.skipif(missing, reason=reason),
    )


ENGINES = [
    engine("engine=local"),
    engine("engine=slurm", "engine.cluster=local", package="submitit"),
    engine("engine=ray", package="ray"),
]
every_engine = pytest.mark.parametrize("arguments", ENGINES)


@pytest.fixture(autouse=True)
def shards_of_a_small_set(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sampling, "TRIAL", 2)  # chunks drawn here before any are handed out


@pytest.fixture(scope="module")
def local(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What engine=local leaves, one task after another in this process."""
    return tmp_path_factory.mktemp("local")


@cache
def dataset(root: Path, *where: str) -> bytes:
    (folder,) = run_stage("dataset", compose([*TOY, *where, f"results_dir={root}"]))
    return (folder / "train.parquet").read_bytes()


@cache
def study(root: Path, *where: str) -> pd.DataFrame:
    (folder,) = run_stage("tune", compose([*TOY, *STUDY, *where, f"results_dir={root}"]))
    return pd.read_csv(folder / "trials.csv").sort_values("number", ignore_index=True)


@cache
def evaluation(root: Path, *where: str) -> pd.DataFrame:
    paths = run_stage("evaluate", compose([*TOY, *EVALUATION, *where, f"results_dir={root}"]))
    return pd.concat([read_table(path) for path in paths]).drop(columns=TIMES)


@cache
def grasps(root: Path, *where: str) -> pd.DataFrame:
    (folder,) = run_stage("grasp", compose([*TOY, *GRASPS, *where, f"results_dir={root}"]))
    rows = read_table(folder / "trials.parquet")
    return rows.drop(columns=[name for name in rows if name.endswith(("plan_ms", "wall_s"))])


def shared(local: Path, folder: Path) -> Path:
    """A folder of its own with the pose sets of the first one."""
    dataset(local, *HERE)
    (folder / "dataset").symlink_to(local / "dataset")
    return folder


@every_engine
def test_a_pose_set_has_the_same_bytes(
    arguments: tuple[str, ...], local: Path, tmp_path: Path
) -> None:
    assert dataset(tmp_path, *arguments, "dataset.workers=2") == dataset(local, *HERE)


@every_engine
def test_a_study_has_the_same_trials(
    arguments: tuple[str, ...], local: Path, tmp_path: Path
) -> None:
    here, there = (
        study(local, *HERE, "tune.workers=1"),
        study(shared(local, tmp_path), *arguments, "tune.workers=2"),
    )
    assert len(here) == 4
    pd.testing.assert_frame_equal(there, here, check_exact=True)


@every_engine
def test_an_evaluation_has_the_same_rows(
    arguments: tuple[str, ...], local: Path, tmp_path: Path
) -> None:
    here, there = evaluation(local, *HERE), evaluation(shared(local, tmp_path), *arguments)
    assert np.isfinite(here["position_error_mm"]).all()
    pd.testing.assert_frame_equal(there, here, check_exact=True)
    assert not list((tmp_path / "checkpoint").rglob("*.pkl"))


@every_engine
def test_grasps_are_the_same(arguments: tuple[str, ...], local: Path, tmp_path: Path) -> None:
    here, there = grasps(local, *HERE), grasps(tmp_path, *arguments)
    pd.testing.assert_frame_equal(there, here, check_exact=True)
    assert not list((tmp_path / "checkpoint").rglob("*.*"))


@every_engine
def test_a_worker_that_dies_is_reported_and_what_ended_is_kept(
    arguments: tuple[str, ...], tmp_path: Path
) -> None:
    kept: dict[int, int] = {}
    where = compose([*TOY, *arguments, f"results_dir={tmp_path}"]).engine
    with pytest.raises(EngineError, match=r"of 4 tasks were lost .* is kept"):
        run_tasks(where, engine_tasks.die_at_one, range(4), kept.__setitem__)
    assert sorted(kept) == [0, 2, 3]
