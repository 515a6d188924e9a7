"""`robot add` on URDFs that cannot be used: one sentence, status 2, nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.__main__ import main
from robots.add import add_robot
from tests.broken_urdfs import BROKEN, LINKS, SHAPELESS, joint

ELBOW = f"<robot name='r'>{LINKS}{joint()}</robot>"
# What the file says (None: it is a folder), base, tip and a word that the sentence must say.
CASES: dict[str, tuple[str | None, str, str, str]] = {
    **{
        case: (BROKEN[case][0], "a", "b", BROKEN[case][1])
        for case in (
            "bad XML",
            "missing link",
            "loop",
            "two roots",
            "NaN limit",
            "lower above upper",
            "zero axis",
            "unknown joint type",
            "empty file",
        )
    },
    **{
        case: (f"<robot>{link}<link name='b'/>{joint()}</robot>", "a", "b", expected)
        for case, (link, expected) in SHAPELESS.items()
    },
    "tip not under base": (ELBOW, "b", "a", "not below the base 'b'"),
    "a directory": (None, "a", "b", "a folder"),
}


@pytest.mark.parametrize("case", CASES)
def test_robot_add_says_one_sentence_and_writes_nothing(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    text, base, tip, expected = CASES[case]
    path = tmp_path / "robot.urdf"
    if text is None:
        path.mkdir()
    else:
        path.write_text(text)
    # The command writes where the robots are; a fault here must not reach the checkout.
    monkeypatch.setattr(add_robot, "__defaults__", (None, tmp_path / "robots", tmp_path / "conf"))
    status = main(["robot", "add", str(path), "--base", base, "--tip", tip])
    out, err = capfd.readouterr()
    assert status == 2
    assert out == ""
    assert err.startswith("error: ") and expected in err
    assert err.count("\n") <= 2
    assert "Traceback" not in err
    assert list(tmp_path.rglob("*")) == [path]


def test_eighteen_kinds_of_fault_are_tried() -> None:
    assert len(CASES) == 18
