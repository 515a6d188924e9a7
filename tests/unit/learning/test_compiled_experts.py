"""What the compiled answers are made of: products, activations, kinematics of many poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline.learning.cycleik.compiled.activations import gelu_values, tanh_values
from pipeline.learning.cycleik.compiled.products import linear, pack_layer, panels
from pipeline.learning.cycleik.compiled.ranking import (
    ERRORS,
    FRAME,
    LANES,
    arc_sine,
    errors_of_lanes,
    tips_of_lanes,
)
from robots import available_robots, load_robot
from robots.rotations import matrix_from_quaternion

MIXED = Path(__file__).parents[2] / "fixtures" / "mixed.urdf"  # turning, sliding, coupled joints


def test_a_layer_is_cut_into_the_widest_panels_that_fit() -> None:
    assert panels(128, np.float32) == [64, 64]
    assert panels(112, np.float32) == [64, 32, 16]
    assert panels(48, np.float32) == [32, 16]
    assert panels(112, np.float64) == [32, 32, 32, 16]
    assert panels(16, np.float64) == [16]


def test_a_layer_is_packed_bias_first_panel_by_panel() -> None:
    weight = np.arange(2 * 48.0).reshape(1, 2, 48)
    bias = -np.arange(48.0)[None]
    packed = pack_layer(weight, bias, np.float32)[0]
    assert packed.dtype == np.float32
    wanted = np.concatenate(
        [
            part[:, columns].ravel()
            for columns in (slice(0, 32), slice(32, 48))
            for part in (bias, weight[0])
        ]
    )
    assert np.array_equal(packed, wanted)


@pytest.mark.parametrize(("dtype", "near"), [("float32", 2e-5), ("float64", 1e-13)])
@pytest.mark.parametrize("rows", [1, 5, 13])
@pytest.mark.parametrize(("depth", "width"), [(12, 64), (128, 128), (20, 16), (7, 112)])
def test_products_are_exact_to_rounding_and_each_row_is_alone(
    rows: int, depth: int, width: int, dtype: str, near: float
) -> None:
    random = np.random.default_rng(depth)
    weight, bias = random.normal(size=(1, depth, width)), random.normal(size=(1, width))
    packed = np.concatenate([np.full(3, np.nan, dtype), pack_layer(weight, bias, dtype)[0]])
    inputs = random.normal(size=(rows, depth)).astype(dtype)
    values = np.full(rows * (depth + width) + 5, np.nan, dtype)
    values[: rows * depth] = inputs.ravel()
    place = rows * depth + 2
    linear(values, 0, rows, depth, packed, 3, width, place)
    outputs = values[place:-3].reshape(rows, width)
    assert np.isnan(values[rows * depth : place]).all()
    assert np.isnan(values[-3:]).all()
    np.testing.assert_allclose(outputs, inputs @ weight[0] + bias, rtol=0, atol=near)
    alone = np.concatenate([inputs[-1], np.zeros(width, dtype)])
    linear(alone, 0, 1, depth, packed, 3, width, depth)
    assert np.array_equal(alone[depth:], outputs[-1])


@pytest.mark.parametrize(("dtype", "near"), [("float32", 4e-7), ("float64", 5e-10)])
def test_activations_are_those_of_torch_to_a_few_roundings(dtype: str, near: float) -> None:
    shown = np.concatenate([np.linspace(-30, 30, 400_001), np.linspace(-1, 1, 100_001)])
    exact = torch.as_tensor(shown.astype(dtype)).double()
    values = np.concatenate([[7.0], shown, [7.0]]).astype(dtype)
    tanh_values(values, 1, len(values) - 1)
    assert np.abs(values[1:-1] - torch.tanh(exact).numpy()).max() < near
    assert values[0] == values[-1] == 7.0
    values[1:-1] = shown
    gelu_values(values, 1, len(values) - 1)
    wanted = torch.nn.functional.gelu(exact, approximate="tanh").numpy()
    assert np.all(np.abs(values[1:-1] - wanted) <= 1.75 * near * np.maximum(1.0, np.abs(shown)))
    assert values[0] == values[-1] == 7.0


def test_arc_sine_is_exact_to_twelve_digits() -> None:
    sines = np.concatenate([np.linspace(0, 1, 100_001), np.geomspace(1e-12, 0.1, 1000)])
    angles = np.array([arc_sine(sine) for sine in sines])
    np.testing.assert_allclose(angles, np.arcsin(sines), rtol=1e-12, atol=0)


@pytest.mark.parametrize("name", [*available_robots(), "mixed"])
def test_lanes_reach_what_forward_kinematics_reaches(name: str) -> None:
    mixed = name == "mixed"
    robot = load_robot(urdf=MIXED, base="bench", tip="tool") if mixed else load_robot(name)
    shown = robot.sample(2 * LANES, seed=9, collision_free=False)
    reached = robot.forward_kinematics(shown)
    joints = np.concatenate([shown[:LANES].T.ravel(), shown[LANES:].T.ravel()])
    frames = np.empty(FRAME * LANES)
    goals = np.empty((FRAME, LANES))
    for block in range(2):
        rows = slice(block * LANES, (block + 1) * LANES)
        tips_of_lanes(robot.chain, joints, block * robot.dof * LANES, frames)
        goals[:9] = matrix_from_quaternion(reached[rows, 3:]).reshape(LANES, 9).T
        goals[9:] = reached[rows, :3].T
        np.testing.assert_allclose(frames.reshape(FRAME, LANES), goals, atol=1e-12)


def test_errors_of_lanes_are_those_of_a_turn_and_a_shift() -> None:
    angles = np.linspace(0, np.pi, LANES)
    frames, goals = np.zeros((FRAME, LANES)), np.zeros((FRAME, LANES))
    frames[[0, 4, 8]] = 1.0
    goals[0], goals[1], goals[3], goals[4] = (
        np.cos(angles),
        -np.sin(angles),
        np.sin(angles),
        np.cos(angles),
    )
    goals[8] = 1.0
    goals[9], goals[10] = 0.3, 0.4
    errors = np.empty(2 * ERRORS * LANES)
    errors_of_lanes(frames.ravel(), goals.ravel(), np.array([10.0, 2.0]), errors, ERRORS * LANES)
    distance, angle, cost = errors[ERRORS * LANES :].reshape(ERRORS, LANES)
    np.testing.assert_allclose(distance, 0.5, rtol=1e-15)
    np.testing.assert_allclose(angle, angles, atol=1e-7)
    np.testing.assert_allclose(cost, 5 + 2 * angle, rtol=1e-14)
