"""Idle joints made rigid: the robot that is simulated stands like the one that is described."""

import numpy as np
import pybullet
import pytest
from numpy.testing import assert_allclose

from pipeline.grasping.idle_joints import fix_idle_joints, hand_joints
from robots import load_robot


def link_frames(path, positions):
    """World frame of every link after the joints were put at positions."""
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
    infos = [
        pybullet.getJointInfo(body, index, client)
        for index in range(pybullet.getNumJoints(body, client))
    ]
    for index, info in enumerate(infos):
        if info[2] != pybullet.JOINT_FIXED:
            at = positions.get(info[1].decode(), 0.0)
            pybullet.resetJointState(body, index, at, physicsClientId=client)
    frames = {}
    for index, info in enumerate(infos):
        state = pybullet.getLinkState(body, index, 0, 1, physicsClientId=client)
        matrix = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
        frames[info[12].decode()] = np.column_stack([matrix, state[4]])
    movable = {info[1].decode() for info in infos if info[2] != pybullet.JOINT_FIXED}
    pybullet.disconnect(client)
    return frames, movable


@pytest.mark.parametrize("name", ["nico", "nicol", "panda"])
def test_every_link_stands_where_the_description_has_it(name):
    robot = load_robot(name)
    positions = dict(zip(robot.joint_names, robot.sample(1, seed=3)[0], strict=True))
    positions |= robot.description.posture
    wanted, _ = link_frames(robot.urdf_path, positions)
    with fix_idle_joints(robot) as path:
        frames, movable = link_frames(path, positions)
    assert movable == {*robot.joint_names, *hand_joints(robot)}
    assert set(frames) == set(wanted)
    for link, frame in wanted.items():
        assert_allclose(frames[link], frame, atol=1e-6, err_msg=link)


def test_a_robot_without_idle_joints_is_left_alone():
    robot = load_robot("panda")
    with fix_idle_joints(robot) as path:
        assert path == robot.urdf_path


def test_the_file_is_gone_afterwards():
    with fix_idle_joints(load_robot("nicol")) as path:
        assert path.exists()
    assert not path.exists()
