"""Searches with several workers on one journal, some of them killed: the total is exact."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from tests.toy import TOY
from tests.tune_runs import check_total, ended, in_journal, kill_a_worker, start

KEPT = {"trials.csv", "best.yaml", "metrics.json", "journal.log"}


@pytest.fixture(scope="module")
def poses(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A results folder with the pose sets, which every search here reads."""
    from pipeline.config import compose
    from pipeline.stages.running import run_stage

    folder = tmp_path_factory.mktemp("results")
    run_stage("dataset", compose([*TOY, f"results_dir={folder}"]))
    return folder


def own_folder(poses: Path, folder: Path) -> str:
    folder.mkdir(exist_ok=True)
    (folder / "dataset").symlink_to(poses / "dataset")
    return f"results_dir={folder}"


def test_three_workers_two_of_them_killed_end_with_the_asked_total(
    poses: Path, tmp_path: Path
) -> None:
    total, generator = 7, random.Random()
    search = start(own_folder(poses, tmp_path), "tune.workers=3", f"tune.trials={total}")
    look = in_journal(tmp_path)
    dead: list[int] = []
    for done in (1, 3):
        dead.append(kill_a_worker(look, generator, done, spared=search.pid, dead=dead))
    log = ended(search)
    assert log.count("worker process died") == 2, log
    check_total(tmp_path, total, cut_off=2)
    left = {path.name for path in (tmp_path / "tune" / "nico").iterdir()}
    assert left >= KEPT
    assert not list((tmp_path / "checkpoint").iterdir())


def test_a_search_killed_in_the_middle_goes_on_in_two_terminals_at_once(
    poses: Path, tmp_path: Path
) -> None:
    folder, trials = own_folder(poses, tmp_path), "tune.trials=4"
    killed = start(folder, trials)
    number = kill_a_worker(in_journal(tmp_path), random.Random(), 2)
    killed.communicate()
    assert number == 2
    for search in [start(folder, trials) for _ in range(2)]:
        assert "watch the study with: optuna-dashboard '" in ended(search)
    after = check_total(tmp_path, 4, cut_off=1)
    assert after.state[number] == "FAIL"
    assert not list((tmp_path / "checkpoint").iterdir())


def test_an_unreachable_database_is_one_sentence(poses: Path, tmp_path: Path) -> None:
    pytest.importorskip("psycopg", reason="the extra cluster is not installed")
    url = "postgresql://nobody:secret@127.0.0.1:9/studies"
    search = start(own_folder(poses, tmp_path), f"tune.storage={url}")
    log = search.communicate()[1].decode()
    assert search.returncode == 2
    assert "error: tune.storage: cannot open postgresql://nobody:***@127.0.0.1:9/studies" in log
    assert "secret" not in log
    assert "Traceback" not in log
