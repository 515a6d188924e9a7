"""Joints that mimic others: they follow without a range of their own, or are said to stand."""

from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import Budget
from robots import Robot, UrdfError, load_robot
from tests.small_arms import LIMIT, arm, save

RANGES = {
    "a range": '<limit lower="-9" upper="9"/>',
    "effort only": '<limit effort="1" velocity="1"/>',
    "zero width": '<limit lower="0" upper="0"/>',
    "no limit": "",
}


def follower(
    limit: str = "", kind: str = "revolute", master: str = "j2", parent: str = "l3"
) -> str:
    return (
        f'<link name="m"/><joint name="mj" type="{kind}"><origin xyz="0 0 0.2"/>'
        f'<parent link="{parent}"/><child link="m"/><axis xyz="0 1 0"/>{limit}'
        f'<mimic joint="{master}" multiplier="-2" offset="0.3"/></joint></robot>'
    )


def load(folder: Path, coupled: str, tip: str = "m", base: str = "b") -> Robot:
    return load_robot(urdf=save(folder, arm(3).replace("</robot>", coupled)), base=base, tip=tip)


@pytest.mark.parametrize("limit", RANGES)
@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
def test_the_tip_follows(limit: str, kind: str, tmp_path: Path) -> None:
    robot = load(tmp_path, follower(RANGES[limit], kind))
    arm_only = load_robot(urdf=robot.urdf_path, base="b", tip="l3")
    joints = robot.sample(10)
    position = -2.0 * joints[:, 1] + 0.3
    for q, where, pose in zip(joints, position, robot.forward_kinematics(joints), strict=True):
        above = arm_only.link_poses(q)["l3"]
        move = np.eye(4)
        move[2, 3] = 0.2
        if kind == "prismatic":
            move[1, 3] = where
        else:
            move[:3, :3] = [
                [np.cos(where), 0, np.sin(where)],
                [0, 1, 0],
                [-np.sin(where), 0, np.cos(where)],
            ]
        assert np.abs((above @ move)[:3, 3] - pose[:3]).max() < 1e-13
        assert np.abs(robot.link_poses(q)["m"] - above @ move).max() < 1e-13
        assert robot.positions(q)["mj"] == pytest.approx(where)
    assert robot.urdf.notes == ()


def test_solvers_that_run_solve_and_the_others_say_why(tmp_path: Path) -> None:
    robot = load(tmp_path, follower())
    poses = robot.forward_kinematics(robot.sample(5))
    for name in baselines.names():
        if "weights" in baselines.registry.settings(name):
            continue
        reason = baselines.skip(name, robot)
        if reason is None:
            solver = baselines.load(name, robot)
            ample = Budget(time_s=0.3) if "time_s" in solver.budgets else None
            assert solver.solve(poses, budget=ample).found.all(), name
        else:
            assert "mimics" in reason or "not installed" in reason or "only" in reason, name
    assert baselines.skip("lm", robot) is None and baselines.skip("placo", robot) is not None


def test_a_coupling_beside_the_chain_is_nobodys_business(tmp_path: Path) -> None:
    robot = load(tmp_path, follower(parent="l2"), tip="l3")
    poses = robot.forward_kinematics(robot.sample(5))
    model, _ = robot.pinocchio()
    assert model.nq == robot.dof == 3
    for name in ("lm", "pinocchio", "placo", "pytorch_kinematics", "trac_ik"):
        if baselines.skip(name, robot) is None:
            assert baselines.load(name, robot).solve(poses).found.all(), name


def test_a_master_outside_the_chain_is_said_to_be_there(tmp_path: Path) -> None:
    robot = load(tmp_path, follower(), base="l2")
    assert robot.joint_names == ("j3",)
    assert robot.followers() == [
        "'mj' mimics 'j2', which the chain does not move: it stands still at 0.3"
    ]
    assert load(tmp_path, follower()).followers()[0].startswith("'mj' mimics 'j2': coupled")
    with pytest.raises(UrdfError, match="'mj' mimics 'j2', which is not between them"):
        load(tmp_path, follower(), base="l3")


def test_a_follower_of_a_follower_follows(tmp_path: Path) -> None:
    second = (
        f'<link name="n"/><joint name="nj" type="revolute"><parent link="m"/><child link="n"/>'
        f'<axis xyz="0 0 1"/>{LIMIT}<mimic joint="mj" multiplier="0.5"/></joint></robot>'
    )
    robot = load(tmp_path, follower().replace("</robot>", second), tip="n")
    positions = robot.positions([0.1, 0.2, 0.3])
    assert positions["mj"] == pytest.approx(-0.1) and positions["nj"] == pytest.approx(-0.05)


def test_a_coupling_that_leads_nowhere_is_an_error_in_the_chain_only(tmp_path: Path) -> None:
    robot = load(tmp_path, follower(master="gone", parent="l2"), tip="l3")
    assert robot.dof == 3 and robot.positions([0.1, 0.2, 0.3])["mj"] == 0.0
    assert robot.urdf.notes == (
        "joint 'mj' mimics 'gone', which is no joint of this file: it stands still",
    )
    with pytest.raises(UrdfError, match="mimics 'gone'"):
        load(tmp_path, follower(master="gone"))
