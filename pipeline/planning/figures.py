"""Figures of one planned motion: the tip's path with its control polygon, and the joints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from pipeline.planning.benchmark import Pair
from pipeline.planning.config import PlanConfig
from pipeline.planning.control import control_points
from pipeline.planning.motion import Motion
from pipeline.reporting.style import PAPER_COLOUR, legend_below, looks, save, styled

if TYPE_CHECKING:
    from robots import Robot

DPI = 150
FLATTEST = 0.4  # smallest side of the box around a path, of the largest


def write_figures(
    robot: Robot, pair: Pair, motions: Mapping[str, Motion], config: PlanConfig, folder: Path
) -> None:
    """Write path (figure 4 of the paper) and joints of one start-target pair as PNG and PDF.

    Args:
        robot: The robot.
        pair: Start joints and target pose.
        motions: What each solver planned for it with the control points of `config.figure`.
        config: Places the control points.
        folder: Where the figures go.
    """
    start = robot.forward_kinematics(pair.start)[0]
    inner = control_points(start, pair.target, config.figure)
    polygon = np.vstack((start[:3], inner, pair.target[:3]))
    with styled():
        save(_path_figure(robot, polygon, motions), folder, "path", DPI)
        save(_joint_figure(robot, motions), folder, "joints", DPI)


def _path_figure(robot: Robot, polygon: np.ndarray, motions: Mapping[str, Motion]) -> Figure:
    figure = Figure(figsize=(5.5, 4.5), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    wanted = next(iter(motions.values())).poses
    axes.plot(*wanted[:, :3].T, color=PAPER_COLOUR, linewidth=5, alpha=0.6, label="wanted path")
    axes.plot(*polygon.T, "k--o", linewidth=0.8, markersize=4, label="control polygon")
    style = looks(motions)
    for name, motion in motions.items():
        look = style[name]
        reached = robot.forward_kinematics(motion.joints)
        axes.plot(*reached[:, :3].T, linestyle=look.line, color=look.colour, label=name)
        answered = robot.forward_kinematics(motion.answers)
        axes.plot(*answered[:, :3].T, ".", color=look.colour, markersize=3, alpha=0.6)
    axes.set(xlabel="x, m", ylabel="y, m", zlabel="z, m")
    axes.set_title(f"Tip path of {robot.name}; dots: the query before repair", fontsize=9)
    _frame(axes, np.vstack([wanted[:, :3], polygon]))
    axes.legend(loc="upper left", fontsize=7)
    return figure


def _frame(axes: Any, points: np.ndarray) -> None:
    """Show points in a box of true proportions that is nowhere so flat that its ticks overlap."""
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    half = 0.55 * np.ptp(points, axis=0)
    half = np.maximum(half, FLATTEST * half.max())
    for axis, centre, reach in zip("xyz", middle, half, strict=True):
        getattr(axes, f"set_{axis}lim")(centre - reach, centre + reach)
        getattr(axes, f"{axis}axis").set_major_locator(MaxNLocator(4))
    axes.set_box_aspect(tuple(half), zoom=0.85)  # room for the labels


def _joint_figure(robot: Robot, motions: Mapping[str, Motion]) -> Figure:
    rows = (robot.dof + 1) // 2
    figure = Figure(figsize=(7.5, 1.3 * rows + 0.6), layout="constrained")
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False)
    style = looks(motions)
    for index, axes in enumerate(grid.flat):
        if index >= robot.dof:
            axes.set_axis_off()
            continue
        for name, motion in motions.items():
            k = np.linspace(0, 1, len(motion.joints))
            look = style[name]
            axes.plot(
                k, motion.joints[:, index], linestyle=look.line, color=look.colour, label=name
            )
        axes.axhspan(robot.lower[index], robot.upper[index], color="0.95", zorder=0)
        axes.set_title(robot.joint_names[index], fontsize=8)
        axes.tick_params(labelsize=7)
    for axes in grid[-1]:
        axes.set_xlabel("k")
    figure.supylabel("joint value, rad or m (limits shaded)", fontsize=8)
    legend_below(figure, [grid.flat[0]])
    return figure
