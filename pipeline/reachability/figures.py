"""Figure of a reachability map: horizontal slices, and one upright through the middle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from numpy.typing import NDArray

from pipeline.presentation.naming import robot_title
from pipeline.presentation.style import INK, panels, save, styled

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

LEVELS = 5  # horizontal slices, at most
COLOURS = "viridis"  # as legible in grey
WIDTH, HEIGHT = 2.7, 2.6  # inch, of a panel


def write_map(robot: Robot, rows: pd.DataFrame, folder: Path, dpi: int) -> list[Path]:
    """Write the slices of a map as PNG and PDF.

    Args:
        robot: The robot.
        rows: A row a voxel, see `pipeline.reachability.voxels`.
        folder: Where the figure goes.
        dpi: Pixels an inch of the PNG.
    """
    axes_m = [np.unique(rows[name].to_numpy()) for name in "xyz"]
    share = np.full([len(axis) for axis in axes_m], np.nan)
    at = [np.searchsorted(axis, rows[name]) for axis, name in zip(axes_m, "xyz", strict=True)]
    share[tuple(at)] = np.where(rows["count"] > 0, rows.share, np.nan)
    levels = _levels(share)
    with styled():
        figure, drawn = panels(len(levels) + 1, WIDTH, HEIGHT)
        image = _upright(drawn[0], share, axes_m)
        for axis, level in zip(drawn[1:], levels, strict=True):
            title = f"z = {axes_m[2][level]:.2f} m"
            _slice(axis, share[:, :, level], axes_m[0], axes_m[1], "x [m]", "y [m]", title)
        bar = figure.colorbar(image, ax=drawn, shrink=0.6, pad=0.02)
        bar.set_label("share of orientations reached")
        bar.outline.set_visible(False)
        figure.suptitle(
            f"Reachability of {robot_title(robot.name)}; + is its base", x=0.01, ha="left"
        )
        return save(figure, folder, "map", dpi)


def _levels(share: Array) -> list[int]:
    """Indices of heights, spread over those where anything is reached, the highest first."""
    reached = np.flatnonzero(~np.isnan(share).all(axis=(0, 1)))
    if len(reached) == 0:
        return [share.shape[2] // 2]
    chosen = np.linspace(reached[0], reached[-1], min(LEVELS + 2, len(reached)))
    inner = chosen[1:-1] if len(chosen) > 2 else chosen
    return sorted({round(level) for level in inner}, reverse=True)


def _upright(axis: Axes, share: Array, axes_m: list[Array]) -> AxesImage:
    """The slice of the map along x and z in which most is reached."""
    middle = int(np.argmax(np.nansum(share, axis=(0, 2))))
    title = f"y = {axes_m[1][middle]:.2f} m"
    return _slice(axis, share[:, middle], axes_m[0], axes_m[2], "x [m]", "z [m]", title)


def _slice(
    axis: Axes, share: Array, across: Array, up: Array, label: str, above: str, title: str
) -> AxesImage:
    """Draw shares (A, B) over the places of two axes, NaN left blank, and the base."""
    half = [(line[1] - line[0]) / 2 if len(line) > 1 else 0.5 for line in (across, up)]
    extent = (
        *(across[0] - half[0], across[-1] + half[0]),
        *(up[0] - half[1], up[-1] + half[1]),
    )
    image = axis.imshow(
        share.T,
        origin="lower",
        extent=extent,
        cmap=COLOURS,
        vmin=0.0,
        vmax=1.0,
        interpolation="nearest",
        zorder=2,
    )
    axis.plot(0.0, 0.0, marker="+", color=INK, markersize=8, zorder=3)
    axis.set(xlabel=label, ylabel=above, title=title)
    return image
