"""Lanes against NumPy, against the kernels for one configuration, and the code that comes out."""

import operator
import platform

import numpy as np
import pytest
from numba import njit

from baselines.damped_step import damped_step
from baselines.lanes import (
    LANES,
    bit,
    greatest,
    lanes_of,
    least,
    load,
    mask_bits,
    root,
    select,
    store,
)
from baselines.lanes_kinematics import find_lanes_error, find_lanes_frames, find_lanes_jacobian
from baselines.lanes_step import lanes_damped_step
from baselines.lanes_trigonometry import lanes_angle, lanes_sine_cosine
from baselines.lanes_work import STATES, Work, new_room
from baselines.linearise import (
    find_error,
    find_jacobian,
    new_linearisation,
    set_target,
)
from baselines.lm_kernel import _scratch
from baselines.seed_library import empty_seed_library
from robots import Robot, available_robots, load_robot
from tests.small_arms import arm, save
from tests.unit.baselines.test_lm import MIXED

Array = np.ndarray
RNG = np.random.default_rng(3)
A, B = RNG.normal(size=(2, LANES))


def rows(*values: Array) -> Array:
    """Rows of lanes for compiled code, and as many again for results."""
    return np.concatenate([np.stack(values), np.zeros((len(values), LANES))])


@pytest.mark.parametrize("name", ["add", "sub", "mul", "truediv"])
def test_arithmetic_goes_lane_by_lane(name: str) -> None:
    function = getattr(operator, name)

    @njit
    def compute(lanes):  # type: ignore[no-untyped-def]
        a, b = load(lanes, 0), load(lanes, 1)
        store(lanes, 2, function(a, b))
        store(lanes, 3, function(function(2.5, a), 4.0))

    lanes = rows(A, B)
    compute(lanes)
    assert np.array_equal(lanes[2], function(A, B))
    assert np.array_equal(lanes[3], function(function(2.5, A), 4.0))


@pytest.mark.parametrize("name", ["lt", "le", "gt", "ge", "eq"])
def test_comparisons_are_bits(name: str) -> None:
    function = getattr(operator, name)

    @njit
    def compute(lanes):  # type: ignore[no-untyped-def]
        a, b = load(lanes, 0), load(lanes, 1)
        return mask_bits(function(a, b)), mask_bits(function(a, 0.25)), mask_bits(function(0.25, a))

    a, b = A.copy(), B.copy()
    a[2], a[3], a[5] = b[2], 0.25, np.nan
    expected = (function(a, b), function(a, 0.25), function(0.25, a))
    assert compute(rows(a, b)) == tuple(int((mask << np.arange(LANES)).sum()) for mask in expected)


def test_masks_and_selection() -> None:
    @njit
    def compute(lanes):  # type: ignore[no-untyped-def]
        a, b = load(lanes, 0), load(lanes, 1)
        low, positive = a < b, a > 0.0
        store(lanes, 4, select(low & positive, a, 7.0))
        store(lanes, 5, select(low | positive, 7.0, b))
        store(lanes, 6, select(low ^ positive, 1.0, 2.0))
        store(lanes, 7, select(~low, a, b))
        store(lanes, 2, least(a, b))
        store(lanes, 3, greatest(-a, b))
        return 0

    lanes = rows(A, B, A, B)
    compute(lanes)
    low, positive = A < B, A > 0
    assert np.array_equal(lanes[4], np.where(low & positive, A, 7.0))
    assert np.array_equal(lanes[5], np.where(low | positive, 7.0, B))
    assert np.array_equal(lanes[6], np.where(low ^ positive, 1.0, 2.0))
    assert np.array_equal(lanes[7], np.where(~low, A, B))
    assert np.array_equal(lanes[2], np.minimum(A, B))
    assert np.array_equal(lanes[3], np.maximum(-A, B))


def test_roots_bits_and_spreading() -> None:
    @njit
    def compute(lanes):  # type: ignore[no-untyped-def]
        store(lanes, 2, root(load(lanes, 0)))
        store(lanes, 3, lanes_of(0.1))
        return mask_bits(bit(load(lanes, 1), 0)), mask_bits(bit(load(lanes, 1), 63))

    numbers = np.array([1.0, -1.0, np.nextafter(1.0, 2.0), 0.0, -0.0, np.nextafter(-2.0, 0), 3, -3])
    lanes = rows(np.abs(A), numbers)
    lowest, sign = compute(lanes)
    assert np.array_equal(lanes[2], np.sqrt(np.abs(A)))
    assert (lanes[3] == 0.1).all()
    assert (lowest, sign) == (0b100100, 0b10110010)


@njit
def _sine_cosine(angles):  # type: ignore[no-untyped-def]
    sine, cosine = lanes_sine_cosine(load(angles, 0))
    store(angles, 1, sine)
    store(angles, 2, cosine)


@njit
def _angle(parts):  # type: ignore[no-untyped-def]
    store(parts, 2, lanes_angle(load(parts, 0), load(parts, 1)))


@pytest.mark.parametrize("size", [1e-9, 1.0, 7.0, 1e3, 1e6])
def test_sine_and_cosine(size: float) -> None:
    for angles in np.random.default_rng(1).uniform(-size, size, (500, LANES)):
        lanes = np.stack([angles, angles, angles])
        _sine_cosine(lanes)
        assert np.abs(lanes[1] - np.sin(angles)).max() < 3e-16
        assert np.abs(lanes[2] - np.cos(angles)).max() < 3e-16


def test_sine_and_cosine_of_quarter_turns() -> None:
    lanes = np.stack([np.arange(-4, 4) * np.pi / 2] * 3)
    _sine_cosine(lanes)
    assert np.abs(lanes[1] - [0, 1, 0, -1, 0, 1, 0, -1]).max() < 1e-15
    assert np.abs(lanes[2] - [1, 0, -1, 0, 1, 0, -1, 0]).max() < 1e-15


def test_angles_to_the_last_digits() -> None:
    rng = np.random.default_rng(2)
    special = [0.0, np.pi, np.pi / 2, np.pi / 4, np.pi / 8, 3 * np.pi / 4, 1e-300, np.pi - 1e-9]
    trials = [np.array(special), *rng.uniform(0, np.pi, (500, LANES))]
    trials += [*np.exp(rng.uniform(-40, 0, (200, LANES)))]
    for angles in trials:
        sine, cosine = 2 * np.maximum(np.sin(angles), 0.0), 2 * np.cos(angles)
        lanes = np.stack([sine, cosine, sine])
        _angle(lanes)
        expected = np.arctan2(sine, cosine)
        assert (np.abs(lanes[2] - expected) <= 1e-15 * expected).all()


@njit(_nrt=False)
def _linearise(chain, w, out):  # type: ignore[no-untyped-def]
    frame = find_lanes_frames(chain, w.q, w.axes)
    error, distance2, angle2 = find_lanes_error(w.target, frame)
    find_lanes_jacobian(chain, w.axes, frame, w.jacobian)
    for k in range(12):
        store(out, k, frame[k])
    for k in range(6):
        store(out, 12 + k, error[k])
    store(out, 18, distance2)
    store(out, 19, angle2)


@njit(_nrt=False)
def _move(chain, w, still, passes):  # type: ignore[no-untyped-def]
    frame = find_lanes_frames(chain, w.q, w.axes)
    error, distance2, angle2 = find_lanes_error(w.target, frame)
    find_lanes_jacobian(chain, w.axes, frame, w.jacobian)
    moving = load(still, 0) == 0.0
    lanes_damped_step(chain, w, error, 1e-3 + 0.1 * (distance2 + angle2), moving, passes)


def lanes_for(robot: Robot, joints: Array, poses: Array) -> Work:
    """Lanes with configurations (LANES, dof) and targets (LANES, 7).

    A type of its own would be pickled into numba's cache of the functions called with it, and
    whoever reads that cache without this file at hand would fail.
    """
    dof, driven = robot.dof, len(robot.chain.prismatic)
    target = np.empty((12, LANES))
    at = new_linearisation(driven, dof)
    for lane, pose in enumerate(poses):
        set_target(pose, at)
        target[:9, lane], target[9:, lane] = at.goal.ravel(), pose[:3]
    step, free, best, start, pose_best = np.zeros((5, dof, LANES))
    axes, jacobian = np.zeros((6 * driven, LANES)), np.zeros((6 * dof, LANES))
    state, distances = np.zeros((STATES, LANES)), np.zeros((LANES, 0), dtype=np.float32)
    goal = target[:9].reshape(3, 3, LANES)
    own = (joints.T.copy(), step, free, best, start, pose_best)
    return Work(*own, target, goal, axes, jacobian, state, distances)


@pytest.fixture(scope="module", params=[*available_robots(), "mixed", 1, 4, 20])
def robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    if request.param == "mixed":
        return load_robot(urdf=MIXED, base="bench", tip="tool")
    if isinstance(request.param, int):
        return load_robot(urdf=save(tmp_path_factory.mktemp("arm"), arm(request.param)))
    return load_robot(request.param)


def configurations(robot: Robot, seed: int) -> Array:
    """Configurations (LANES, dof), some joints of which stand at a limit."""
    joints = robot.sample(LANES, seed=seed, collision_free=False)
    rng = np.random.default_rng(seed)
    joints = np.where(rng.uniform(size=joints.shape) < 0.2, robot.chain.lower, joints)
    return np.where(rng.uniform(size=joints.shape) < 0.2, robot.chain.upper, joints)


def test_lanes_linearise_as_one_configuration_does(robot: Robot) -> None:
    for seed in range(5):
        joints = configurations(robot, seed)
        poses = robot.forward_kinematics(robot.sample(LANES, seed=50 + seed, collision_free=False))
        poses[0] = robot.forward_kinematics(joints[:1])[0]  # no error at all
        w, out = lanes_for(robot, joints, poses), np.empty((20, LANES))
        _linearise(robot.chain, w, out)
        at = new_linearisation(len(robot.chain.prismatic), robot.dof)
        for lane, (q, pose) in enumerate(zip(joints, poses, strict=True)):
            set_target(pose, at)
            squares = find_error(robot.chain, q, pose, at)
            find_jacobian(robot.chain, at)
            assert np.allclose(out[:9, lane], at.rotation.ravel(), atol=1e-13)
            assert np.allclose(out[9:12, lane], at.position, atol=1e-13)
            assert np.allclose(out[12:18, lane], at.error, atol=1e-12)
            assert np.allclose(out[18:, lane], squares, atol=1e-12)
            assert np.allclose(w.jacobian[:, lane], at.jacobian.ravel(), atol=1e-13)


@pytest.mark.parametrize("turn", [np.pi, np.pi - 1e-7, 1e-10, 0.0])
def test_errors_of_half_turns_and_of_none(turn: float) -> None:
    panda = load_robot("panda")
    joints = panda.sample(LANES, seed=4, collision_free=False)
    goals = joints.copy()
    goals[:, 6] += turn  # the last joint turns about an axis of the tip
    poses = panda.forward_kinematics(goals)
    w, out = lanes_for(panda, joints, poses), np.empty((20, LANES))
    _linearise(panda.chain, w, out)
    assert np.allclose(np.linalg.norm(out[15:18], axis=0), turn, atol=3e-8)
    assert np.allclose(out[19], turn**2, atol=1e-6)


@pytest.mark.parametrize("passes", [0, 1, 3])
def test_lanes_step_as_one_configuration_does(robot: Robot, passes: int) -> None:
    for seed in range(8):
        joints = configurations(robot, seed)
        poses = robot.forward_kinematics(robot.sample(LANES, seed=70 + seed, collision_free=False))
        w = lanes_for(robot, joints, poses)
        still = np.zeros((1, LANES))
        still[0, 3] = 1.0
        _move(robot.chain, w, still, passes)
        assert np.array_equal(w.q[:, 3], joints[3])
        assert (w.q >= robot.chain.lower[:, None]).all()
        assert (w.q <= robot.chain.upper[:, None]).all()
        one = _scratch(len(robot.chain.prismatic), robot.dof, empty_seed_library(robot.dof))
        for lane in set(range(LANES)) - {3}:
            one.q[:] = joints[lane]
            set_target(poses[lane], one.at)
            squared = sum(find_error(robot.chain, one.q, poses[lane], one.at))
            damped_step(robot.chain, one, None, 1e-3 + 0.1 * squared, passes)
            assert np.allclose(w.q[:, lane], one.q, atol=1e-9)


@pytest.mark.skipif(platform.machine() != "x86_64", reason="looks for registers of x86")
def test_the_code_that_comes_out_is_packed() -> None:
    @njit(fastmath={"contract"}, _nrt=False)
    def compute(lanes):  # type: ignore[no-untyped-def]
        sine, cosine = lanes_sine_cosine(load(lanes, 0))
        store(lanes, 1, sine * cosine + 1.0)

    lanes = np.zeros((2, LANES))
    compute(lanes)
    text = compute.inspect_asm(compute.signatures[0])
    lines = [line for line in text.splitlines() if "mul" in line and "d\t" in line and "mm" in line]
    packed = [line for line in lines if line.split()[0].rstrip("d").endswith("p")]
    assert len(packed) >= 1
    assert not [line for line in lines if line.split()[0].endswith("mulsd")]


def test_rows_of_lanes_lie_in_one_line_of_the_cache() -> None:
    room = new_room(3, 7, 7, 11)
    assert room.lanes.ctypes.data % 64 == 0
    assert room.lanes.flags.c_contiguous and room.lanes.shape[::2] == (3, LANES)
    assert room.distances.shape == (3, LANES, 11)
