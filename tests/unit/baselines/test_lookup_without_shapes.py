"""A robot whose collision meshes are missing has a lookup as any other."""

from __future__ import annotations

import re
from pathlib import Path

from pipeline import load_solver
from robots import load_robot

MIXED = Path(__file__).parents[2] / "fixtures" / "mixed.urdf"
MISSING = '<collision><geometry><mesh filename="gone.stl"/></geometry></collision>'


def test_what_is_remembered_needs_no_shapes(tmp_path: Path) -> None:
    text = MIXED.read_text(encoding="utf-8")
    broken, count = re.subn(r'<link name="tool"\s*/>', f'<link name="tool">{MISSING}</link>', text)
    if count == 0:
        broken, count = re.subn(r'(<link name="tool">)', rf"\1{MISSING}", text)
    assert count == 1
    (tmp_path / "robot.urdf").write_text(broken, encoding="utf-8")
    robot = load_robot(urdf=tmp_path / "robot.urdf", base="bench", tip="tool")
    assert robot.urdf.broken_collisions
    poses = robot.forward_kinematics(robot.sample(20, seed=1, collision_free=False))
    assert load_solver("lookup", robot, remembered=500).solve(poses).found.mean() > 0.9
