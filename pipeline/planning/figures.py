"""Figures of planned motions: the tip's path, the joints, and a curve driven for another one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.planning.benchmark import Pair
from pipeline.planning.config import PlanConfig
from pipeline.planning.continuity import branch_flips
from pipeline.planning.drawing import draw_frames, draw_polygon, frame_box
from pipeline.planning.flip_kernel import FLIP_STEP
from pipeline.planning.motion import Motion
from pipeline.planning.path import control_points
from pipeline.presentation.naming import robot_title, solver_title
from pipeline.presentation.style import (
    INK,
    LOOKS,
    PAPER_COLOUR,
    legend_below,
    logarithmic,
    looks,
    reference_line,
    save,
    styled,
)

if TYPE_CHECKING:
    from robots import Robot

DPI = 150
SMALLEST_MM = 1e-3  # mm, smaller errors are drawn here


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


def write_route(robot: Robot, requested: Motion, driven: Motion, solver: str, folder: Path) -> None:
    """Write a figure of a requested path that flips and of the curve driven in its place.

    Args:
        robot: The robot.
        requested: The plan on the requested path.
        driven: The plan between the same ends on another curve.
        solver: Name of the solver of both.
        folder: Where the figure goes.
    """
    with styled():
        save(_route_figure(robot, requested, driven, solver), folder, "route", DPI)


def _path_figure(robot: Robot, polygon: np.ndarray, motions: Mapping[str, Motion]) -> Figure:
    """Tip path with its control polygon, and how far each solver's tip is from it."""
    figure = Figure(figsize=(8.2, 4.3), layout="constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(1.45, 1.0))
    axes: Any = figure.add_subplot(grid[0], projection="3d")
    errors = figure.add_subplot(grid[1])
    wanted = next(iter(motions.values())).poses
    size = frame_box(axes, np.vstack([wanted[:, :3], polygon]))
    axes.plot(*wanted[:, :3].T, color=PAPER_COLOUR, linewidth=5, alpha=0.6, label="wanted path")
    draw_frames(axes, wanted, size)
    draw_polygon(axes, polygon, INK, "control polygon")
    style, k = looks(motions), np.linspace(0.0, 1.0, len(wanted))
    for name, motion in motions.items():
        look = style[name]
        reached = robot.forward_kinematics(motion.joints)
        axes.plot(*reached[:, :3].T, linestyle=look.line, color=look.colour, linewidth=1.2)
        answered = robot.forward_kinematics(motion.answers)[:, :3]
        away = 1e3 * np.linalg.norm(answered - motion.requested[:, :3], axis=1)
        met = np.maximum(motion.tip_error_mm, SMALLEST_MM)
        errors.plot(k, met, linestyle=look.line, color=look.colour, label=solver_title(name))
        errors.plot(k, np.maximum(away, SMALLEST_MM), ".", color=look.colour, markersize=3)
    axes.set_title(f"{robot_title(robot.name)}: path of the tip, its axes and control points")
    errors.set(title="Tip error (dots: before repair)", xlabel="path parameter k", ylabel="[mm]")
    logarithmic(errors, "y")
    legend_below(figure, [axes, errors], columns=4)
    return figure


def _joint_figure(robot: Robot, motions: Mapping[str, Motion]) -> Figure:
    rows = (robot.dof + 1) // 2
    figure = Figure(figsize=(7.5, 1.3 * rows + 0.6), layout="constrained")
    grid = figure.subplots(rows, 2, sharex=True, squeeze=False)
    style = looks(motions)
    # Solvers often agree: the first lines are wider, so that they show beneath the last ones.
    widths = np.linspace(2.8, 1.1, len(motions))
    for index, axes in enumerate(grid.flat):
        if index >= robot.dof:
            axes.set_axis_off()
            continue
        for (name, motion), width in zip(motions.items(), widths, strict=True):
            k = np.linspace(0, 1, len(motion.joints))
            look, values = style[name], motion.joints[:, index]
            (line,) = axes.plot(k, values, label=solver_title(name))
            line.set(linestyle=look.line, color=look.colour, linewidth=width)
        axes.axhspan(robot.lower[index], robot.upper[index], color="0.95", zorder=0)
        axes.set_title(robot.joint_names[index], fontsize=8)
        axes.tick_params(labelsize=7)
    for axes in grid[-1]:
        axes.set_xlabel("path parameter k")
    figure.supylabel("joint value [rad or m], limits shaded", fontsize=8)
    legend_below(figure, [grid.flat[0]])
    return figure


def _route_figure(robot: Robot, requested: Motion, driven: Motion, solver: str) -> Figure:
    """The path that flips and the other curve in space, and the joint steps along both."""
    figure = Figure(figsize=(8.2, 4.3), layout="constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(1.45, 1.0))
    axes: Any = figure.add_subplot(grid[0], projection="3d")
    steps = figure.add_subplot(grid[1])
    inner = np.zeros((0, 3)) if driven.route is None else driven.route.control_points
    polygon = np.vstack([driven.poses[:1, :3], inner, driven.poses[-1:, :3]])
    size = frame_box(axes, np.vstack([requested.poses[:, :3], driven.poses[:, :3], polygon]))
    axes.plot(
        *requested.poses[:, :3].T, color=LOOKS[1].colour, linewidth=1.6, label="requested path"
    )
    flips = np.flatnonzero(branch_flips(robot, requested.joints, requested.poses))
    where = 0.5 * (requested.poses[flips, :3] + requested.poses[flips + 1, :3])
    axes.plot(*where.T, "X", color=LOOKS[1].colour, markersize=9, label="branch flip")
    axes.plot(*driven.poses[:, :3].T, color=LOOKS[0].colour, linewidth=2.2, label="curve driven")
    draw_frames(axes, driven.poses, size)
    draw_polygon(axes, polygon, INK, "control polygon of the curve driven")
    for motion, look in ((requested, LOOKS[1]), (driven, LOOKS[0])):
        _draw_steps(steps, motion, look.colour)
    reference_line(steps, "y", FLIP_STEP, "a flip is longer")
    axes.set_title(f"{robot_title(robot.name)}, {solver_title(solver)}: another curve")
    steps.set(title="Largest joint step", xlabel="path parameter k", ylabel="[rad or m]")
    logarithmic(steps, "y")
    legend_below(figure, [axes, steps], columns=3)
    return figure


def _draw_steps(axes: Axes, motion: Motion, colour: str) -> None:
    """Draw the largest joint step from each waypoint to the next over k."""
    widest = np.abs(np.diff(motion.joints, axis=0)).max(axis=1)
    k = (np.arange(len(widest)) + 0.5) / len(widest)
    axes.plot(k, np.maximum(widest, 1e-4), color=colour)
