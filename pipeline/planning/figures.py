"""Figures of one planned motion: the tip's path with its control polygon, and the joints."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from pipeline.data.files import replacing
from pipeline.planning.benchmark import Pair
from pipeline.planning.config import PlanConfig
from pipeline.planning.control import control_points
from pipeline.planning.motion import Motion

if TYPE_CHECKING:
    from robots import Robot

# Okabe and Ito's palette: told apart by colour-blind readers; line styles tell them apart in grey.
STYLES = (
    ("#0072b2", "-"),
    ("#d55e00", "--"),
    ("#009e73", "-."),
    ("#cc79a7", ":"),
    ("#56b4e9", "-"),
)


def write_figures(
    robot: Robot, pair: Pair, motions: Mapping[str, Motion], config: PlanConfig, folder: Path
) -> None:
    """Write path.png (figure 4 of the paper) and joints.png for one start-target pair.

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
    _save(_path_figure(robot, polygon, motions), folder / "path.png")
    _save(_joint_figure(robot, motions), folder / "joints.png")


def _path_figure(robot: Robot, polygon: np.ndarray, motions: Mapping[str, Motion]) -> Figure:
    figure = plt.figure(figsize=(5.5, 4.5), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    wanted = next(iter(motions.values())).poses
    axes.plot(*wanted[:, :3].T, color="0.7", linewidth=5, label="wanted path")
    axes.plot(*polygon.T, "k--o", linewidth=0.8, markersize=4, label="control polygon")
    for (name, motion), (colour, style) in zip(motions.items(), STYLES, strict=False):
        reached = robot.forward_kinematics(motion.joints)
        axes.plot(*reached[:, :3].T, style, color=colour, linewidth=1.5, label=name)
    axes.set(xlabel="x, m", ylabel="y, m", zlabel="z, m", title=f"Tip path of {robot.name}")
    axes.set_aspect("equal")
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    return figure


def _joint_figure(robot: Robot, motions: Mapping[str, Motion]) -> Figure:
    rows = (robot.dof + 1) // 2
    figure, grid = plt.subplots(
        rows, 2, figsize=(7.5, 1.3 * rows + 0.6), sharex=True, layout="constrained"
    )
    for index, axes in enumerate(grid.flat):
        if index >= robot.dof:
            axes.set_axis_off()
            continue
        for (name, motion), (colour, style) in zip(motions.items(), STYLES, strict=False):
            k = np.linspace(0, 1, len(motion.joints))
            axes.plot(k, motion.joints[:, index], style, color=colour, label=name)
        axes.axhspan(robot.lower[index], robot.upper[index], color="0.95", zorder=0)
        axes.set_title(robot.joint_names[index], fontsize=8)
        axes.tick_params(labelsize=7)
    for axes in grid[-1]:
        axes.set_xlabel("k")
    figure.supylabel("joint value, rad or m (limits shaded)", fontsize=8)
    figure.legend(
        *grid.flat[0].get_legend_handles_labels(), loc="outside upper right", frameon=False
    )
    return figure


def _save(figure: Figure, path: Path) -> None:
    with replacing(path) as partial:
        figure.savefig(partial, dpi=150)
    plt.close(figure)
