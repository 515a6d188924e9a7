"""Losses against values computed by hand from the paper's equations."""

from __future__ import annotations

import math

import pytest
import torch

from pipeline.config import compose
from pipeline.learning.factory import build_network, make_objective
from pipeline.learning.losses import (
    PoseLoss,
    former_position_loss,
    former_rotation_loss,
    matrix_loss,
    position_error_mm,
    position_loss,
    rotation_error_deg,
    smooth_minimum_quaternion_loss,
    winner_takes_most,
)
from pipeline.learning.rotation import matrix_from_quaternion
from robots import load_robot


def test_position_loss_is_quadratic_below_beta_and_linear_above() -> None:
    predicted = torch.tensor([[0.0005, 0.0, -0.011]])
    # axis 1: 0.5 * 0.0005^2 / 0.001; axis 2: 0; axis 3: 0.011 - 0.0005; mean over three axes
    expected = (0.000125 + 0.0 + 0.0105) / 3
    assert position_loss(predicted, torch.zeros(1, 3), 0.001).item() == pytest.approx(expected)


def test_quaternion_loss_sums_components_and_takes_the_nearer_sign() -> None:
    target = torch.tensor([[1.0, 0.0, 0.0, 0.0]])
    predicted = torch.tensor([[-0.95, 0.005, 0.0, 0.0]])
    # nearer sign: |-0.95 + 1| = 0.05 -> 0.05 - 0.005; 0.005 -> 0.5 * 0.005^2 / 0.01
    expected = 0.045 + 0.00125
    assert smooth_minimum_quaternion_loss(predicted, target, 0.01).item() == pytest.approx(expected)


@pytest.mark.parametrize("loss", ["smooth", "matrix"])
def test_the_sign_of_the_target_quaternion_changes_no_loss(loss: str) -> None:
    generator = torch.Generator().manual_seed(0)
    target = torch.nn.functional.normalize(torch.randn(100, 4, generator=generator), dim=1)
    reached = torch.nn.functional.normalize(torch.randn(100, 4, generator=generator), dim=1)
    position = torch.randn(100, 3, generator=generator)
    pose_loss = PoseLoss(compose([f"train.loss={loss}"]).train)
    rotation = matrix_from_quaternion(reached)
    plus = pose_loss(position, rotation, torch.cat((position, target), dim=1))
    minus = pose_loss(position, rotation, torch.cat((position, -target), dim=1))
    assert torch.equal(plus, minus)
    assert (plus > 0).all()


def test_former_losses_are_mean_absolute_errors() -> None:
    position = former_position_loss(torch.tensor([[0.1, -0.2, 0.3]]), torch.zeros(1, 3))
    assert position.item() == pytest.approx(0.2)
    quaternion = torch.tensor([[1.0, 0.0, 0.0, 0.0]])
    assert former_rotation_loss(-quaternion, quaternion).item() == pytest.approx(0.5)


def test_the_former_loss_takes_reached_rotations_with_the_sign_of_the_data() -> None:
    """Near a half turn the quaternion of a matrix may come out with w < 0, unlike in data."""
    quaternion = torch.nn.functional.normalize(torch.tensor([[0.1, -1.0, 0.0, 0.0]]), dim=1)
    target = torch.cat((torch.zeros(1, 3), quaternion), dim=1)
    former = PoseLoss(compose(["train.loss=former"]).train)
    _, turned = former.parts(torch.zeros(1, 3), matrix_from_quaternion(quaternion), target)
    assert turned.item() == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("loss", "position", "rotation"),
    [
        # 11 mm along z: 0.011 - beta / 2, mean over three axes. A quarter turn about z against
        # none: quaternion entries 0.2929 and 0.7071 off, each less beta / 2, summed up.
        ("smooth", 0.0105 / 3, 1.0 - 2 * 0.005),
        ("former", 0.011 / 3, 1.0 / 4),
    ],
)
def test_the_loss_of_a_pose_weighs_its_parts(loss: str, position: float, rotation: float) -> None:
    """Equation 9 with the weights of NICO in Table I, by hand."""
    train = compose(["robot=nico", "experiment=table_one", f"train.loss={loss}"]).train
    root = math.sqrt(0.5)
    turned = matrix_from_quaternion(torch.tensor([[root, 0.0, 0.0, root]]))
    target = torch.tensor([[0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0]])
    reached = torch.tensor([[0.1, 0.2, 0.311]])
    parts = PoseLoss(train).parts(reached, turned, target)
    assert [part.item() for part in parts] == pytest.approx([position, rotation], rel=1e-4)
    total = PoseLoss(train)(reached, turned, target).item()
    assert total == pytest.approx(7 * position + 1 * rotation, rel=1e-4)


def test_the_former_rotation_loss_sees_the_sign_which_is_why_it_was_replaced() -> None:
    train = compose(["train.loss=former"]).train
    target = torch.tensor([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    negated = target * torch.tensor([1.0, 1, 1, -1, -1, -1, -1])
    frames = torch.zeros(1, 3), torch.eye(3)[None]
    assert PoseLoss(train)(*frames, target).item() == 0.0
    assert PoseLoss(train)(*frames, negated).item() > 0.4 * train.rotation_weight


@pytest.mark.parametrize("loss", ["smooth", "matrix"])
def test_a_compact_network_sees_no_sign_at_all(loss: str) -> None:
    """From the input to the loss: both signs of a quaternion are one rotation."""
    robot = load_robot("nico")
    config = compose([f"train.loss={loss}", "model=compact"])
    poses = torch.as_tensor(
        robot.forward_kinematics(robot.sample(300, collision_free=False)), dtype=torch.float32
    )
    torch.manual_seed(0)
    network = build_network(robot, config.model)
    network.prepare(poses)
    objective = make_objective(robot, network, config.train, torch.device("cpu"))
    negated = torch.cat((poses[:, :3], -poses[:, 3:]), dim=1)
    joints = torch.zeros(300, robot.dof)
    plus, minus = (objective.loss(given, joints, 0, 0.5) for given in (poses, negated))
    assert torch.equal(plus, minus)
    for one, other in zip(objective.errors(poses), objective.errors(negated), strict=True):
        torch.testing.assert_close(one, other, rtol=1e-5, atol=1e-5)


def test_matrix_loss_of_a_quarter_turn() -> None:
    quarter = torch.tensor([[math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)]])
    identity = torch.tensor([[1.0, 0.0, 0.0, 0.0]])
    # about z: two diagonal entries fall from 1 to 0, two others go to +-1; each counts 1 - beta / 2
    loss = matrix_loss(matrix_from_quaternion(quarter), matrix_from_quaternion(identity), 0.01)
    assert loss.item() == pytest.approx(4 * 0.995 / 9, rel=1e-5)


def test_winner_takes_most() -> None:
    losses = torch.tensor([[1.0, 3.0], [6.0, 2.0]])
    assert winner_takes_most(losses, 0.0).item() == pytest.approx(1.5)
    assert winner_takes_most(losses, 1.0).item() == pytest.approx(3.0)
    assert winner_takes_most(losses, 0.1).item() == pytest.approx(0.9 * 1.5 + 0.1 * 3.0)


def test_errors_in_millimetres_and_degrees() -> None:
    assert position_error_mm(torch.tensor([[3.0, 4.0, 0.0]]), torch.zeros(1, 3)).item() == 5000.0
    half = math.radians(0.01) / 2
    tiny = torch.tensor([[math.cos(half), math.sin(half), 0.0, 0.0]])
    identity = torch.tensor([[-1.0, 0.0, 0.0, 0.0]])
    assert rotation_error_deg(tiny, identity).item() == pytest.approx(0.01, rel=1e-3)
