"""The page without a browser: served, drawn, following its session; ports and shapes."""

from __future__ import annotations

import socket
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import pytest

from baselines.errors import UnknownSolverError
from pipeline.commands.view import KEYS, ready_solvers, with_group
from pipeline.config import compose
from pipeline.learning.card import WeightsError
from pipeline.loading import load_solver
from pipeline.viewing.comparison import Comparison
from pipeline.viewing.errors import ViewError
from pipeline.viewing.server import eye, serve
from pipeline.viewing.session import Session
from robots import load_robot
from robots.viewpoints import Picture

CONFIG = compose(["view.port=0", "view.open=false"])
FIXTURE = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


def test_keys_of_the_group_need_no_prefix() -> None:
    typed = ["robot=nicol", "solver=lm", "port=0", "open=false", "view.rate=10", "film=a.mp4"]
    config = compose(with_group(typed))
    assert (config.view.solver, config.view.port, config.view.open) == ("lm", 0, False)
    assert (config.robot.name, config.view.rate, config.view.film) == ("nicol", 10.0, "a.mp4")
    assert not set(KEYS) & {"robot", "profile", "seed", "results_dir", "grasp", "plan"}


def test_solvers_that_cannot_run_are_left_out_and_unknown_ones_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    robot = load_robot(urdf=FIXTURE, base="base", tip="tip")  # no network is trained for it
    config = compose(["view.solver=cycleik_refined", "view.solvers=[lm]"])
    assert list(ready_solvers(config, robot)) == ["lm"]
    assert "left out: there are no trained weights" in capsys.readouterr().out
    with pytest.raises(UnknownSolverError, match="lmm"):
        ready_solvers(compose(["view.solver=lmm"]), robot)
    with pytest.raises(WeightsError):
        ready_solvers(compose(["view.solvers=[cycleik]"]), robot)


def test_the_camera_of_a_picture_stands_where_pybullets_does() -> None:
    import pybullet

    picture = Picture(np.array([0.3, -0.1, 0.7]), 2.0, 40.0, -20.0, 0)
    view = pybullet.computeViewMatrixFromYawPitchRoll(picture.target.tolist(), 2.0, 40, -20, 0, 2)
    matrix = np.reshape(view, (4, 4)).T
    assert eye(picture) == pytest.approx(-matrix[:3, :3].T @ matrix[:3, 3], abs=1e-6)


def test_without_viser_a_sentence_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(ViewError, match=r"live view needs the package viser.*\[view\]"):
        serve(CONFIG.view, "")


def test_a_port_that_is_taken_is_a_sentence() -> None:
    pytest.importorskip("viser")
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        with pytest.raises(ViewError, match=f"view.port={port}.*name another one"):
            serve(replace(CONFIG.view, port=port), "")


@pytest.fixture(scope="module")
def page() -> Iterator[tuple[object, Session]]:
    pytest.importorskip("viser")
    from pipeline.viewing.page import Page

    robot = load_robot("panda")
    solvers = {name: load_solver(name, robot) for name in ("lm", "cycleik")}
    session = Session(Comparison(robot, solvers, 5), "lm", CONFIG.plan, 0.05)
    shown = Page(session, CONFIG.view, [], False)
    yield shown, session
    shown.close()


def test_a_page_is_served_and_follows_the_session(page: tuple[object, Session]) -> None:
    from pipeline.viewing.server import address

    shown, session = page
    with urlopen(address(shown.server, CONFIG.view)) as answer:  # type: ignore[attr-defined]
        assert answer.status == 200
        assert b"<html" in answer.read()
    before = shown._panel._table.content  # type: ignore[attr-defined]
    target = session.snapshot.target.copy()
    target[2] -= 0.1
    session.move_target(target)
    assert shown._panel._table.content != before  # type: ignore[attr-defined]
    assert shown._scene._gizmo.position == pytest.approx(target[:3])  # type: ignore[attr-defined]
    sliders = [slider.value for slider in shown._panel._sliders]  # type: ignore[attr-defined]
    assert sliders == pytest.approx(session.snapshot.joints, abs=1e-3)


def test_what_begins_runs_and_its_checkbox_says_so(page: tuple[object, Session]) -> None:
    shown, session = page
    running = shown._panel._playback._running  # type: ignore[attr-defined]
    running.value = False
    session.play_null_space()
    assert session.player.playing
    assert running.value
    session.player.seek(0.5)
    assert not running.value
    session.home()


def test_the_drawing_stands_where_the_robots_links_do(page: tuple[object, Session]) -> None:
    shown, session = page
    session.move_joints(session.robot.sample(1, seed=4)[0])
    links = session.robot.link_poses(session.snapshot.joints)
    parts = shown._scene._solid._parts  # type: ignore[attr-defined]
    assert len(parts) > 5
    for link, meshes in parts.items():
        for mesh in meshes:
            assert mesh.position == pytest.approx(links[link][:3, 3])


def test_links_that_touch_are_red_and_collision_shapes_can_be_seen(
    page: tuple[object, Session],
) -> None:
    shown, session = page
    robot = session.robot
    joints = robot.sample(60, seed=0, collision_free=False)
    session.move_joints(joints[np.argmax(robot.in_collision(joints))])
    red = shown._scene._red._parts  # type: ignore[attr-defined]
    seen = {link for link, meshes in red.items() for mesh in meshes if mesh.visible}
    assert seen == session.snapshot.colliding
    assert seen
    session.home()
    assert not any(mesh.visible for meshes in red.values() for mesh in meshes)
    shown._scene.show_collisions(True)  # type: ignore[attr-defined]
    shown.show(session.snapshot)  # type: ignore[attr-defined]
    assert shown._scene._collisions.root.visible  # type: ignore[attr-defined]


def test_triangles_of_a_robot_are_its_shapes_gathered_by_what_moves() -> None:
    pytest.importorskip("trimesh")
    from pipeline.viewing.bodies import floor_height, moving_links, parts_of, single_links

    robot = load_robot(urdf=FIXTURE, base="base", tip="tip")
    for carriers in (moving_links(robot), single_links(robot)):
        parts = parts_of(robot, "visual", carriers)
        poses = robot.link_poses(robot.home)
        assert floor_height(parts, poses) == pytest.approx(-0.2)  # of the post, 0.4 m long
        places = np.vstack(
            [part.vertices @ poses[part.link][:3, :3].T + poses[part.link][:3, 3] for part in parts]
        )
        assert places[:, 0].min() == pytest.approx(-0.55, abs=1e-3)  # the post's far side
    joints = np.array([0.4, -0.7])
    anchors, poses = moving_links(robot), robot.link_poses(joints)
    for link, (anchor, pose) in anchors.items():
        assert poses[anchor] @ pose == pytest.approx(poses[link])
    assert len({anchor for anchor, _ in anchors.values()}) == 3


def test_a_part_shrinks_along_its_normals() -> None:
    pytest.importorskip("trimesh")
    from pipeline.viewing.bodies import inset, parts_of_shapes
    from robots.urdf import Shape

    middle = np.eye(4)
    middle[:3, 3] = [1.0, 2.0, 3.0]
    (ball,) = parts_of_shapes("ball", [Shape("sphere", (0.5,), middle)])
    radius = np.linalg.norm(inset(ball, 0.1).vertices - middle[:3, 3], axis=1)
    assert radius == pytest.approx(0.4, abs=2e-3)
    (box,) = parts_of_shapes("box", [Shape("box", (0.2, 0.4, 0.6), np.eye(4))])
    assert np.abs(inset(box, 0.01).vertices).max(axis=0) == pytest.approx([0.1, 0.2, 0.3])
    sides = np.abs(np.abs(inset(box, 0.01).vertices) - [0.09, 0.19, 0.29]) < 1e-9
    assert (sides.sum(axis=1) == 1).all()  # each side moves by itself: its corners were split
