"""The descriptions of nicol, valkyrie and fetch: published numbers, consistency, simulation."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pinocchio
import pybullet
import pytest

from robots import Robot, load_robot
from tests.simulation import Simulation

NAMES = ("nicol", "valkyrie", "fetch")

# Joint configuration, then tip pose x y z qw qx qy qz: from Pinocchio on the URDFs the paper used.
REFERENCE = {
    "nicol": """
        1.9926735718801156 0.04418534438427857 -1.1136283994275742 -1.2851314498155146
        -0.7700997423825034 -0.34509567609904934 0.007144386978117256 0.08403342664920443
        0.06109023515602272 -0.979901037895288 1.4667855052892422
        0.8214171857534649 -0.2677623994410685 0.4621984526582744 -0.19987419732100564""",
    "valkyrie": """
        -0.568388608683523 0.09162678723221557 -0.10638824998774958 -0.6913799164691645
        0.13916690119789998 -0.17753398104667983 2.1636776501984967 2.070342841223752
        0.14961314065424758 0.3506161255296022
        0.005981149631530819 -0.4677503269464398 0.5371444078779237
        0.44862372410009543 -0.6511154608625681 0.6066741339236323 0.08204819332744379""",
    "fetch": """
        0.30778835991260267 -0.10296727942824391 -0.39099418294190036 -1.392191762560663
        -1.103577116381131 -0.34509545640427275 0.019648478698358396 0.33613349260740977
        0.6788512887664694 0.3382151960729989 1.37587640013965
        0.5759757460201618 -0.629723855685287 -0.4875022868627105 0.18450291564363205""",
}
# Origins of fingertip links in the tip frame with all finger joints at 0 or at their limit, m.
OPEN = {
    "nicol": {
        "r_Ttip": [0.00639, 0.00853, 0.08443],
        "r_Itip": [0.01476, -0.08674, 0.04106],
        "r_Ltip": [0.01366, -0.078, -0.0464],
    },
    "valkyrie": {
        "rightThumbPitch3Link": [0.0049, -0.05443, 0.10932],
        "rightPinkyPitch3Link": [0.0022, -0.14435, -0.04844],
    },
    "fetch": {"l_gripper_finger_link": [0.16645, -0.01543, 0.0]},
}
CLOSED = {
    "nicol": {
        "r_Ttip": [0.00289, 0.00402, 0.01355],
        "r_Itip": [0.02375, -0.00592, 0.03005],
        "r_Ltip": [0.02267, 0.00161, -0.02864],
    },
    "valkyrie": {
        "rightThumbPitch3Link": [0.00438, -0.06408, 0.0128],
        "rightPinkyPitch3Link": [0.03832, -0.06119, -0.03822],
    },
    "fetch": {"l_gripper_finger_link": [0.16645, -0.06542, 0.0]},
}


@pytest.fixture(scope="module", params=NAMES)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


def test_pose_of_a_reference_configuration(robot: Robot) -> None:
    numbers = np.array(REFERENCE[robot.name].split(), dtype=float)
    pose = robot.forward_kinematics(numbers[None, : robot.dof])[0]
    assert np.abs(pose[:3] - numbers[robot.dof : -4]).max() < 1e-9
    turn = np.sign(pose[3:] @ numbers[-4:]) * pose[3:] - numbers[-4:]
    assert np.abs(turn).max() < 1e-9


def test_continuous_joints_of_fetch_are_sampled_over_one_turn() -> None:
    robot = load_robot("fetch")
    turning = [3, 5, 7]
    assert robot.lower[turning].tolist() == [-3.14159] * 3
    assert robot.upper[turning].tolist() == [3.14159] * 3


def test_lift_of_fetch_raises_the_tip_by_itself() -> None:
    robot = load_robot("fetch")
    joints = np.tile(robot.sample(1, seed=3), (2, 1))
    joints[:, 0] = 0.05, 0.30
    low, high = robot.forward_kinematics(joints)
    assert high - low == pytest.approx([0.0, 0.0, 0.25, 0.0, 0.0, 0.0, 0.0], abs=1e-12)


def test_table_and_head_of_nicol_stop_the_arm() -> None:
    robot = load_robot("nicol")
    joints = robot.sample(8000, seed=2, collision_free=False)
    tip = robot.forward_kinematics(joints)[:, :3]
    # 30 mm around the palm's middle: the palm is thicker than that towards the fingers.
    in_table = (np.abs(tip[:, 2] - 0.79) < 0.03) & (tip[:, 0] > 0.05) & (np.abs(tip[:, 1]) < 0.9)
    in_head = np.linalg.norm(tip - [0.211, 0.0, 1.542], axis=1) < 0.1
    assert in_table.sum() > 5
    assert in_head.sum() > 5
    assert robot.in_collision(joints[in_table | in_head]).all()


def test_inertias_are_physical_and_every_link_has_one(robot: Robot) -> None:
    tree = ET.parse(robot.urdf_path).getroot()
    bodies = [link for link in tree.findall("link") if link.get("name") != "world"]
    assert all(link.find("inertial") is not None for link in bodies)
    for inertia in tree.iter("inertia"):
        xx, xy, xz, yy, yz, zz = (
            float(inertia.get(k, "nan")) for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        principal = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        assert principal[0] > 0.0
        assert principal[2] <= (principal[0] + principal[1]) * (1.0 + 1e-6)


@pytest.mark.parametrize("at_upper", [False, True])
def test_fingers_are_where_published(robot: Robot, at_upper: bool) -> None:
    model = pinocchio.buildModelFromUrdf(str(robot.urdf_path))
    data, joints = model.createData(), pinocchio.neutral(model)
    for name, joint in zip(model.names, model.joints, strict=True):
        if at_upper and joint.nq == 1 and name not in robot.joint_names:
            joints[joint.idx_q] = model.upperPositionLimit[joint.idx_q]
    pinocchio.framesForwardKinematics(model, data, joints)
    tip = data.oMf[model.getFrameId(robot.tip)]
    for link, expected in (CLOSED if at_upper else OPEN)[robot.name].items():
        pose = tip.actInv(data.oMf[model.getFrameId(link)])
        assert np.abs(pose.translation - expected).max() < 2e-5, link


def test_left_arm_of_valkyrie_mirrors_the_right() -> None:
    model = pinocchio.buildModelFromUrdf(str(load_robot("valkyrie").urdf_path))
    data, joints = model.createData(), pinocchio.neutral(model)
    flipped = {"ShoulderRoll", "ElbowPitch", "WristRoll", "WristPitch"}  # turn about x or z
    for number, part in enumerate((*sorted(flipped), "ShoulderPitch", "ShoulderYaw", "ForearmYaw")):
        for side, sign in (("right", -1.0 if part in flipped else 1.0), ("left", 1.0)):
            joint = model.joints[model.getJointId(side + part)]
            joints[joint.idx_q] = sign * (0.1 + 0.05 * number)
    pinocchio.framesForwardKinematics(model, data, joints)
    right, left = (data.oMf[model.getFrameId(f"{side}Palm")] for side in ("right", "left"))
    mirror = np.diag([1.0, -1.0, 1.0])
    assert mirror @ right.translation == pytest.approx(left.translation, abs=1e-12)
    assert mirror @ right.rotation @ mirror == pytest.approx(left.rotation, abs=1e-12)


def test_fingers_pulled_by_tendons_stop_at_their_limits(robot: Robot) -> None:
    hand = robot.description.hand
    assert hand is not None
    fingers = hand["tendons"].values() if hand["kind"] == "tendon" else [hand["joints"]]
    with Simulation(robot) as simulation:
        _pull(simulation, {joint for finger in fingers for joint in finger})
        for name in (joint for finger in fingers for joint in finger):
            index = simulation.joints[name]
            position = pybullet.getJointState(simulation.body, index, simulation.client)[0]
            limit = pybullet.getJointInfo(simulation.body, index, simulation.client)[9]
            assert position == pytest.approx(limit, abs=0.06), name
            assert max(hand["open"], hand["closed"]) <= limit + 1e-4, name


def _pull(simulation: Simulation, fingers: set[str]) -> None:
    """Close the fingers for one and a half seconds while all other joints hold still."""
    client = simulation.client
    pybullet.setPhysicsEngineParameter(numSolverIterations=100, physicsClientId=client)
    for name, index in simulation.joints.items():
        info = pybullet.getJointInfo(simulation.body, index, client)
        if info[2] != pybullet.JOINT_FIXED:
            target = {"force": info[10]}
            if name in fingers:
                target = {"targetVelocity": 2.0, "force": 0.4}
            pybullet.setJointMotorControl2(
                simulation.body,
                index,
                pybullet.VELOCITY_CONTROL,
                physicsClientId=client,
                **target,
            )
    for _ in range(360):
        pybullet.stepSimulation(client)
