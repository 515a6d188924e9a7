"""Films of trials: MP4 and GIF, and a sheet with a still of every phase.

Frames come from the software renderer: no display, no graphics card.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pybullet
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw, ImageFont

from pipeline.data.files import replacing
from pipeline.grasping.config import CameraConfig, VideoConfig
from pipeline.grasping.encoder import MP4, encode, gif

if TYPE_CHECKING:
    from pipeline.grasping.scene import Scene

Frame = NDArray[np.uint8]
FIELD_OF_VIEW = 45.0  # deg
NEAR, FAR = 0.05, 5.0  # m
SKY = ((205, 216, 226), (246, 248, 250))  # behind everything: colour at the top and at the bottom
GAP = 4  # pixels between the two pictures
COLOURS_OF_GIF = 96
STILL_WIDTH = 480  # pixels
CAPTION_HEIGHT = 0.09  # of a still's height, for the letters


class Recorder:
    """Collects the frames of one trial.

    Attributes:
        frames: Images, each of shape (height, width, 3).
        phases: Number of the frame at which each phase of the trial ended, and its name.
    """

    def __init__(self, config: VideoConfig) -> None:
        """Take size and rate of the video."""
        self.config = config
        self.frames: list[Frame] = []
        self.phases: list[tuple[int, str]] = []
        self._due = 0.0

    def attach(self, scene: Scene, begin_s: float = 0.0, end_s: float = math.inf) -> None:
        """Film a scene from now on, at the video's rate in simulated time.

        Args:
            scene: What to film.
            begin_s: Simulated time before which nothing is filmed [s].
            end_s: Simulated time after which nothing is filmed [s].
        """
        self._due = max(scene.time_s, begin_s)

        def on_step() -> None:
            if self._due <= scene.time_s <= end_s:
                self._due += 1.0 / self.config.rate
                self.frames.append(
                    render(scene.client, scene.config.camera, self.config, scene.tip_position())
                )

        def on_phase(name: str) -> None:
            if begin_s <= scene.time_s <= end_s:
                self.phases.append((len(self.frames) - 1, name))

        scene.on_step, scene.on_phase = on_step, on_phase

    def write(self, path: Path) -> list[Path]:
        """Write the frames as MP4 (H.264), and as GIF beside it if the configuration wants one.

        Args:
            path: The file, ending in .mp4; each file is put in place when it is complete.

        Returns:
            What was written.
        """
        self._encode(path, MP4)
        if not self.config.gif_width:
            return [path]
        film = path.with_suffix(".gif")
        self._encode(film, gif(self.config.gif_rate, self.config.gif_width, COLOURS_OF_GIF))
        return [path, film]

    def _encode(self, path: Path, options: Sequence[str]) -> None:
        with replacing(path) as partial:
            encode(partial, self.frames, self.config.rate, options)

    def stills(self, columns: int) -> Image.Image:
        """The first frame, the one at the end of each phase and the last, on one sheet.

        Args:
            columns: Stills side by side; there are as many rows as it takes.
        """
        picks = [(0, "start"), *self.phases, (len(self.frames) - 1, "end")]
        height, width = self.frames[0].shape[:2]
        height, width = round(height * STILL_WIDTH / width), STILL_WIDTH
        rows = -(-len(picks) // columns)
        sheet = Image.new("RGB", (columns * width, rows * height), "white")
        for k, (number, name) in enumerate(picks):
            still = Image.fromarray(self.frames[max(number, 0)]).resize((width, height))
            _caption(still, f"{k + 1}  {name}")
            sheet.paste(still, (k % columns * width, k // columns * height))
        return sheet


def render(client: Any, camera: CameraConfig, size: VideoConfig, follow: ArrayLike) -> Frame:
    """One picture, with a close-up of the hand on its right.

    Args:
        client: PyBullet client.
        camera: Where to look from, and from how near at the hand.
        size: Width and height, and width of the close-up [pixels].
        follow: What the second camera looks at, base frame [m], shape (3,).

    Returns:
        Colours, shape (height, width, 3); `frame_width` is the width.
    """
    whole = (camera.distance, camera.yaw, camera.pitch)
    picture = _view(client, camera.target, whole, (size.width, size.height))
    if size.closeup == 0:
        return picture
    detail = (camera.closeup.distance, camera.closeup.yaw, camera.pitch)
    near = _view(client, follow, detail, (size.closeup, size.height))
    gap = np.full((size.height, GAP, 3), 255, dtype=np.uint8)
    return np.concatenate([picture, gap, near], axis=1)


def frame_width(size: VideoConfig) -> int:
    """Width of the pictures of `render` [pixels]."""
    return size.width + (GAP + size.closeup if size.closeup else 0)


def _view(
    client: Any, target: ArrayLike, eye: tuple[float, float, float], size: tuple[int, int]
) -> Frame:
    """Look at a target from a distance [m], yaw and pitch [deg]."""
    distance, yaw, pitch = eye
    width, height = size
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        np.asarray(target).tolist(), distance, yaw, pitch, 0.0, 2
    )
    projection = pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW, width / height, NEAR, FAR)
    image = client.getCameraImage(
        width,
        height,
        view,
        projection,
        lightDirection=[1.0, -0.6, 2.0],
        shadow=1,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
    )
    colours = np.reshape(np.asarray(image[2], dtype=np.uint8), (height, width, 4))
    depth = np.reshape(np.asarray(image[3]), (height, width))
    sky = np.linspace(*SKY, height).astype(np.uint8)[:, None]
    return np.where((depth >= 1.0)[:, :, None], sky, colours[:, :, :3])


def _caption(still: Image.Image, text: str) -> None:
    """Write what a still shows at its lower left corner."""
    size = CAPTION_HEIGHT * still.height
    draw = ImageDraw.Draw(still)
    font = ImageFont.load_default(size)
    left, top, right, bottom = draw.textbbox((0, 0), text, font=font)
    pad = 0.3 * size
    low = still.height - (bottom - top) - 2 * pad
    draw.rectangle((0, low, right - left + 2 * pad, still.height), fill=(40, 44, 52))
    draw.text((pad - left, low + pad - top), text, font=font, fill="white")
