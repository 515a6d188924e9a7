"""Table: how much a neural seed gives each local solver."""

from __future__ import annotations

import pandas as pd

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.reporting.table import Column, Table

SUCCESS, ITERATIONS, TIME = "1 mm, 1 deg [%]", "iterations, mean", "time per pose [µs]"


def neural_seeds(effects: pd.DataFrame, config: ReportConfig) -> Table:
    """How much a neural seed gives each solver, on the same poses from home and from the seed.

    Args:
        effects: Lines of `pipeline.reporting.seeding.seed_effects`; may be empty.
        config: What strict success is.
    """
    strict = config.success.strict
    table = Table(
        name="neural_seeds",
        title="What a neural seed gives a local solver",
        caption="The same poses from the home configuration and from the answer of a network, with "
        f"the same budget. Success below {strict.position_mm:g} mm and {strict.rotation_deg:g} deg "
        "(Euclidean, geodesic, joint limits kept); p by McNemar, adjusted by Holm over the solvers "
        "of a robot. Times are those of the solver alone: what the seed costs at that batch size "
        "stands beside them, and pays off where it is less than what it saves.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("seeded_by", "seed"),
            Column("batch_size", "batch size"),
            Column("poses", "poses"),
            Column("success_home", "home", SUCCESS, percent=2),
            Column("success_seeded", "seed", SUCCESS, percent=2),
            Column("success_difference", "Δ [points]", SUCCESS, percent=2, signed=True),
            Column("success_p", "p", SUCCESS),
            Column("iterations_home", "home", ITERATIONS, 3),
            Column("iterations_seeded", "seed", ITERATIONS, 3),
            Column("time_home_us", "home, mean", TIME, 3),
            Column("time_seeded_us", "seed, mean", TIME, 3),
            Column("saved_us", "saved, mean", TIME, 3, signed=True),
            Column("time_difference_us", "Δ, paired median", TIME, 3, signed=True),
            Column("seed_time_us", "the seed itself", TIME, 3),
        ],
    )
    for _, line in _sorted(effects).iterrows():
        p = line.success_p
        cells = {column.name: line.get(column.name) for column in table.columns}
        cells |= {
            "robot": robot_title(line.robot),
            "solver": solver_title(line.solver),
            "seeded_by": solver_title(line.seeded_by),
            "batch_size": int(line.batch_size),
            "poses": int(line.poses),
            "success_p": None if pd.isna(p) else "< 0.001" if p < 0.001 else f"{p:.3f}",
            "saved_us": line.time_home_us - line.time_seeded_us,
        }
        table.add(**cells)
    return table


def _sorted(effects: pd.DataFrame) -> pd.DataFrame:
    if effects.empty:
        return effects
    robots, solvers = ordered_robots(effects.robot), ordered_solvers(effects.solver)
    order = effects.assign(
        robot=effects.robot.map(robots.index), solver=effects.solver.map(solvers.index)
    )
    return effects.loc[order.sort_values(["robot", "solver", "batch_size"]).index]
