"""Tables of experiments on demand: secondary goals of training, many solutions of one pose."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from pipeline.evaluation.sampling import spread
from pipeline.reporting.naming import ordered_robots, robot_title, solver_title
from pipeline.reporting.results import Results
from pipeline.reporting.sweeps import SweptRun, alike
from pipeline.reporting.table import Column, Table

ANSWERING = "cycleik"  # the solver whose answers show what a secondary goal does
WIDE_RAD = 0.2  # a joint whose solutions spread by that much moves visibly


def constraints(results: Results) -> Table:
    """What secondary goals of training do to the joints, and what they cost in precision."""
    table = Table(
        name="constraints",
        title="Secondary goals of training",
        caption="The same network trained with goals for joints beside the pose, and without "
        "(scale 0). Distance: mean over test poses and chosen joints of the distance from the goal "
        "posture. Errors: Euclidean and geodesic mean on the test set, without refinement.",
        columns=[
            Column("robot", "Robot"),
            Column("model", "Model"),
            Column("goal", "Goal"),
            Column("scale", "Scale"),
            Column("distance_rad", "mean", "distance from the goal [rad]", 3),
            Column("reduction", "times smaller", "distance from the goal [rad]", 3),
            Column("position_error_mm", "mean", "position error [mm]", 3),
            Column("position_cost_mm", "Δ", "position error [mm]", 3, signed=True),
            Column("rotation_error_deg", "mean", "rotation error [deg]", 3),
            Column("rotation_cost_deg", "Δ", "rotation error [deg]", 3, signed=True),
        ],
    )
    constrained = [run for run in results.swept if run.train.get("constraints")]
    for group in alike(constrained, ("constraint_scale",)):
        lines = [line for run in group if (line := _constraint_line(run)) is not None]
        free = next((line for line in lines if line["scale"] == 0), None)
        for line in sorted(lines, key=lambda line: float(line["scale"])):
            if free is not None and line is not free:
                if line["distance_rad"] and free["distance_rad"] is not None:
                    line["reduction"] = free["distance_rad"] / line["distance_rad"]
                for kind, unit in (("position", "mm"), ("rotation", "deg")):
                    error = f"{kind}_error_{unit}"
                    line[f"{kind}_cost_{unit}"] = line[error] - free[error]
            table.add(**line)
    return table


def solutions(results: Results) -> Table:
    """Spread and precision of many solutions of one pose, before and after refinement."""
    table = Table(
        name="many_solutions",
        title="Many solutions of one pose",
        caption="Solutions that a solver draws of test poses, as drawn and after each was refined "
        "by the compiled Levenberg-Marquardt kernel. Spread: standard deviation of a joint over "
        "the solutions of a pose, mean over poses. Wide joints: those that spread by "
        f"{WIDE_RAD:g} rad or more. Left: share of refinements that ended on another start.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("refined", "Stage"),
            Column("poses", "poses"),
            Column("samples", "solutions of each"),
            Column("wide_median", "median", "wide joints of a pose"),
            Column("wide_least", "least", "wide joints of a pose"),
            Column(
                "three_wide", "poses with three or more [%]", "wide joints of a pose", percent=0
            ),
            Column("spread_rad", "spread by joint [rad]"),
            Column("position_error_mm", "position error [mm]", digits=3),
            Column("rotation_error_deg", "rotation error [deg]", digits=3),
            Column("found", "found [%]", percent=1),
            Column("left", "left [%]", percent=1),
        ],
    )
    for robot in ordered_robots(robot for robot, _ in results.sample):
        for (name, solver), rows in results.sample.items():
            if name != robot:
                continue
            for refined in (False, True):
                part = rows[rows.refined == refined]
                widths = spread(part)
                wide = (widths >= WIDE_RAD).sum(axis=1)
                table.add(
                    robot=robot_title(robot),
                    solver=solver_title(solver),
                    refined="refined" if refined else "drawn",
                    poses=int(part.pose.nunique()),
                    samples=int(part["sample"].nunique()),
                    wide_median=float(wide.median()),
                    wide_least=int(wide.min()),
                    three_wide=float((wide >= 3).mean()),
                    spread_rad=" ".join(f"{width:.2f}" for width in widths.mean()),
                    position_error_mm=float(part.position_error_mm.mean()),
                    rotation_error_deg=float(part.rotation_error_deg.mean()),
                    found=float(part.found.mean()) if refined else None,
                    left=float((part.starts > 1).mean()) if refined else None,
                )
    return table


def _constraint_line(run: SweptRun) -> dict[str, Any] | None:
    rows = run.answers(ANSWERING)
    if rows is None:
        return None
    goals = run.train["constraints"]
    return {
        "robot": robot_title(run.robot),
        "model": run.model,
        "goal": "; ".join(_goal(goal) for goal in goals),
        "scale": run.train["constraint_scale"],
        "distance_rad": _distance(run, rows, goals),
        "position_error_mm": float(rows.position_error_mm.mean()),
        "rotation_error_deg": float(rows.rotation_error_deg.mean()),
    }


def _goal(goal: dict[str, Any]) -> str:
    if goal.get("joints") is not None:
        names = ", ".join(str(joint) for joint in goal["joints"])
        return f"{names} at {goal['posture']}, weight {goal['weight']:g}"
    place = goal["position"] if goal.get("pose") is None else goal["pose"]
    return f"{goal['link']} at {place}, weight {goal['weight']:g}"


def _distance(run: SweptRun, rows: pd.DataFrame, goals: list[dict[str, Any]]) -> float | None:
    """Mean distance of all joints with a goal from their posture; None where none has one."""
    names, distances = list(run.card["joint_names"]), []
    for goal in goals:
        if goal.get("joints") is None:
            continue
        columns = [f"q{names.index(j) if j in names else int(j)}" for j in goal["joints"]]
        away = rows[columns].to_numpy(dtype=float) - np.asarray(goal["posture"], dtype=float)
        distances.append(np.abs(away).ravel())
    return float(np.concatenate(distances).mean()) if distances else None
