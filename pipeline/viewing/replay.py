"""The page of a grasp trial: the robot, the table, the objects and a panel to play it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.presentation.naming import robot_title
from pipeline.viewing.bodies import Part, floor_height, parts_of, parts_of_shapes, single_links
from pipeline.viewing.clip import Player
from pipeline.viewing.config import ViewConfig
from pipeline.viewing.inbox import Inbox
from pipeline.viewing.loop import run_until_interrupted
from pipeline.viewing.recording import Frame, Recording
from pipeline.viewing.scene import RobotDrawing
from pipeline.viewing.server import announce, serve, set_stage, stop
from pipeline.viewing.table import sentence_html
from robots.bodies import link_poses
from robots.rotations import matrix_from_quaternion

if TYPE_CHECKING:
    from pipeline.grasping.config import CameraConfig
    from robots import Robot

Array = NDArray[np.float64]
SLIDING_S = 0.4  # after the slider was moved, in which it is the user's
STEP_S = 0.01  # of the slider
SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")


class Replay:
    """A grasp trial in a browser, while it is simulated and over and over afterwards.

    Attributes:
        server: `viser.ViserServer`.
        inbox: What the user wants done.
        player: Where in the trial we are.
    """

    def __init__(self, robot: Robot, config: ViewConfig, title: str, camera: CameraConfig) -> None:
        """Serve the robot at home at an empty place; frames come later.

        Args:
            robot: The robot; its base carries its whole body.
            config: Where the page is.
            title: What is shown.
            camera: Of the trial's films, from where it is seen.

        Raises:
            ViewError: viser is missing, or the port is taken.
        """
        self.robot, self._config = robot, config
        self.inbox, self.player = Inbox(), Player(self._play)
        self._recording = Recording()
        self._outcome, self._slid = "", 0.0
        self._bodies: RobotDrawing | None = None
        self.server: Any = serve(config, f"{robot_title(robot.name)}, {title}")
        try:
            parts = parts_of(robot, "visual", single_links(robot))
            home = robot.link_poses(robot.home)
            set_stage(self.server, robot, floor_height(parts, home), camera)
            self._drawing = RobotDrawing(self.server.scene, "/robot", parts)
            self._drawing.pose(home)
            self._rest = robot.positions(robot.home)
            self._sentence = self.server.gui.add_html(sentence_html("starting the simulation"))
            self._slider: Any = None
        except BaseException:
            self.close()
            raise

    def show(self, recording: Recording, frame: Frame) -> None:
        """Draw a frame of a trial that is being simulated."""
        self._draw(recording, frame)
        self._sentence.content = sentence_html(f"simulating: {frame.time:.1f} s")

    def play(self, recording: Recording, outcome: str) -> None:
        """Play a recording over and over.

        Args:
            recording: At least two frames.
            outcome: A sentence about how it went.
        """
        self._recording, self._outcome = recording, outcome
        self._add_controls(recording.duration)
        self.player.load(recording.duration)

    def run(self) -> None:
        """Go on until Ctrl-C."""
        run_until_interrupted(self.inbox, self.player, self._config.rate, self._say)

    def announce(self) -> None:
        """Say where the page is."""
        announce(self.server, self._config)

    def close(self) -> None:
        """Stop serving."""
        stop(self.server)

    def _add_controls(self, duration: float) -> None:
        gui, player = self.server.gui, self.player
        self._slider = gui.add_slider("Time [s]", 0.0, round(duration, 2), STEP_S, 0.0)
        running = gui.add_checkbox("Running", True)
        speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1")

        def seek() -> None:
            running.value = False
            player.seek(self._slider.value / duration)

        def moved(event: Any) -> None:
            if event.client is not None:  # not one of our own
                self._slid = time.monotonic()
                self.inbox.post("seek", seek)

        self._slider.on_update(moved)

        def change() -> None:
            player.speed, player.playing = float(speed.value), running.value

        for handle in (running, speed):
            handle.on_update(lambda event: self.inbox.post("speed", change))

    def _play(self) -> None:
        if not self._recording.frames:
            return
        now = self.player.time
        self._draw(self._recording, self._recording.at(now))
        phase = self._recording.phase(now)
        self._say(f"{self._outcome} · {now:.1f} s {phase}")
        if time.monotonic() - self._slid > SLIDING_S:
            self._slider.value = min(round(now, 2), self._slider.max)

    def _draw(self, recording: Recording, frame: Frame) -> None:
        with self.server.atomic():
            if self._bodies is None:
                self._bodies = RobotDrawing(self.server.scene, "/things", _parts(recording))
            self._drawing.pose(link_poses(self.robot.urdf, {**self._rest, **frame.joints}))
            self._bodies.pose({str(k): _matrix(pose) for k, pose in enumerate(frame.bodies)})

    def _say(self, sentence: str) -> None:
        self._sentence.content = sentence_html(sentence)


def _parts(recording: Recording) -> list[Part]:
    """The bodies besides the robot, each under its number."""
    return [
        part
        for number, shapes in enumerate(recording.shapes)
        for part in parts_of_shapes(str(number), shapes)
    ]


def _matrix(pose: Array) -> Array:
    """A pose (7,) as a matrix (4, 4)."""
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = matrix_from_quaternion(pose[3:]), pose[:3]
    return matrix
