"""Secondary goals: hand-computed penalties, other links, and that they act on a network."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.data.dataset import PoseSet
from pipeline.errors import ConfigError
from pipeline.learning.constraints import ConstraintError, Penalty, make_penalty
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.learning.factory import build_network
from pipeline.learning.kinematics import ChainKinematics, make_link_kinematics
from pipeline.learning.trainer import Trainer, TrainingRun
from robots import Robot, load_robot
from robots.errors import UrdfError

CPU = torch.device("cpu")


@pytest.fixture(scope="module")
def nicol() -> Robot:
    return load_robot("nicol")


def penalty_of(robot: Robot, goals: str, *overrides: str) -> Penalty | None:
    return make_penalty(robot, compose([f"train.constraints={goals}", *overrides]).train, CPU)


def test_a_posture_costs_the_weighted_mean_square_of_its_joints(nicol: Robot) -> None:
    joints = torch.tensor([[9.0, 9, 9, 1, 2, 3, 9, 9], [9, 9, 9, 0, 0, 0, 9, 9]])
    zero = penalty_of(nicol, "[{joints:[3,4,5],posture:0,weight:0.5}]")
    assert zero is not None
    torch.testing.assert_close(zero(joints), torch.tensor([0.5 * 14 / 3, 0.0]))
    named = "[{joints:[r_joint4,r_joint6],posture:[1,1],weight:1},{joints:[4],posture:0,weight:2}]"
    both = penalty_of(nicol, named, "train.constraint_scale=10")
    assert both is not None
    torch.testing.assert_close(both(joints), torch.tensor([10 * (2.0 + 8.0), 10 * 1.0]))


@pytest.mark.parametrize("name", ["panda", "fetch", "nico"])
def test_clearance_costs_what_links_lack_of_it(name: str) -> None:
    """What collides costs something, and slopes are those of finite differences."""
    robot = load_robot(name)
    values = robot.sample(400, seed=3, collision_free=False)
    joints = torch.tensor(values, requires_grad=True)
    near, far = (penalty_of(robot, f"[{{clearance:{c},weight:1}}]") for c in (0.001, 0.003))
    assert near is not None
    assert far is not None
    costs = near(joints)
    colliding = robot.in_collision(values)
    assert (costs[colliding] > 0).all()
    assert (costs[~colliding] <= 0.5).float().mean() > 0.95, "one pair at most lacks one clearance"
    # The same gap costs less in units of a larger clearance, but that is lacked sooner.
    assert (far(joints) > 0).sum() >= (costs > 0).sum()
    costs.sum().backward()
    assert joints.grad is not None
    deep = np.flatnonzero((costs > 0.6).numpy())[:20]
    assert len(deep) > 0
    agreeing = 0
    for row in deep:
        moved = np.repeat(values[row : row + 1], 2 * robot.dof, axis=0)
        moved[: robot.dof] += 1e-6 * np.eye(robot.dof)
        moved[robot.dof :] -= 1e-6 * np.eye(robot.dof)
        both = near(torch.tensor(moved)).double().numpy()
        slope = (both[: robot.dof] - both[robot.dof :]) / 2e-6
        wanted = joints.grad[row].numpy()
        agreeing += np.allclose(slope, wanted, rtol=0.05, atol=0.02 * np.abs(wanted).max())
    assert agreeing >= 0.8 * len(deep), "corners and edges change over within a difference"


def test_clearance_needs_a_processor(nicol: Robot) -> None:
    train = compose(["train.constraints=[{clearance:0.01,weight:1}]"]).train
    with pytest.raises(ConstraintError, match=r"not on cuda: set train\.device=cpu"):
        make_penalty(nicol, train, torch.device("cuda"))


def test_links_of_answers_are_near_less_often_where_clearance_counts() -> None:
    robot = load_robot("panda")
    joints = robot.sample(3000, seed=1)
    poses = PoseSet(robot.forward_kinematics(joints), joints)
    share, goal = {}, "[{clearance:0.02,weight:5}]"
    near = penalty_of(robot, goal)
    assert near is not None
    for scale in (0, 1):
        overrides = [
            f"train.constraints={goal}",
            f"train.constraint_scale={scale}",
            "model=tiny",
            "train.batch_size=100",
        ]
        config = compose([*overrides, "train.epochs=10", "train.validations=1"])
        torch.manual_seed(0)
        network = build_network(robot, config.model)
        trainer = Trainer(robot, network, config.train, TrainingRun(0, "", "clearance"))
        trainer.fit(poses, poses)
        with torch.no_grad():
            answers = trainer.network(trainer.tensor(poses.poses)).flatten(0, 1)
        share[scale] = float((near(answers) > 0).float().mean())
    assert share[0] > 0.02
    assert share[1] < 0.6 * share[0]


def test_no_goals_or_a_scale_of_zero_cost_nothing(nicol: Robot) -> None:
    assert penalty_of(nicol, "[]") is None
    goal = "[{joints:[3],posture:0,weight:1}]"
    assert penalty_of(nicol, goal, "train.constraint_scale=0") is None


@pytest.mark.parametrize(
    ("robot", "link"),
    [("nicol", "r_forearm"), ("panda", "panda_link5"), ("fetch", "elbow_flex_link")],
)
def test_another_link_is_where_a_robot_that_ends_there_has_its_tip(robot: str, link: str) -> None:
    whole = load_robot(robot)
    part = load_robot(urdf=whole.urdf_path, base=whole.base, tip=link)
    shared = [name for name in part.joint_names if name in whole.joint_names]
    joints = whole.sample(50, seed=2, collision_free=False)
    posture = np.zeros((50, part.dof))
    for name in part.joint_names:
        column = (
            joints[:, whole.joint_names.index(name)]
            if name in shared
            else whole.description.posture[name]
        )
        posture[:, part.joint_names.index(name)] = column
    expected = part.forward_kinematics(posture)
    batch = torch.as_tensor(joints, dtype=torch.float32)
    for kinematics in (
        make_link_kinematics(whole, link, CPU),
        ChainKinematics(whole.chain_to(link), CPU),
    ):
        position, _ = kinematics(batch)
        np.testing.assert_allclose(position.numpy(), expected[:, :3], atol=2e-6)


@pytest.mark.parametrize("robot", ["panda", "fetch", "valkyrie"])
def test_tensor_products_and_compiled_code_agree_in_frames_and_gradients(robot: str) -> None:
    made = load_robot(robot)
    joints = torch.as_tensor(made.sample(20, seed=3, collision_free=False), dtype=torch.float32)
    results = []
    for kinematics in (
        make_link_kinematics(made, made.tip, CPU),
        ChainKinematics(made.chain_to(made.tip), CPU),
    ):
        leaf = joints.clone().requires_grad_()
        position, rotation = kinematics(leaf)
        (position.sum() + (rotation * torch.arange(9.0).view(3, 3)).sum()).backward()
        results.append((position.detach(), rotation.detach(), leaf.grad))
    for compiled, products in zip(*results, strict=True):
        torch.testing.assert_close(compiled, products, atol=2e-5, rtol=1e-5)


def test_a_link_at_its_goal_costs_nothing_and_another_costs_its_distance(nicol: Robot) -> None:
    joints = torch.as_tensor(nicol.sample(2, seed=5, collision_free=False), dtype=torch.float32)
    position, _ = make_link_kinematics(nicol, "r_forearm", CPU)(joints)
    goal = [round(float(value), 6) for value in position[0]]
    overrides = ["train.position_weight=3", "train.position_beta=1.0e-3"]
    penalty = penalty_of(nicol, f"[{{link:r_forearm,position:{goal},weight:2}}]", *overrides)
    assert penalty is not None
    here, away = penalty(joints)
    distance = (position[1] - position[0]).abs()
    torch.testing.assert_close(here, torch.tensor(0.0), atol=1e-6, rtol=0)
    # weighted once, by the goal, whatever the tip's position weighs
    torch.testing.assert_close(away, 2 * (distance - 0.5e-3).mean(), rtol=1e-3, atol=0)


@pytest.mark.parametrize(
    ("goal", "error", "words"),
    [
        ("{joints:[r_joint99],posture:0,weight:1}", ConstraintError, "r_joint9"),
        ("{joints:[8],posture:0,weight:1}", ConstraintError, "'8'"),
        ("{joints:[],posture:0,weight:1}", ConstraintError, "at least one"),
        ("{joints:[1,2],posture:[1,2,3],weight:1}", ConstraintError, "one number or 2"),
        ("{link:r_foot,position:[0,0,1],weight:1}", UrdfError, "r_foot"),
        ("{link:base_link,position:[0,0,1],weight:1}", ConstraintError, "stands still"),
        ("{link:r_palm,pose:[0,0,1,1,1,0,0],weight:1}", ConstraintError, "unit"),
    ],
)
def test_goals_that_a_robot_cannot_have_are_refused(
    nicol: Robot, goal: str, error: type[ValueError], words: str
) -> None:
    with pytest.raises(error, match=words):
        penalty_of(nicol, f"[{goal}]")


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        ("{joints:[1],weight:1}", "joints and posture"),
        ("{joints:[1],posture:0,link:r_palm,weight:1}", "got joints, link, posture"),
        ("{link:r_palm,position:[1,2],weight:1}", "must be 3 numbers"),
        ("{joints:[1],posture:0,weight:-1}", "greater than 0"),
        ("{joints:[1],posture:0}", "weight"),
        ("{clearance:0.1,link:r_palm,weight:1}", "got clearance, link"),
        ("{clearance:0,weight:1}", "clearance.*greater than 0"),
    ],
)
def test_goals_that_cannot_be_are_refused_by_the_configuration(goal: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        compose([f"train.constraints=[{goal}]"])


def test_a_posture_goal_brings_its_joints_nearer(nicol: Robot) -> None:
    joints = nicol.sample(2000, seed=1, collision_free=False)
    poses = PoseSet(nicol.forward_kinematics(joints), joints)
    mean = {}
    for scale in (0, 1):
        goal = "train.constraints=[{joints:[3,4,5],posture:0,weight:1}]"
        overrides = [goal, f"train.constraint_scale={scale}", "model=tiny", "train.batch_size=100"]
        config = compose([*overrides, "train.epochs=10", "train.validations=1"])
        torch.manual_seed(0)
        network = build_network(nicol, config.model)
        trainer = Trainer(nicol, network, config.train, TrainingRun(0, "", "constraint"))
        trainer.fit(poses, poses)
        assert isinstance(trainer.objective, CycleObjective)
        with torch.no_grad():
            answers = trainer.network(trainer.tensor(poses.poses))
        mean[scale] = float(answers[..., 3:6].abs().mean())
    assert mean[1] < 0.6 * mean[0]
