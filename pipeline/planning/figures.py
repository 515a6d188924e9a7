"""Figures of one planned motion: the tip's path with its control polygon, and the joints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from pipeline.planning.benchmark import Pair
from pipeline.planning.config import PlanConfig
from pipeline.planning.control import control_points
from pipeline.planning.motion import Motion
from pipeline.reporting.style import PAPER_COLOUR, legend_below, looks, save, styled

if TYPE_CHECKING:
    from robots import Robot

DPI = 150


def write_figures(
    robot: Robot, pair: Pair, motions: Mapping[str, Motion], config: PlanConfig, folder: Path
) -> None:
    """Write path (figure 4 of the paper) and joints of one start-target pair as PNG and PDF.

    Args:
        robot: The robot.
        pair: Start joints and target pose.
        motions: What each solver planned for it.
        config: Places the control points.
        folder: Where the figures go.
    """
    start = robot.forward_kinematics(pair.start)[0]
    inner = control_points(start, pair.target, config.motion)
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
        reached = robot.forward_kinematics(motion.joints)
        look = style[name]
        axes.plot(*reached[:, :3].T, linestyle=look.line, color=look.colour, label=name)
    axes.set(xlabel="x, m", ylabel="y, m", zlabel="z, m", title=f"Tip path of {robot.name}")
    axes.set_aspect("equal")
    axes.legend(loc="upper left")
    return figure


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
