"""The page of a grasp trial: the robot, the table, the objects and a panel to play it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np

from baselines.transforms import pose_matrix
from pipeline.grasping.video import FIELD_OF_VIEW
from pipeline.presentation.naming import robot_title
from pipeline.viewing.bodies import Part, floor_height, parts_of, parts_of_shapes, single_links
from pipeline.viewing.clip import Player
from pipeline.viewing.config import ViewConfig
from pipeline.viewing.inbox import Inbox
from pipeline.viewing.loop import run_until_interrupted
from pipeline.viewing.playback import SLIDING_S, Playback
from pipeline.viewing.recording import Frame, Recording
from pipeline.viewing.scene import RobotDrawing
from pipeline.viewing.server import announce, serve, set_stage, stop
from pipeline.viewing.table import sentence_html
from robots.bodies import link_poses
from robots.viewpoints import FIELD_OF_VIEW_DEG, Picture

if TYPE_CHECKING:
    from pipeline.grasping.config import CameraConfig
    from robots import Robot

STEP_S = 0.01  # of the slider


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
            set_stage(self.server, robot, floor_height(parts, home), _picture_of(camera))
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
        self._playback = Playback(gui, player, self.inbox)

        def seek() -> None:
            player.seek(self._slider.value / duration)

        def moved(event: Any) -> None:
            if event.client is not None:  # not one of our own
                self._slid = time.monotonic()
                self.inbox.post("seek", seek)

        self._slider.on_update(moved)

    def _play(self) -> None:
        if not self._recording.frames:
            return
        now = self.player.time
        self._draw(self._recording, self._recording.at(now))
        phase = self._recording.phase(now)
        self._say(f"{self._outcome} · {now:.1f} s {phase}")
        self._playback.show()
        if time.monotonic() - self._slid > SLIDING_S:
            self._slider.value = min(round(now, 2), self._slider.max)

    def _draw(self, recording: Recording, frame: Frame) -> None:
        with self.server.atomic():
            if self._bodies is None:
                self._bodies = RobotDrawing(self.server.scene, "/things", _parts(recording))
            self._drawing.pose(link_poses(self.robot.urdf, {**self._rest, **frame.joints}))
            self._bodies.pose({str(k): pose_matrix(pose) for k, pose in enumerate(frame.bodies)})

    def _say(self, sentence: str) -> None:
        self._sentence.content = sentence_html(sentence)


def _parts(recording: Recording) -> list[Part]:
    """The bodies besides the robot, each under its number."""
    return [
        part
        for number, shapes in enumerate(recording.shapes)
        for part in parts_of_shapes(str(number), shapes)
    ]


def _picture_of(camera: CameraConfig) -> Picture:
    """The view of a trial's films from as much farther away as a picture's angle is narrower."""
    farther = FIELD_OF_VIEW / FIELD_OF_VIEW_DEG
    return Picture(np.array(camera.target), farther * camera.distance, camera.yaw, camera.pitch, 0)
