"""`export`: a file that answers, and bad input as one sentence with status 2."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pipeline.__main__ import main
from pipeline.exporting.c_compiler import CompiledHeader, find_compiler
from pipeline.exporting.targets import TARGETS
from robots import load_robot
from tests.exporting import make_weights


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_files_are_written_where_the_user_stands_and_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    weights = make_weights(load_robot("nico"), "experts", tmp_path / "weights")
    given = ["robot=nico", f"weights={weights}", "export.poses=50"]
    assert main(["export", *given, "to=torchscript"]) == 0
    assert "largest difference over 50 poses" in capsys.readouterr().out
    assert main(["export", *given, "to=c", "out=deep/er/arm.h"]) == 0
    said = capsys.readouterr().out
    assert ("50 of 50 poses found" in said) == (find_compiler() is not None)
    left = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*") if path.is_file()}
    assert left >= {"nico_ik.pt", "deep/er/arm.h", "deep/er/arm_example.c"}
    assert not [name for name in left if "partial" in name]
    header = (tmp_path / "deep/er/arm.h").read_text(encoding="utf-8")
    assert "export robot=nico" in header
    assert "that of whoever trained them" in header


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("robot=nico", "to=... is missing; expected to=onnx or to=torchscript or to=c"),
        ("robot=nico to", "to has no value; expected to=..."),
        ("robot=nico to=onxx", "there is no target 'onxx'; did you mean 'onnx'?"),
        ("robot=nicoo to=c", "nicoo"),
        ("robot=nico to=c model=paper results_dir=none", "train robot=nico model=paper"),
        ("robot=nico to=c weights=nowhere", "no trained weights in nowhere"),
        ("robot=nico to=onnx model=none", "model=none has none: take to=c"),
        ("robot=nico to=c model=none out=.", "out=. names no file"),
        ("robot=nico to=c model=none out=a'b.h", "names no file"),
        ("robot=nico to=c model=none export.poses=-1", "export.poses must be at least 0"),
        ("robot=nico to=c model=none export.opset=3", "export.opset must lie between"),
        (
            "robot=nico to=c model=none solver.lm.max_jump=0.1",
            "knows no solver.lm.max_jump; it has",
        ),
        ("robot=nico to=c model=none solver.lm.iterations=null", "solver.lm.iterations must be a"),
        ("robot=nico to=c model=none weights=file", "model=none takes no network: leave it or"),
        ("robot=nico to=c model=none out=file/a.h export.poses=0", "file"),
    ],
)
def test_bad_input_is_one_sentence(
    arguments: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    assert main(["export", *arguments.split()]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert said.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("off", ["2.0e-06", "nan"])
@pytest.mark.parametrize("arguments", ["to=torchscript", "to=c export.precision=float32"])
def test_a_file_that_answers_otherwise_is_not_put_in_place(
    arguments: str,
    off: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    weights = make_weights(load_robot("nico"), "mlp", tmp_path / "weights")
    to = arguments.split()[0].removeprefix("to=")
    target = TARGETS[to]
    if target.unreadable():
        pytest.skip(target.unreadable())

    def shifted(*arguments: object) -> object:
        answer = target.read(*arguments)  # type: ignore[arg-type]
        return lambda poses: answer(poses) + float(off)

    wrong = type(target)(target.suffix, target.write, target.unreadable, shifted)  # type: ignore[arg-type]
    monkeypatch.setitem(TARGETS, to, wrong)
    assert main(["export", "robot=nico", f"weights={weights}", *arguments.split()]) == 2
    assert f"{off} from the network evaluated in float64" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["weights"]


def test_the_descent_is_that_of_the_run(tmp_path: Path) -> None:
    given = ["robot=nico", "to=c", "model=none", "export.poses=0"]
    keys = ["solver.lm.iterations=77", "solver.lm.position_tolerance_m=3.0e-5"]
    assert main(["export", *given, *keys]) == 0
    header = (tmp_path / "nico_ik.h").read_text(encoding="utf-8")
    assert "#define NICO_ITERATIONS 77" in header
    assert "<= 3e-05 &&" in header


@pytest.mark.skipif(find_compiler() is None, reason="there is no compiler of C")
@pytest.mark.parametrize("off", [1e-3, float("nan")])
def test_a_header_whose_answers_or_poses_are_wrong_is_not_put_in_place(
    off: float,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    solve, kinematics = CompiledHeader.solve, CompiledHeader.forward_kinematics

    def elsewhere(self: CompiledHeader, poses: Any) -> Any:
        answers, found = solve(self, poses)
        return answers + 1e-2, found

    if off > 0:
        monkeypatch.setattr(CompiledHeader, "solve", elsewhere)
    else:
        monkeypatch.setattr(
            CompiledHeader,
            "forward_kinematics",
            lambda self, joints: kinematics(self, joints) + off,
        )
    assert main(["export", "robot=nico", "to=c", "model=none", "export.poses=20"]) == 2
    said = "calls poses found that are" if off > 0 else "forward kinematics of the header are nan"
    assert said in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
