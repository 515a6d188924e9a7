"""The header of C beside ours: forward kinematics, network and descent, of robots of all kinds."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import baselines
from pipeline.evaluation.verification import tip_poses
from pipeline.exporting.c_compiler import CompiledHeader, find_compiler
from pipeline.exporting.c_header import comment, example_text, header_text, identifier
from pipeline.exporting.comparison import compare
from pipeline.exporting.source import Source, card_of, load_source
from robots import Robot, available_robots, load_robot, rotations
from tests.exporting import make_source
from tests.small_arms import arm, save

MIXED = Path(__file__).parents[2] / "fixtures" / "mixed.urdf"
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2")
LANGUAGES = {"c99": ("-std=c99",), "c++": ("-std=c++11", "-x", "c++")}

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="there is no compiler of C")


def written(source: Source, folder: Path) -> Path:
    path = folder / "ik.h"
    path.write_text(header_text(source, card_of(source, "a test"), path.name), encoding="utf-8")
    return path


def mixed() -> Robot:
    return load_robot(urdf=MIXED, base="bench", tip="tool")


@needs_compiler
@pytest.mark.parametrize("name", [*available_robots(), "mixed"])
def test_kinematics_and_descent_are_ours(name: str, tmp_path: Path) -> None:
    robot = mixed() if name == "mixed" else load_robot(name)
    source = load_source(robot, None)
    header = CompiledHeader(source, written(source, tmp_path), ("-std=c99", "-O1"))
    joints = robot.sample(400, seed=4, collision_free=False)
    poses = header.forward_kinematics(joints)
    np.testing.assert_allclose(poses, tip_poses(robot, joints), atol=1e-12)
    np.testing.assert_allclose(poses, robot.forward_kinematics(joints), atol=1e-12)
    solver = baselines.load("lm", robot)
    for initial in (None, np.clip(joints + 0.1, robot.lower, robot.upper)):
        answers, found = header.solve(poses, initial)
        ours = solver.solve(poses, initial)
        np.testing.assert_array_equal(found, ours.found)
        assert robot.within_limits(answers, 1e-9).all()
        reached = tip_poses(robot, answers[found])
        away = np.linalg.norm(reached[:, :3] - poses[found, :3], axis=1)
        assert away.max() <= 1.001e-4
        assert rotations.rotation_angle(reached[:, 3:], poses[found, 3:]).max() <= 1.001e-4
        # The same descent but for rounding, which restarts magnify.
        assert (np.abs(answers - ours.joints).max(axis=1) < 1e-6).mean() > 0.97


@needs_compiler
def test_joints_that_turn_for_ever_stay_near_the_guess(tmp_path: Path) -> None:
    robot = mixed()
    assert robot.endless.any()
    source = load_source(robot, None)
    header = CompiledHeader(source, written(source, tmp_path))
    joints = robot.sample(50, seed=2, collision_free=False)
    guess = joints + 6 * np.pi * robot.endless
    answers, found = header.solve(robot.forward_kinematics(joints), guess)
    assert found.all()
    np.testing.assert_allclose(answers[:, robot.endless], guess[:, robot.endless], atol=1e-2)


@needs_compiler
def test_poses_and_guesses_that_are_none_are_refused(tmp_path: Path) -> None:
    robot, bad = load_robot("nico"), (np.nan, np.inf, 1e7)
    source = make_source(robot, "experts", tmp_path)
    header = CompiledHeader(source, written(source, tmp_path), ("-std=c99", "-O0"))
    poses = robot.forward_kinematics(np.tile(robot.home, (5, 1)))
    poses[:3, 1] = bad
    poses[3, 3:] = 0.0
    answers, found = header.solve(poses)
    assert found.tolist() == [False, False, False, False, True]
    np.testing.assert_array_equal(answers[:4], [robot.home] * 4)
    heads = header.network(poses)[1]
    assert (heads[:4] == -1).all()
    assert heads[4] >= 0
    guesses = np.tile(robot.home, (3, 1))
    guesses[:, 2] = bad
    assert not header.solve(poses[[4] * 3], guesses)[1].any()


@needs_compiler
@pytest.mark.parametrize(
    ("kind", "name", "near"), [("experts", "panda", 1e-7), ("mlp", "mixed", 1e-5)]
)
def test_the_network_answers_as_ours(kind: str, name: str, near: float, tmp_path: Path) -> None:
    robot = mixed() if name == "mixed" else load_robot(name)
    source = make_source(robot, kind, tmp_path)
    header = CompiledHeader(source, written(source, tmp_path), ("-std=c99", "-O1"))
    poses = robot.forward_kinematics(robot.sample(1000, seed=3, collision_free=False))
    joints, heads = header.network(poses)
    found = compare(source, poses, joints, tie=1e-6)
    assert found.largest < 1e-12
    assert found.other == 0
    assert found.solver_largest < near
    assert found.from_solver < near
    assert found.solver_other < 5
    assert len(set(heads.tolist())) == source.network.heads
    assert header.solve(poses[:50])[1].all()


@needs_compiler
def test_a_single_expert_is_one_too(tmp_path: Path) -> None:
    source = make_source(load_robot("nico"), "expert", tmp_path)
    header = CompiledHeader(source, written(source, tmp_path), ("-std=c99", "-O0"))
    poses = source.robot.forward_kinematics(source.robot.sample(20, seed=3))
    assert compare(source, poses, header.network(poses)[0], tie=1e-6).largest < 1e-12


@needs_compiler
@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("kind", ["experts", "mlp", "none"])
def test_it_compiles_without_a_warning_and_its_program_runs(
    language: str, kind: str, tmp_path: Path
) -> None:
    if language == "c++" and shutil.which("g++") is None:
        pytest.skip("there is no compiler of C++")
    robot = mixed()
    source = load_source(robot, None) if kind == "none" else make_source(robot, kind, tmp_path)
    path = written(source, tmp_path)
    program, binary = tmp_path / "main.c", tmp_path / "main"
    program.write_text(example_text(source, path.name, program.name), encoding="utf-8")
    compiler = "g++" if language == "c++" else find_compiler()
    command = [compiler, *LANGUAGES[language], *STRICT, program, "-o", binary, "-lm"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    ran = subprocess.run([str(binary), "50"], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stdout
    assert "50 of 50 found" in ran.stdout
    assert ("network:" in ran.stdout) == (kind != "none")
    assert subprocess.run([str(binary), "-1"], capture_output=True).returncode == 2


@needs_compiler
def test_names_may_be_any(tmp_path: Path) -> None:
    text = arm(3, head="<robot name='7 évil*/ ro-bot??/'>")
    robot = load_robot(urdf=save(tmp_path, text.replace("j2", "j*/ ??/ 2")))
    source = load_source(robot, None)
    flags = ("-std=c99", *STRICT)
    header = CompiledHeader(source, written(source, tmp_path), flags)
    joints = robot.sample(5, seed=0, collision_free=False)
    np.testing.assert_allclose(
        header.forward_kinematics(joints), robot.forward_kinematics(joints), atol=1e-12
    )


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("panda", "panda"),
        ("UR-10 e", "ur_10_e"),
        ("7dof", "robot_7dof"),
        ("été", "t"),
        ("!", "robot"),
    ],
)
def test_a_name_becomes_an_identifier(name: str, wanted: str) -> None:
    assert identifier(name) == wanted


def test_a_comment_ends_where_it_should() -> None:
    assert comment("a */ b\n/* ??/") == "a * / b / * ? ?/"
