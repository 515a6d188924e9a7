"""Films of trials: rendered on the CPU, written as MP4, with a sheet of stills beside."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import imageio_ffmpeg
import numpy as np
import pybullet
from numpy.typing import NDArray
from PIL import Image

from pipeline.data.files import replacing
from pipeline.grasping.config import CameraConfig, VideoConfig

if TYPE_CHECKING:
    from pipeline.grasping.scene import Scene

Frame = NDArray[np.uint8]
FIELD_OF_VIEW = 45.0  # deg
NEAR, FAR = 0.05, 5.0  # m


class Recorder:
    """Collects the frames of one trial.

    Attributes:
        frames: Images, each of shape (height, width, 3).
    """

    def __init__(self, config: VideoConfig) -> None:
        """Take size and rate of the video."""
        self.config = config
        self.frames: list[Frame] = []
        self._due = 0.0

    def attach(self, scene: Scene) -> None:
        """Film a scene from now on, at the video's rate in simulated time."""
        self._due = scene.time_s

        def on_step() -> None:
            if scene.time_s >= self._due:
                self._due += 1.0 / self.config.rate
                self.frames.append(render(scene.client, scene.config.camera, self.config))

        scene.on_step = on_step

    def write(self, path: Path) -> None:
        """Write the frames as MP4 (H.264).

        Args:
            path: The file, ending in .mp4; it is put in place when it is whole.
        """
        size = (self.config.width, self.config.height)
        with replacing(path) as partial:
            writer = imageio_ffmpeg.write_frames(
                str(partial), size, fps=self.config.rate, quality=6, macro_block_size=1
            )
            writer.send(None)
            for frame in self.frames:
                writer.send(np.ascontiguousarray(frame))
            writer.close()

    def stills(self, columns: int, rows: int) -> Image.Image:
        """Evenly spaced frames on one sheet, in reading order."""
        picks = np.linspace(0, len(self.frames) - 1, columns * rows).round().astype(int)
        height, width = self.frames[0].shape[:2]
        sheet = Image.new("RGB", (columns * width, rows * height))
        for k, pick in enumerate(picks):
            place = (k % columns * width, k // columns * height)
            sheet.paste(Image.fromarray(self.frames[pick]), place)
        return sheet


def render(client: Any, camera: CameraConfig, size: VideoConfig) -> Frame:
    """One picture of a scene by the software renderer: no display, no graphics card.

    Args:
        client: PyBullet client.
        camera: Where to look from.
        size: Width and height [pixels].

    Returns:
        Colours, shape (height, width, 3).
    """
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        camera.target, camera.distance, camera.yaw, camera.pitch, 0.0, 2
    )
    projection = pybullet.computeProjectionMatrixFOV(
        FIELD_OF_VIEW, size.width / size.height, NEAR, FAR
    )
    image = client.getCameraImage(
        size.width,
        size.height,
        view,
        projection,
        lightDirection=[1.0, -0.6, 2.0],
        shadow=1,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
    )
    colours = np.reshape(np.asarray(image[2], dtype=np.uint8), (size.height, size.width, 4))
    return np.ascontiguousarray(colours[:, :, :3])
