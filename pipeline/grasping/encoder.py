"""Frames to a film by ffmpeg, which comes with a Python package: whole, or an error of the disk."""

from __future__ import annotations

import errno
import subprocess
import tempfile
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint8]
MP4 = ("-vcodec", "libx264", "-pix_fmt", "yuv420p", "-crf", "20")


def gif(rate: float, width: int, colours: int) -> tuple[str, ...]:
    """Return the options of a GIF that is shown again and again.

    Args:
        rate: Frames a second [Hz].
        width: Of the pictures [pixels]; the height follows.
        colours: Of the palette, which is the film's own.
    """
    graph = (
        f"[0:v]fps={rate:g},scale={width}:-1:flags=lanczos,split[a][b];"
        f"[a]palettegen=max_colors={colours}[p];[b][p]paletteuse=dither=none"
    )
    return ("-vcodec", "gif", "-pix_fmt", "pal8", "-filter_complex", graph, "-loop", "0")


def encode(path: Path, frames: Iterable[Frame], rate: float, options: Sequence[str]) -> None:
    """Write frames as a film.

    The package's own writer does not look at how ffmpeg ended: a full disk gave half a film.

    Args:
        path: The file; its suffix says the container.
        frames: Images of one shape (height, width, 3).
        rate: Frames a second [Hz].
        options: Of ffmpeg, about codec and filters: `MP4` or `gif`.

    Raises:
        OSError: ffmpeg could not write the file.
    """
    frames = iter(frames)
    first = next(frames)
    height, width = first.shape[:2]
    source = ["-f", "rawvideo", "-s", f"{width}x{height}", "-pix_fmt", "rgb24", "-r", f"{rate:g}"]
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", *source, "-i", "-", "-an", *options]
    with (
        tempfile.TemporaryFile() as said,
        subprocess.Popen(
            [*command, "-v", "error", str(path)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=said,
            process_group=0,  # Ctrl-C is for this process, which ends its own
        ) as process,
    ):
        try:
            assert process.stdin is not None
            with suppress(BrokenPipeError):  # it ended; why, it says
                for frame in (first, *frames):
                    process.stdin.write(frame.tobytes())
                process.stdin.flush()
            with suppress(BrokenPipeError):
                process.stdin.close()
            status = process.wait()
        except BaseException:
            process.kill()
            raise
        said.seek(0)
        lines = said.read().decode(errors="replace").splitlines()
    if status:
        why = lines[-1] if lines else f"status {status}"
        raise OSError(errno.EIO, f"ffmpeg could not write it ({why})", str(path))
