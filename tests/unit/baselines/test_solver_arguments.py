"""One gate for what a caller hands to a solver: poses, guesses, budgets, settings."""

import time

import numpy as np
import pytest
import torch

import baselines
from baselines import (
    Budget,
    BudgetError,
    InitialError,
    PoseError,
    SettingError,
    Solver,
    SolverError,
    UnknownSolverError,
)
from robots import load_robot
from robots.limits import FARTHEST


@pytest.fixture(scope="module")
def lm() -> Solver:
    return baselines.load("lm", load_robot("panda"))


@pytest.fixture(scope="module")
def poses(lm: Solver) -> np.ndarray:
    return lm.robot.forward_kinematics(lm.robot.sample(6))


def good_poses(p: np.ndarray) -> dict[str, object]:
    wide = np.zeros((12, 14))
    wide[::2, ::2] = p
    return {
        "list": p.tolist(),
        "tuple": tuple(map(tuple, p)),
        "single precision": p.astype("f4"),
        "strided": wide[::2, ::2],
        "fortran": np.asfortranarray(p),
        "big-endian": p.astype(">f8"),
        "objects": p.astype(object),
        "tensor": torch.tensor(p),
        "other sign": p * [1, 1, 1, -1, -1, -1, -1],
    }


@pytest.mark.parametrize("case", good_poses(np.zeros((6, 7))))
def test_poses_of_any_type_are_solved(lm: Solver, poses: np.ndarray, case: str) -> None:
    lm.solve(poses)
    began = time.perf_counter()
    assert lm.solve(good_poses(poses)[case]).found.all()  # type: ignore[arg-type]
    assert time.perf_counter() - began < 1.0  # nothing was compiled anew


BAD_POSES = {
    "None": None,
    "a number": 3.0,
    "text": [["a"] * 7],
    "ragged": [[1.0] * 7, [1.0] * 6],
    "complex": np.zeros((2, 7), complex),
    "a mapping": {},
    "matrices": np.tile(np.eye(4), (3, 1, 1)),
    "gradient": torch.zeros((1, 7), requires_grad=True),
    "no rotation": np.zeros((1, 7)),
    "twice the unit": [[0, 0, 0, 2, 0, 0, 0]],
    "huge quaternion": [[0, 0, 0, 1e200, 0, 0, 0]],
    "infinite": [[np.inf, 0, 0, 1, 0, 0, 0]],
}


@pytest.mark.parametrize("case", BAD_POSES)
def test_what_is_no_pose_is_named(lm: Solver, case: str) -> None:
    with pytest.raises(PoseError):
        lm.solve(BAD_POSES[case])  # type: ignore[arg-type]


def test_targets_beyond_reach_are_drawn_in_along_their_direction() -> None:
    far = baselines.checks.check_poses([[3e200, 0, -1.5e200, 1, 0, 0, 0], [1, 2, 3, 1, 0, 0, 0]])
    assert np.allclose(far[0, :3], [FARTHEST, 0, -FARTHEST / 2])
    assert far[1, :3].tolist() == [1, 2, 3]


@pytest.mark.parametrize("guess", [0.0, np.zeros(6), np.zeros((3, 7)), ["a"] * 7, [None] * 7, {}])
def test_what_is_no_guess_is_named(lm: Solver, poses: np.ndarray, guess: object) -> None:
    with pytest.raises(InitialError):
        lm.solve(poses, initial=guess)  # type: ignore[arg-type]


def test_guesses_outside_the_limits_are_moved_in(lm: Solver, poses: np.ndarray) -> None:
    for guess in (np.full(7, 50.0), np.full(7, -1e300), [0] * 7):
        assert lm.solve(poses, initial=guess).found.all()


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"time_s": 0},
        {"time_s": float("nan")},
        {"time_s": float("inf")},
        {"time_s": "1"},
        {"time_s": True},
        {"iterations": 0},
        {"iterations": 1.5},
        {"iterations": True},
        {"iterations": "5"},
    ],
)
def test_what_is_no_budget_is_named(wrong: dict[str, object]) -> None:
    with pytest.raises(BudgetError):
        Budget(**wrong)  # type: ignore[arg-type]


def test_budgets_of_any_number_type_and_size(lm: Solver, poses: np.ndarray) -> None:
    for budget in (
        Budget(time_s=np.float32(0.1)),
        Budget(iterations=np.int16(500)),
        Budget(iterations=2**70),
        Budget(time_s=1e30),
    ):
        assert lm.solve(poses, budget=budget).found.all()
    assert type(Budget(time_s=np.float32(1)).time_s) is float


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("lm", {"position_tolerance_m": -1.0}),
        ("lm", {"position_tolerance_m": float("nan")}),
        ("lm", {"damping": -1.0}),
        ("lm", {"damping": 0.0, "damping_gain": 0.0}),
        ("lm", {"threads": -3}),
        ("lm", {"threads": 10**6}),
        ("lm", {"patience": 0}),
        ("bio_ik", {"children": 0}),
        ("bio_ik", {"rotation_weight": 0.0}),
        ("pinocchio", {"rotation_tolerance_rad": 0.0}),
        ("pinocchio", {"damping_gain": float("inf")}),
        ("placo", {"regularization": -1.0}),
        ("pytorch_kinematics", {"retries": 0}),
        ("trac_ik", {"epsilon": -1.0}),
        ("trac_ik", {"solve_type": "Fast"}),
        ("optik", {"solution_mode": "best"}),
        ("roboticstoolbox", {"tolerance": 0.0}),
    ],
)
def test_impossible_settings_are_named(lm: Solver, name: str, wrong: dict[str, object]) -> None:
    if reason := baselines.skip(name, lm.robot):
        pytest.skip(reason)
    with pytest.raises(SettingError):
        baselines.load(name, lm.robot, **wrong)


def test_settings_of_any_number_type_do_not_compile_anew(lm: Solver, poses: np.ndarray) -> None:
    lm.solve(poses)
    began = time.perf_counter()
    for setting in (
        {"position_tolerance_m": np.float64(1e-3)},
        {"position_tolerance_m": np.float32(1e-3)},
        {"position_tolerance_m": 1},
        {"patience": np.int64(4)},
    ):
        assert baselines.load("lm", lm.robot, **setting).solve(poses).found.all()
    assert time.perf_counter() - began < 1.0


@pytest.mark.parametrize("name", [None, 3, b"lm", ["lm"], "LM", "../lm", "lm\0", object()])
def test_what_is_no_name_of_a_solver_is_refused(lm: Solver, name: object) -> None:
    with pytest.raises(UnknownSolverError, match="there is no solver"):
        baselines.load(name, lm.robot)  # type: ignore[arg-type]


@pytest.mark.parametrize("robot", [None, "panda", 3, object()])
def test_what_is_no_robot_is_refused(robot: object) -> None:
    with pytest.raises(SolverError, match=r"'lm': expected a robot, such as load_robot\('panda'\)"):
        baselines.load("lm", robot)  # type: ignore[arg-type]
