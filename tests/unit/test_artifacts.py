"""Folders, locks and seeds that stages share."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from pipeline.artifacts import Artifacts, exclusive
from pipeline.errors import MissingArtifactError
from pipeline.progress import LOGGER
from pipeline.seeding import derive_seed


def test_inputs_come_from_the_run_first_and_then_from_its_profile(tmp_path: Path) -> None:
    folders = Artifacts(tmp_path / "run", base=tmp_path / "quick")
    wanted = folders.tune("nico") / "best.yaml"
    with pytest.raises(MissingArtifactError, match=r"best.yaml; make it with: make it so"):
        folders.need(wanted, "make it so")
    base = tmp_path / "quick" / "tune" / "nico" / "best.yaml"
    base.parent.mkdir(parents=True)
    base.write_text("")
    assert folders.need(wanted, "") == base
    wanted.parent.mkdir(parents=True)
    wanted.write_text("")
    assert folders.need(wanted, "") == wanted


def test_an_artifact_is_made_by_one_process_at_a_time_and_a_kill_frees_it(tmp_path: Path) -> None:
    artifact = tmp_path / "weights"
    code = (
        "import sys, time; from pathlib import Path; from pipeline.artifacts import exclusive\n"
        "with exclusive(Path(sys.argv[1])):\n    print('held', flush=True); time.sleep(60)"
    )
    command = [sys.executable, "-c", code, str(artifact)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        waiter = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        time.sleep(0.5)
        assert waiter.poll() is None
        holder.kill()
    assert waiter.stdout is not None
    assert waiter.stdout.readline() == "held\n"
    waiter.kill()
    waiter.communicate()
    with exclusive(artifact) as waited:
        assert not waited


def test_who_waits_for_an_artifact_says_so_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    artifact, held = tmp_path / "weights", threading.Event()
    said: list[str] = []
    monkeypatch.setattr(LOGGER, "info", lambda text, *values: said.append(text % values))

    def hold() -> None:
        with exclusive(artifact):
            held.set()
            time.sleep(0.3)

    holder = threading.Thread(target=hold)
    holder.start()
    held.wait()
    with exclusive(artifact) as waited:
        assert waited
    holder.join()
    assert said == [f"another process is making {artifact}: waiting for it"]


def test_seeds_follow_from_their_parts_alone() -> None:
    assert derive_seed(0, "dataset", "nico", "test") == derive_seed(0, "dataset", "nico", "test")
    seeds = {derive_seed(root, "a", part) for root in range(30) for part in range(30)}
    assert len(seeds) == 900
    assert all(0 <= seed < 2**32 for seed in seeds)
