"""Tables of the search: studies, and the best of one against Table I at one budget."""

from __future__ import annotations

from typing import Any

import pandas as pd
from scipy import stats

from pipeline.reporting.naming import ordered_robots, robot_title
from pipeline.reporting.published import Published
from pipeline.reporting.results import Results
from pipeline.reporting.table import Column, Table
from pipeline.reporting.tables_training import drawn_row, hyperparameter_columns, published_row

CONFIDENCE = 0.95
RIVAL = "table_one"
TITLES = {"best": "best of the search", "default": "as it was before", RIVAL: "Table I"}
CURRENCIES = {
    "seconds": "{:g} s of training on this machine each",
    "multiply_adds": "{:.3g} multiply-adds of training each",
    "poses": "{:,.0f} training poses seen each",
}
METRICS = ("position_error_mm", "rotation_error_deg")
DIFFERENCE = "difference to Table I, 95 % interval"


def found_hyperparameters(
    robot: str, published: Published, found: dict[str, dict[str, Any]]
) -> Table:
    """One robot's Table I: what the paper found and what a study did.

    Args:
        robot: Name of the robot.
        published: The paper's numbers.
        found: Groups train and model, ``parameters`` and ``objective``, by what each row is called.
    """
    table = Table(
        name="table1",
        title=f"Hyperparameters of {robot_title(robot)} in the form of Table I",
        caption="The paper's best of 200 trials and this study's. Learning rate in units of 1e-4; "
        "the objective is this study's, after the short training of a trial.",
        columns=[
            Column("source", "Source"),
            *hyperparameter_columns(),
            Column("objective", "Objective", digits=4),
        ],
    )
    if robot in published.robots("hyperparameters"):
        table.add(source="paper", **published_row(published, robot))
    for source, row in found.items():
        parameters = row.get("parameters")
        table.add(
            source=source,
            **drawn_row(row),
            parameters=None if parameters is None else parameters / 1e6,
            objective=row.get("objective"),
        )
    return table


def studies(results: Results) -> Table:
    """How each search went."""
    table = Table(
        name="studies",
        title="Searches",
        caption="Trials of each study and its best one; errors on the validation set, Euclidean "
        "and geodesic, after the short training of a trial.",
        columns=[
            Column("robot", "Robot"),
            Column("model", "Model"),
            Column("finished", "finished"),
            Column("pruned", "of these cut short"),
            Column("failed", "failed"),
            Column("objective", "best objective", digits=4),
            Column("first", "objective of the start", digits=4),
            Column("trial", "best trial"),
            Column("position_error_mm", "position [mm]", digits=3),
            Column("rotation_error_deg", "rotation [deg]", digits=3),
        ],
    )
    for robot in ordered_robots(results.tune):
        trials, best = results.tune[robot]
        if "state" not in trials or "objective" not in trials:
            continue
        of = best.get("of") or {}
        complete = trials[trials.state == "COMPLETE"]
        if complete.empty:
            continue
        winner = complete.sort_values(["objective", "number"]).iloc[0]
        starts = complete[~complete.drawn] if "drawn" in complete else complete[:0]
        table.add(
            robot=robot_title(robot),
            model=of.get("model"),
            finished=int(trials.state.isin(["COMPLETE", "PRUNED"]).sum()),
            pruned=int((trials.state == "PRUNED").sum()),
            failed=int((trials.state == "FAIL").sum()),
            objective=float(winner.objective),
            first=None if starts.empty else float(starts.objective.iloc[0]),
            trial=int(winner.number),
            position_error_mm=_number(winner, "position_error_mm"),
            rotation_error_deg=_number(winner, "rotation_error_deg"),
        )
    return table


def tuned_against_table_one(results: Results) -> Table:
    """The best of a search and Table I, trained at one budget, and whether one beats the other."""
    table = Table(
        name="tuned_against_table_one",
        title="The best of the search against Table I at equal training budget",
        caption="Means over trainings with other seeds on the same validation set, Euclidean and "
        "geodesic. The interval of the difference is Welch's t-interval over the trainings; where "
        "it holds zero, nothing is shown.",
        columns=[
            Column("robot", "Robot"),
            Column("name", "Configuration"),
            Column("trainings", "trainings"),
            Column("parameters", "parameters"),
            Column("train_s", "time [s]", "spent on each training", 3),
            Column("multiply_adds", "multiply-adds [1e12]", "spent on each training", 3),
            Column("poses_seen", "poses seen", "spent on each training"),
            Column("position_error_mm", "position [mm]", "error", 4),
            Column("rotation_error_deg", "rotation [deg]", "error", 4),
            Column("success_10mm_20deg", "within 10 mm, 20 deg [%]", percent=2),
            Column("position_difference", "position [mm]", DIFFERENCE),
            Column("rotation_difference", "rotation [deg]", DIFFERENCE),
            Column("verdict", "against Table I"),
        ],
    )
    for robot in ordered_robots(results.compare_tuned):
        rows = results.compare_tuned[robot]
        rival = rows[rows["name"] == RIVAL]
        for name, mine in rows.groupby("name", sort=False):
            table.add(**_compare_tuned_row(robot, str(name), mine, rival))
        budgets = rows.groupby(["currency", "amount"]).size().index
        for currency, amount in budgets:
            budget = CURRENCIES[str(currency)].format(float(amount))
            note = f"{robot_title(robot)}: equal budget is {budget}."
            if note not in table.notes:
                table.notes.append(note)
    return table


def welch(mine: pd.Series, theirs: pd.Series) -> tuple[float, float, float]:
    """Return the difference of two means and the ends of its confidence interval.

    Welch (1947), "The generalization of Student's problem when several different population
    variances are involved".
    """
    test = stats.ttest_ind(mine, theirs, equal_var=False)
    low, high = test.confidence_interval(CONFIDENCE)
    return float(mine.mean() - theirs.mean()), float(low), float(high)


def _compare_tuned_row(
    robot: str, name: str, mine: pd.DataFrame, rival: pd.DataFrame
) -> dict[str, Any]:
    row: dict[str, Any] = {
        "robot": robot_title(robot),
        "name": f"{TITLES.get(name, name)} ({mine.model.iloc[0]})",
        "trainings": len(mine),
        "parameters": int(mine.parameters.iloc[0]),
        "train_s": float(mine.train_s.mean()),
        "multiply_adds": float(mine.multiply_adds.mean()) / 1e12,
        "poses_seen": int(mine.poses_seen.mean()),
        **{metric: float(mine[metric].mean()) for metric in METRICS},
        "success_10mm_20deg": float(mine.success_10mm_20deg.mean()),
    }
    if name == RIVAL or len(mine) < 2 or len(rival) < 2:
        return row
    intervals = [welch(mine[metric], rival[metric]) for metric in METRICS]
    for key, (middle, low, high) in zip(("position", "rotation"), intervals, strict=True):
        row[f"{key}_difference"] = f"{middle:+.3g} [{low:+.3g}, {high:+.3g}]".replace("-", "−")
    row["verdict"] = _verdict(intervals)
    return row


def _verdict(intervals: list[tuple[float, float, float]]) -> str:
    if all(high < 0 for _, _, high in intervals):
        return "beats it"
    if all(low > 0 for _, low, _ in intervals):
        return "is beaten"
    return "not shown to be better in both errors"


def _number(row: pd.Series, name: str) -> float | None:
    return float(row[name]) if name in row and pd.notna(row[name]) else None
