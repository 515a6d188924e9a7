"""What drawings of a tip's path in space share."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from pipeline.presentation.style import SOFT
from robots.rotations import matrix_from_quaternion

Array = NDArray[np.float64]

FLATTEST = 0.4  # smallest side of the box around a path, of the largest
FRAMES = 7  # waypoints at which the rotation of the tip is drawn
FRAME_SIZE = 0.07  # length of its axes, of the largest side of the box
AXES = ("#d55e00", "#009e73", "#0072b2")  # x, y, z of the tip
ELEVATION = 20.0  # deg, of the view
ASIDE = 65.0  # deg, of the view from the direction in which points lie widest apart
ZOOM = 0.9  # leaves room for the labels
TOGETHER = 1e-6  # m up to which control points are one


def draw_frames(axes: Any, poses: Array, size: float) -> None:
    """Draw the axes of the tip, x, y and z, at some of the poses (S, 7), `size` long [m]."""
    for pose in poses[np.linspace(0, len(poses) - 1, FRAMES).astype(int)]:
        rotation = matrix_from_quaternion(pose[3:])
        for column, colour in enumerate(AXES):
            tip = pose[:3] + size * rotation[:, column]
            axes.plot(
                *np.stack([pose[:3], tip]).T, color=colour, linewidth=1.1, solid_capstyle="butt"
            )


def draw_polygon(axes: Any, points: Array, colour: str, label: str) -> None:
    """Draw a control polygon (t + 1, 3) and number its points, those in one place together."""
    axes.plot(*points.T, "--o", color=colour, linewidth=0.8, markersize=3.5, label=label)
    shift = 0.03 * np.ptp(points, axis=0).max()
    begin = 0
    for index in range(1, len(points) + 1):
        ended = index == len(points)
        if ended or np.linalg.norm(points[index] - points[begin]) > TOGETHER:
            names = f"{begin}" if index == begin + 1 else f"{begin}–{index - 1}"
            place = points[begin] + np.array([0.0, 0.0, shift])
            axes.text(*place, f"$c_{{{names}}}$", color=colour, fontsize=8, ha="right")
            begin = index


def frame_box(axes: Any, points: Array) -> float:
    """Show points (N, 3) in a box of true proportions, nowhere so flat that its ticks overlap.

    The view is from above, and from the side on which the points lie widest apart.

    Returns:
        Length that axes of the tip should have [m].
    """
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    half = 0.58 * np.ptp(points, axis=0)
    half = np.maximum(half, FLATTEST * half.max())
    for axis, centre, reach in zip("xyz", middle, half, strict=True):
        getattr(axes, f"set_{axis}lim")(centre - reach, centre + reach)
        getattr(axes, f"{axis}axis").set_major_locator(MaxNLocator(4))
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.tick_params(labelsize=7, colors=SOFT)
    axes.set_box_aspect(tuple(half), zoom=ZOOM)
    flat = points[:, :2] - points[:, :2].mean(axis=0)
    wide = np.linalg.svd(flat, full_matrices=False)[2][0]
    axes.view_init(elev=ELEVATION, azim=np.rad2deg(np.arctan2(wide[1], wide[0])) - ASIDE)
    return float(FRAME_SIZE * 2 * half.max())
