"""A full disk, a read-only folder, SIGTERM: one sentence, status 2, and the next call goes on."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from safetensors import safe_open

from pipeline.__main__ import main
from pipeline.data.tables import read_table
from tests.disks import REFUSAL, full_disk

ARGUMENTS = [
    "robot=nico",
    "profile=smoke",
    "dataset.train=300",
    "dataset.validation=30",
    "dataset.test=40",
    "dataset.workers=1",
    "train.epochs=2",
    "evaluate.solvers=[pinocchio]",
    "evaluate.poses=0",
    "evaluate.time_s=null",
    "evaluate.iterations=60",
    "evaluate.chunk=10",
]
MADE = {
    "dataset": Path("dataset/nico"),
    "train": Path("train/nico/tiny"),
    "evaluate": Path("evaluate/nico/pinocchio.parquet"),
}
# Stage, room for each file, further overrides, and the file that does not fit.
FULL = [
    ("dataset", 20_000, [], "dataset/nico/train.parquet"),
    ("dataset", 10, [], "checkpoint/dataset-nico.json"),
    ("train", 10_000, [], "train/nico/tiny/other.safetensors"),
    ("train", 10_000, ["train.checkpoint_s=1e-6"], "checkpoint/nico-tiny.safetensors"),
    ("train", 350, [], "train/nico/tiny/metrics.json"),
    ("evaluate", 1_000, [], "checkpoint/evaluate-nico-pinocchio/batch1_00000000.parquet"),
]
DEADLINE_S = 120.0
LONG = 200_000  # more than is made before the signal comes


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Every stage of the tests, undisturbed."""
    folder = tmp_path_factory.mktemp("whole")
    for stage in ("train", "evaluate"):
        assert main([stage, *ARGUMENTS, f"results_dir={folder}"]) == 0
    return folder


@pytest.fixture
def folder(whole: Path, tmp_path: Path) -> Path:
    """A results folder that holds a dataset."""
    shutil.copytree(whole / MADE["dataset"], tmp_path / MADE["dataset"])
    return tmp_path


def files(folder: Path) -> dict[str, bytes]:
    found = (path for path in folder.rglob("*") if path.is_file() and path.suffix != ".lock")
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


def sentence(text: str) -> str:
    """What is said after the bars, which must be one line."""
    assert "Traceback" not in text
    said = [line for line in text.replace("\r", "\n").splitlines() if line.startswith("error: ")]
    assert len(said) == 1
    assert text.rstrip().endswith(said[0])
    return said[0]


@pytest.mark.parametrize(("stage", "room", "overrides", "refused"), FULL)
def test_a_full_disk_leaves_whole_files_and_the_next_call_goes_on(
    stage: str,
    room: int,
    overrides: list[str],
    refused: str,
    whole: Path,
    folder: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if stage == "dataset":
        shutil.rmtree(folder / MADE["dataset"])
    command = [stage, *ARGUMENTS, *overrides, f"results_dir={folder}"]
    with full_disk(room):
        assert main(command) == 2
    said = sentence(capsys.readouterr().err)
    assert said.startswith(f"error: {folder / refused}") and said.endswith(REFUSAL)
    left = files(folder)
    assert not [name for name in left if "partial" in name]
    assert refused not in left
    assert main(command) == 0
    if stage in ("dataset", "train"):
        exact = {n: c for n, c in files(whole / MADE[stage]).items() if not n.endswith(".json")}
        again = files(folder / MADE[stage])
        assert exact and all(again[name] == content for name, content in exact.items())
    if stage == "evaluate":
        assert read_table(folder / MADE[stage]).pose.tolist() == list(range(40))
    assert files(folder / MADE[stage].parent).keys() == files(whole / MADE[stage].parent).keys()


@pytest.mark.parametrize("stage", MADE)
def test_a_read_only_folder_is_named(
    stage: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if stage == "dataset":
        shutil.rmtree(folder / "dataset")
    place = folder / MADE[stage].parts[0]
    if os.geteuid() == 0:  # whom modes do not stop, but a file system of the kernel does
        place.symlink_to("/sys/kernel")
    else:
        place.mkdir(mode=0o555)
    before = files(folder)
    assert main([stage, *ARGUMENTS, f"results_dir={folder}"]) == 2
    said = sentence(capsys.readouterr().err)
    assert str(place) in said or str(place.resolve()) in said  # the lock follows links
    assert {name: content for name, content in files(folder).items() if name in before} == before
    if place.is_symlink():
        place.unlink()
    else:
        place.rmdir()
    assert main([stage, *ARGUMENTS, f"results_dir={folder}"]) == 0


def terminated(command: list[str], begun: Callable[[], bool]) -> str:
    """Send SIGTERM once ``begun`` says so, and return what the command said."""
    command = [sys.executable, "-m", "pipeline", *command]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL) as child:
        deadline = time.monotonic() + DEADLINE_S
        while not begun():
            assert child.poll() is None, "the stage ended before the signal"
            assert time.monotonic() < deadline, "the stage makes no progress"
            time.sleep(0.005)
        child.send_signal(signal.SIGTERM)
        _, said = child.communicate(timeout=DEADLINE_S)
    assert child.returncode == 2
    text = said.decode()
    assert "Traceback" not in text
    assert text.endswith("\nterminated; the same command goes on from here\n")
    return text


def test_a_terminated_training_keeps_its_checkpoint(
    folder: Path,
) -> None:
    long = [*ARGUMENTS, "train.epochs=4000", "train.checkpoint_s=0.02", f"results_dir={folder}"]
    path = folder / "checkpoint" / "nico-tiny.safetensors"
    terminated(["train", *long], path.exists)
    assert not (folder / MADE["train"]).exists()
    with safe_open(path, framework="pt") as stream:
        assert stream.metadata()["digest"]
    before = path.read_bytes()
    again = terminated(["train", *long], lambda: path.exists() and path.read_bytes() != before)
    assert "going on from step" in again


@pytest.mark.parametrize("workers", [1, 2])
def test_a_terminated_dataset_is_made_by_the_next_call(
    workers: int, whole: Path, tmp_path: Path
) -> None:
    command = ["dataset", *ARGUMENTS, f"dataset.workers={workers}", f"results_dir={tmp_path}"]
    begun = (tmp_path / "checkpoint" / "dataset-nico.json").exists
    terminated([*command, f"dataset.train={10 * LONG}"], begun)
    assert not [name for name in files(tmp_path) if "parquet" in name]
    assert main(command) == 0
    made, exact = (files(root / MADE["dataset"]) for root in (tmp_path, whole))
    assert made["train.parquet"] == exact["train.parquet"]


def test_a_terminated_evaluation_goes_on_from_its_chunks(folder: Path) -> None:
    shutil.rmtree(folder / "dataset")
    many = ["dataset.test=400", "evaluate.chunk=20"]
    command = ["evaluate", *ARGUMENTS, *many, f"results_dir={folder}"]
    assert main(["dataset", *ARGUMENTS, *many, f"results_dir={folder}"]) == 0
    parts = folder / "checkpoint" / "evaluate-nico-pinocchio"
    terminated(command, lambda: len(list(parts.glob("batch*.parquet"))) > 2)
    kept = files(parts)
    assert not (folder / MADE["evaluate"]).exists()
    assert len([name for name in kept if name.startswith("batch")]) > 2
    assert not [name for name in kept if "partial" in name]
    assert main(command) == 0
    assert read_table(folder / MADE["evaluate"]).pose.tolist() == list(range(400))


class Finalised:
    def __init__(self, act: Callable[[], object]) -> None:
        self.act = act

    def __del__(self) -> None:
        self.act()


def kill_myself() -> None:
    os.kill(os.getpid(), signal.SIGTERM)
    for _ in range(10):  # the handler runs between two steps of the interpreter
        pass


def masked() -> None:
    """A library that answers an interruption with an error of its own."""
    try:
        kill_myself()
    finally:
        raise AttributeError("'NoneType' object has no attribute 'x'")


def in_a_finaliser() -> None:
    Finalised(kill_myself)
    time.sleep(5.0)


@pytest.mark.parametrize("act", [kill_myself, masked, in_a_finaliser])
def test_a_signal_ends_a_command_whatever_code_it_meets(
    act: Callable[[], None], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    handlers = [signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGALRM)]
    hook = sys.unraisablehook
    monkeypatch.setattr("pipeline.__main__._run", lambda argv: act())
    assert main([]) == 2
    assert capsys.readouterr().err == "\nterminated; the same command goes on from here\n"
    assert [signal.getsignal(n) for n in (signal.SIGTERM, signal.SIGALRM)] == handlers
    assert sys.unraisablehook is hook
