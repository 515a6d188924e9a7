"""The robots, the target and the path of a session, drawn by viser."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from baselines.transforms import pose_matrix
from pipeline.presentation.style import looks
from pipeline.viewing.bodies import Colour, Part, floor_height, inset, moving_links, parts_of
from pipeline.viewing.inbox import Inbox
from pipeline.viewing.server import set_stage
from pipeline.viewing.session import Session, Snapshot
from robots.rotations import normalised, quaternion_from_matrix

Array = NDArray[np.float64]
RED: Colour = (214, 39, 40)
COLLISION: Colour = (86, 120, 160)
COLLISION_OPACITY = 0.3
GIZMO_M = 0.16
INSET_M = 5e-4  # of each ghost in the one before
STILL = 1e-7  # change of a pose's numbers, 1 and m, below which it is not sent
PATH_COLOUR: Colour = (31, 41, 51)
PATH_WIDTH = 3.0  # pixels


class RobotDrawing:
    """A robot made of parts, posed by its links.

    Attributes:
        root: Node that carries all of it; `visible` of it hides the robot.
    """

    def __init__(
        self,
        scene: Any,
        name: str,
        parts: Iterable[Part],
        colour: Colour | None = None,
        opacity: float | None = None,
        visible: bool = True,
    ) -> None:
        """Send the parts once; afterwards only poses are sent.

        Args:
            scene: `viser.SceneApi`.
            name: Path of its node.
            parts: What it is made of.
            colour: Of all parts; their own where it is None.
            opacity: Of all parts; None is solid.
            visible: Whether it is to be seen at first.
        """
        self.root = scene.add_frame(name, show_axes=False, visible=visible)
        self._parts: dict[str, list[Any]] = {}
        self._poses: dict[str, Array] = {}
        for number, part in enumerate(parts):
            mesh = scene.add_mesh_simple(
                f"{name}/{number}",
                part.vertices.astype(np.float32),
                part.faces,
                color=part.colour if colour is None else colour,
                opacity=opacity,
                cast_shadow=opacity is None,
                receive_shadow=opacity is None,
            )
            self._parts.setdefault(part.link, []).append(mesh)

    def pose(self, links: Mapping[str, Array]) -> None:
        """Move the parts to poses (4, 4) of links in the root's frame; what stays is not sent."""
        for link, meshes in self._parts.items():
            pose = links[link]
            if link in self._poses and np.abs(pose - self._poses[link]).max() < STILL:
                continue
            self._poses[link] = pose
            turn = quaternion_from_matrix(pose[:3, :3])
            for mesh in meshes:
                mesh.wxyz, mesh.position = turn, pose[:3, 3]

    def show_only(self, links: Iterable[str]) -> None:
        """Let only the parts of some links be seen."""
        wanted = set(links)
        for link, meshes in self._parts.items():
            for mesh in meshes:
                if mesh.visible != (link in wanted):
                    mesh.visible = link in wanted


class SessionScene:
    """What a session shows, in 3D.

    Attributes:
        wanted: Which solvers' answers the user wants to see.
    """

    def __init__(self, server: Any, session: Session, inbox: Inbox, opacity: float) -> None:
        """Draw robot, ghosts and target, and let the target be dragged.

        Args:
            server: `viser.ViserServer`.
            session: What is shown.
            inbox: Receives the target that is dragged.
            opacity: Of ghosts.
        """
        robot = self._robot = session.robot
        self._server, self._main = server, session.main
        self._carriers = moving_links(robot)
        parts = parts_of(robot, "visual", self._carriers)
        home = robot.link_poses(robot.home)
        set_stage(server, robot, floor_height(parts, home))
        self._base: Array = home[robot.base]
        self._to_base = np.linalg.inv(self._base)
        self._solid = RobotDrawing(server.scene, "/robot", parts)
        self.wanted = dict.fromkeys(session.comparison.solvers, True)
        plain = parts_of(robot, "visual", self._carriers, one_colour=True)
        still = self._carriers[robot.urdf.root][0]
        moving = [part for part in plain if part.link != still]
        self._ghosts = {
            name: RobotDrawing(
                server.scene,
                f"/ghosts/{name}",
                [inset(part, (number + 1) * INSET_M) for part in moving],
                colour,
                opacity,
            )
            for number, (name, colour) in enumerate(colours(self.wanted).items())
            if name != self._main
        }
        self._collisions: RobotDrawing | None = None
        self._red: RobotDrawing | None = None
        self._path: Any = None
        self._drawn_path = session.snapshot.path
        self._add_target(session, inbox)

    def show(self, snapshot: Snapshot) -> None:
        """Draw what is to be seen now."""
        links = self._robot.link_poses(snapshot.joints)
        self._solid.pose(links)
        if self._collisions is not None and self._collisions.root.visible:
            self._collisions.pose(links)
        self._redden(snapshot.colliding, links)
        for name, ghost in self._ghosts.items():
            visible = snapshot.ghosts and self.wanted[name]
            if ghost.root.visible != visible:
                ghost.root.visible = visible
            if visible:
                ghost.pose(self._robot.link_poses(snapshot.answers[name].joints))
        self._move_target(snapshot.target)
        self._draw_path(snapshot)

    def show_collisions(self, wanted: bool) -> None:
        """Show or hide the collision shapes of the solid robot."""
        if self._collisions is None and wanted:
            parts = parts_of(self._robot, "collision", self._carriers, one_colour=True)
            self._collisions = RobotDrawing(
                self._server.scene, "/collision", parts, COLLISION, COLLISION_OPACITY
            )
        if self._collisions is not None:
            self._collisions.root.visible = wanted

    def _redden(self, colliding: frozenset[str], links: Mapping[str, Array]) -> None:
        """Draw the collision shapes of links that touch in red."""
        if self._red is None:
            if not colliding:
                return
            each = {link: (link, np.eye(4)) for link in links}
            parts = parts_of(self._robot, "collision", each, one_colour=True)
            self._red = RobotDrawing(self._server.scene, "/colliding", parts, RED, 0.75)
        self._red.show_only(colliding)
        self._red.pose(links)

    def _add_target(self, session: Session, inbox: Inbox) -> None:
        self._gizmo = self._server.scene.add_transform_controls(
            "/target", scale=GIZMO_M, line_width=3.0, depth_test=False
        )
        self._held = False

        def dragged(event: Any) -> None:
            if event.client is not None:  # not one of our own
                pose = self._in_base(self._gizmo.position, self._gizmo.wxyz)
                inbox.post("target", lambda: session.move_target(pose))

        self._gizmo.on_update(dragged)

        def held(event: Any) -> None:
            self._held = True

        self._gizmo.on_drag_start(held)

        def released(event: Any) -> None:
            self._held = False

        self._gizmo.on_drag_end(released)

    def _in_base(self, position: Array, turn: Array) -> Array:
        """A pose of the page's world in the robot's base frame, shape (7,)."""
        pose = self._to_base @ pose_matrix(np.concatenate([position, normalised(turn)]))
        return np.concatenate([pose[:3, 3], quaternion_from_matrix(pose[:3, :3])])

    def _move_target(self, target: Array) -> None:
        """Put the gizmo where the target is, unless somebody holds it."""
        if self._held:
            return
        pose = self._base @ pose_matrix(target)
        self._gizmo.position = pose[:3, 3]
        self._gizmo.wxyz = quaternion_from_matrix(pose[:3, :3])

    def _draw_path(self, snapshot: Snapshot) -> None:
        if snapshot.path is self._drawn_path:
            return
        if self._path is not None:
            self._path.remove()
            self._path = None
        if len(snapshot.path):
            points = snapshot.path @ self._base[:3, :3].T + self._base[:3, 3]
            self._path = self._server.scene.add_line_segments(
                "/path",
                np.stack([points[:-1], points[1:]], axis=1).astype(np.float32),
                colors=PATH_COLOUR,
                line_width=PATH_WIDTH,
            )
        self._drawn_path = snapshot.path


def colours(solvers: Iterable[str]) -> dict[str, Colour]:
    """Red, green and blue of each solver, as in the figures."""
    return {name: rgb(look.colour) for name, look in looks(solvers).items()}


def rgb(colour: str) -> Colour:
    """Red, green and blue, 0 to 255, of a colour such as ``#0b3c5d``."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue
