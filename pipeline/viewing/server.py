"""The server of the page, viser on a port of its own; camera, light and floor of all scenes."""

from __future__ import annotations

import io
import socket
import webbrowser
from contextlib import redirect_stdout
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.packages import optional_package
from pipeline.viewing.config import ViewConfig
from pipeline.viewing.errors import ViewError
from robots.viewpoints import FIELD_OF_VIEW_DEG, Picture
from robots.views import default_view

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
SETTING = "the live view"
FARTHER = 1.05  # than pictures of robots, which are square
MARGIN_M = 0.002  # of the floor below the robot, so that they do not flicker
CELL_M, SECTION_M = 0.25, 1.0
BRAND = (11, 60, 93)


def serve(config: ViewConfig, title: str) -> Any:
    """Start a server.

    Args:
        config: Where it listens.
        title: Of the page.

    Returns:
        A `viser.ViserServer`; whoever starts it stops it.

    Raises:
        ViewError: viser is missing, or something else listens there.
    """
    viser = optional_package(SETTING, ViewError)
    _check_free(config.host, config.port)
    with redirect_stdout(io.StringIO()):  # what it prints is for its own users
        server = viser.ViserServer(host=config.host, port=config.port, label=title, verbose=False)
    server.gui.configure_theme(
        control_layout="fixed", control_width="large", show_logo=False, brand_color=BRAND
    )
    return server


def address(server: Any, config: ViewConfig) -> str:
    """Where a browser finds the page."""
    host = "localhost" if config.host in ("0.0.0.0", "127.0.0.1") else config.host
    return f"http://{host}:{server.get_port()}"


def stop(server: Any) -> None:
    """Stop serving, without the library's words about it."""
    with redirect_stdout(io.StringIO()):
        server.stop()


def announce(server: Any, config: ViewConfig) -> None:
    """Say where the page is, and open the browser where that is wanted."""
    where = address(server, config)
    print(f"{where} shows it; Ctrl-C ends.", flush=True)
    if config.open:
        webbrowser.open(where)


def set_stage(server: Any, robot: Robot, floor: float, picture: Picture | None = None) -> None:
    """Light, a floor with a grid, and a camera that has the robot in the picture.

    Args:
        server: Of the page.
        robot: The robot; the world is its root's frame.
        floor: Height of the floor [m].
        picture: From where it is seen; None is as in the robot's own picture.
    """
    scene = server.scene
    scene.set_up_direction("+z")
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(255, 255, 255), ground_color=(170, 165, 160), intensity=2.2
    )
    scene.add_light_directional(
        "/light/sun",
        color=(255, 250, 240),
        intensity=2.0,
        cast_shadow=True,
        position=(1.2, -1.6, 2.6),
    )
    scene.add_grid(
        "/floor",
        width=4.0,
        height=4.0,
        cell_size=CELL_M,
        section_size=SECTION_M,
        cell_color=(225, 228, 232),
        section_color=(190, 196, 204),
        shadow_opacity=0.2,
        plane_color=(247, 248, 250),
        plane_opacity=1.0,
        position=(0.0, 0.0, floor - MARGIN_M),
    )
    picture = picture or robot.description.picture or default_view(robot, robot.home)
    camera = server.initial_camera
    camera.up = (0.0, 0.0, 1.0)
    camera.fov = float(np.deg2rad(FIELD_OF_VIEW_DEG))
    camera.look_at = tuple(picture.target)
    camera.position = tuple(eye(picture, FARTHER))


def eye(picture: Picture, farther: float = 1.0) -> Array:
    """Where the camera of a picture stands, root's frame [m], shape (3,).

    Yaw turns it about the vertical from the y axis, as PyBullet counts.

    Args:
        picture: Target, distance and angles.
        farther: Factor on its distance.
    """
    yaw, pitch = np.deg2rad([picture.yaw, picture.pitch])
    sight = np.array([-np.sin(yaw) * np.cos(pitch), np.cos(yaw) * np.cos(pitch), np.sin(pitch)])
    place: Array = picture.target - farther * picture.distance * sight
    return place


def _check_free(host: str, port: int) -> None:
    """Refuse a port that is taken: viser would silently take the next one."""
    if port == 0:
        return
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as problem:
            raise ViewError(
                f"view.port={port} of {host} cannot be listened at ({problem.strerror}); name "
                "another one, or 0 for any free one"
            ) from problem
