"""A session without a browser: targets, joints, motions, and what is shown of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.loading import load_solver
from pipeline.viewing.comparison import Comparison, colliding_links
from pipeline.viewing.inbox import Inbox
from pipeline.viewing.loop import turn
from pipeline.viewing.session import Session, Snapshot
from pipeline.viewing.table import answers_html, sentence_html
from robots import Robot, load_robot

CONFIG = compose([])


class Scripted:
    """A solver that answers what it is told."""

    def __init__(self, *answers: Any) -> None:
        self.answers, self.guesses = list(answers), []

    def solve_one(self, pose: Any, initial: Any = None) -> tuple[Any, bool]:
        self.guesses.append(initial.copy())
        return self.answers[min(len(self.guesses), len(self.answers)) - 1], True


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("panda")


@pytest.fixture
def session(robot: Robot) -> Session:
    solvers = {name: load_solver(name, robot) for name in ("lm", "cycleik")}
    return Session(Comparison(robot, solvers, 5), "lm", CONFIG.plan, 0.05)


def test_errors_and_jumps_are_those_of_the_answers(robot: Robot) -> None:
    off = robot.home.copy()
    off[1] += 0.1
    solver = Scripted(robot.home, robot.home, off)
    comparison = Comparison(robot, {"scripted": solver}, 3)  # type: ignore[dict-item]
    target = robot.forward_kinematics(robot.home)[0]
    first = comparison.answers(target)["scripted"]
    assert (first.position_mm, first.rotation_deg, first.jump) == pytest.approx((0, 0, 0), abs=1e-4)
    second = comparison.answers(target)["scripted"]
    reached = robot.forward_kinematics(off)[0]
    assert second.position_mm == pytest.approx(1e3 * np.linalg.norm(reached[:3] - target[:3]))
    assert second.rotation_deg == pytest.approx(np.rad2deg(0.1))  # of the one joint that turned
    assert second.jump == pytest.approx(0.1)
    comparison.answers(target)
    assert (solver.guesses[-1] == off).all()
    comparison.restart(robot.home)
    assert comparison.answers(target)["scripted"].jump == pytest.approx(0.1)


def test_links_that_touch_are_those_of_the_collision_checker(robot: Robot) -> None:
    joints = robot.sample(60, seed=0, collision_free=False)
    for q, collides in zip(joints, robot.in_collision(joints), strict=True):
        links = colliding_links(robot, q)
        assert bool(links) == collides
        assert links <= set(robot.urdf.links)
    assert robot.in_collision(joints).any()


def test_a_moved_target_is_answered_by_all_and_joints_take_the_target_along(
    session: Session, robot: Robot
) -> None:
    shown: list[Snapshot] = []
    session.show = shown.append
    target = robot.forward_kinematics(robot.sample(1, seed=2))[0]
    before = session.snapshot
    session.move_target(target)
    after = session.snapshot
    assert (after.joints == after.answers["lm"].joints).all()
    assert (after.joints != before.joints).any()
    assert after.answers["lm"].position_mm < 0.1
    assert 0.1 < after.answers["cycleik"].position_mm < 30.0
    assert all(each.call_us > 0.0 for each in after.answers.values())
    joints = robot.sample(1, seed=5)[0]
    session.move_joints(joints)
    assert session.snapshot.target == pytest.approx(robot.forward_kinematics(joints)[0])
    assert (session.snapshot.joints == joints).all()
    assert shown == [after, session.snapshot]
    session.home()
    assert (session.snapshot.joints == robot.home).all()
    random = []
    for _ in range(2):
        session.random_target(False)
        random.append(session.snapshot.target)
    assert np.linalg.norm(random[0][:3] - random[1][:3]) > 1e-3


def test_the_null_space_plays_until_the_target_moves(session: Session) -> None:
    session.random_target(True)
    target = session.snapshot.target
    session.play_null_space()
    seen = []
    session.show = seen.append
    for _ in range(10):
        session.player.advance(session.player.duration / 11)
    poses = session.robot.forward_kinematics(np.array([each.joints for each in seen]))
    assert np.abs(poses[:, :3] - target[:3]).max() < 1e-3
    assert np.ptp([each.joints for each in seen], axis=0).max() > 0.1
    assert {each.clip for each in seen} == {"null space"}
    session.move_target(target)
    session.player.advance(1.0)
    assert len(seen) == 11
    assert session.snapshot.clip == ""
    assert len(session.snapshot.path) == 0


def test_a_motion_goes_from_the_start_to_the_target(session: Session, robot: Robot) -> None:
    start = robot.sample(1, seed=11)[0]
    session.move_joints(start)
    session.take_start()
    session.random_target(True)
    goal = session.snapshot.target
    session.plan_to_target()
    assert "waypoints found" in session.snapshot.message
    assert len(session.snapshot.path) == CONFIG.plan.motion.steps
    ends = []
    for share in (0.0, 1.0):
        session.player.seek(share)
        ends.append(robot.forward_kinematics(session.snapshot.joints)[0, :3])
    assert ends[0] == pytest.approx(robot.forward_kinematics(start)[0, :3], abs=1e-3)
    assert ends[1] == pytest.approx(goal[:3], abs=1e-3)


def test_what_cannot_be_done_is_said_and_the_page_goes_on() -> None:
    robot = load_robot("nico")
    session = Session(
        Comparison(robot, {"lm": load_solver("lm", robot)}, 3), "lm", CONFIG.plan, 0.05
    )
    inbox, done = Inbox(), []
    inbox.post("null", session.play_null_space)
    inbox.post("next", lambda: done.append(1))
    turn(inbox, session.player, 0.01, session.say)
    assert "no null space here" in session.snapshot.message
    assert done == [1]


def test_the_table_has_a_row_a_solver_in_the_colours_of_the_figures(session: Session) -> None:
    html = answers_html(session.snapshot.answers, "lm")
    assert html.count("<tr") == 3
    assert html.index("CycleIK") < html.index("LM, compiled")
    assert html.count("font-weight:bold") == 1
    assert "#0b3c5d" in html
    assert "&lt;b&gt;" in sentence_html("<b>")
