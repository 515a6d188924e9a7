"""Where files are found and left: a checkout, an unpacked archive, an installed package."""

from __future__ import annotations

import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

import robots.locations
from pipeline import locations, provenance
from pipeline.__main__ import main
from pipeline.config import compose
from pipeline.errors import PipelineError
from robots.locations import FOLDER

PACKAGED = ("pipeline.conf", "pipeline.published")  # data of a checkout that a wheel has inside


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder where the user stands."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def fresh_commit() -> Iterator[None]:
    provenance.commit.cache_clear()
    yield
    provenance.commit.cache_clear()


def test_a_folder_that_is_typed_starts_where_the_user_stands(elsewhere: Path) -> None:
    assert compose(["results_dir=out"]).results_dir == str(elsewhere / "out")
    assert compose([f"results_dir={elsewhere}/a"]).results_dir == f"{elsewhere}/a"


def test_the_folder_of_the_configuration_starts_at_the_checkout(elsewhere: Path) -> None:
    assert compose(["profile=smoke"]).results_dir == str(FOLDER / "results" / "smoke")
    jobs = compose(["engine=slurm"]).engine.folder
    assert jobs == str(FOLDER / "results" / "quick" / "checkpoint" / "jobs")


def test_a_stage_writes_where_the_user_stands(elsewhere: Path) -> None:
    few = [f"dataset.{split}=20" for split in ("train", "validation", "test")]
    assert main(["dataset", "robot=panda", "results_dir=out", *few]) == 0
    assert (elsewhere / "out" / "dataset" / "panda" / "card.json").exists()


def test_an_installed_package_has_its_configuration_inside(
    elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(robots.locations, "FOLDER", elsewhere / "site-packages")
    assert robots.locations.checkout() is None
    assert robots.locations.conf_dir() == elsewhere / "site-packages" / "pipeline" / "conf"
    assert robots.locations.home() == elsewhere


def test_what_belongs_to_a_checkout_is_refused_elsewhere(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(locations, "checkout", lambda: None)
    with pytest.raises(PipelineError, match="installed package"):
        locations.need_checkout("dvc.yaml")
    assert main(["robot", "add", "my.urdf", "--base", "a", "--tip", "b"]) == 2
    assert "run the command in a checkout" in capsys.readouterr().err


@pytest.mark.usefixtures("fresh_commit")
def test_without_git_there_is_no_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "FOLDER", tmp_path)
    assert provenance.commit() == "no commit"


@pytest.mark.usefixtures("fresh_commit")
def test_the_commit_of_a_repository_around_this_one_is_not_ours(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    inner = tmp_path / "unpacked"
    inner.mkdir()
    (tmp_path / "file").write_text("")
    author = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    for command in (["init", "-q"], ["add", "file"], [*author, "commit", "-qm", "one"]):
        subprocess.run(["git", "-C", str(tmp_path), *command], check=True)
    monkeypatch.setattr(provenance, "FOLDER", inner)
    assert provenance.commit() == "no commit"
    provenance.commit.cache_clear()
    monkeypatch.setattr(provenance, "FOLDER", tmp_path)
    assert len(provenance.commit()) == 12


@pytest.mark.usefixtures("fresh_commit")
def test_changed_code_is_a_change_and_a_changed_result_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "results" / "studies").mkdir(parents=True)
    code, input_ = tmp_path / "code.py", tmp_path / "results" / "rates.csv"
    result = tmp_path / "results" / "studies" / "table.csv"
    for file in (code, input_, result):
        file.write_text("")
    author = ["-c", "user.name=a", "-c", "user.email=a@example.org"]
    for command in (["init", "-q"], ["add", "."], [*author, "commit", "-qm", "one"]):
        subprocess.run(["git", "-C", str(tmp_path), *command], check=True)
    monkeypatch.setattr(provenance, "FOLDER", tmp_path)
    result.write_text("1")
    assert not provenance.commit().endswith("+changes")
    provenance.commit.cache_clear()
    for file in (code, input_):
        file.write_text("1")
        provenance.commit.cache_clear()
        assert provenance.commit().endswith("+changes"), file
        file.write_text("")


def test_the_wheel_has_every_package() -> None:
    settings = tomllib.loads((FOLDER / "pyproject.toml").read_text(encoding="utf-8"))
    named = settings["tool"]["setuptools"]["packages"]
    folders = {
        path.parent.relative_to(FOLDER).as_posix().replace("/", ".")
        for top in ("robots", "baselines", "pipeline")
        for path in (FOLDER / top).rglob("__init__.py")
    }
    assert {*named} == {*folders, *PACKAGED}, "tool.setuptools.packages in pyproject.toml"
