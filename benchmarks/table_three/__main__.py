"""Table III with rows of our own: every learned method on the same poses, with equal training time.

    python -m benchmarks.table_three [--minutes 3] [--robots panda valkyrie] [--poses 1000]
                                     [--write] [key=value ...]

Each method is trained for the same time of one core, by the rates of results/rates.csv. Trainings
that ended with that length are kept and one that was stopped goes on: the command may be killed
and given again. Errors are of poses of the test set: of single draws, as IKFlow reports them, and
of the solvers' answers, the best of several draws by forward kinematics. Times are those of calls
of 100 poses.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import pandas as pd

from benchmarks.studies import write_study
from benchmarks.table_three.measures import CALL, DRAWS, SEED, measured
from benchmarks.table_three.training import trained, training_of
from pipeline import load_robot
from pipeline.config import compose
from pipeline.data.dataset import read_split
from pipeline.learning.card import shipped_weights
from pipeline.locations import published_results
from pipeline.presentation.naming import robot_title, solver_title
from pipeline.presentation.published import read_published
from pipeline.reporting.topics.paper import NETWORKS
from pipeline.stages.inputs import dataset_of

NAME = "table_three"
METHODS = {  # models by robot: those that the paper or its related work has numbers for
    "panda": ("compact", "gan", "iknet", "flow", "node_ik", "eem"),
    "valkyrie": ("compact", "flow", "eem"),
}
SOLVERS = {"compact": "cycleik"}  # of models that are called otherwise
PUBLISHED_AXES = ("cycleik",)  # whose published errors are means over the axes
MINUTES = 3.0  # of one core: about what the quick profile's recipe of the compact network takes


def main() -> None:
    """Train, measure, print and, if asked, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--minutes", type=float, default=MINUTES)
    parser.add_argument("--robots", nargs="+", choices=METHODS, default=[*METHODS])
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--write", action="store_true", help="into results/studies")
    parser.add_argument("overrides", nargs="*", help="such as results_dir=results/slow")
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for robot in options.robots:
        rows += published(robot)
        rows += ours(robot, options.minutes, options.poses // CALL * CALL, options.overrides)
    table = pd.DataFrame(rows)
    text = described(table, options.minutes, options.poses)
    print(text)
    if options.write:
        which = ["--minutes", f"{options.minutes:g}", "--robots", *options.robots]
        which += ["--poses", str(options.poses), "--write", *options.overrides]
        command = shlex.join(["python", "-m", "benchmarks.table_three", *which])
        profile = compose(options.overrides).profile
        seeds = f"of weights, order and poses 0, of draws {SEED}"
        write_study(NAME, table, text, command, seeds, profile)


def published(robot: str) -> list[dict[str, Any]]:
    """Rows of the paper's table."""
    source = read_published(published_results())
    rows = []
    for method in source.methods(NETWORKS, robot):
        errors = [
            source.number(NETWORKS, robot, method, f"{kind}_error_mean")
            for kind in ("position", "rotation")
        ]
        prefix = "paper_" if method in PUBLISHED_AXES else ""
        rows.append(
            {
                "robot": robot,
                "method": method,
                "source": "published",
                f"{prefix}position_mm": errors[0],
                f"{prefix}rotation_deg": errors[1],
                "call_ms": source.number(NETWORKS, robot, method, "time_per_batch_of_100"),
            }
        )
    return rows


def ours(robot: str, minutes: float, count: int, overrides: Sequence[str]) -> list[dict[str, Any]]:
    """Two rows a network of a robot: its single draws, and the answers of its solver."""
    folders = {
        (model, "equal time"): trained(robot, model, minutes, overrides) for model in METHODS[robot]
    }
    folders["compact", "comes with the project"] = shipped_weights(robot)
    config = compose([*overrides, f"robot={robot}"])
    known = load_robot(robot)
    poses = read_split(dataset_of(config), "test", known).poses[:count]
    rows = []
    for (model, trained_how), folder in folders.items():
        solver = SOLVERS.get(model, model)
        result = measured(known, solver, folder, poses)
        print(f"{robot} {model} measured", flush=True)
        draws = f"mean of {DRAWS} draws" if model != "compact" else "mean of 4 hypotheses"
        facts = {"robot": robot, "method": solver, "source": trained_how}
        facts |= asdict(training_of(folder))
        rows += [
            {**facts, "of": draws, **asdict(result.draws), "call_ms": result.draws_ms},
            {
                **facts,
                "of": f"best of {result.answers_of}",
                **asdict(result.answers),
                "call_ms": result.answers_ms,
            },
        ]
    return rows


def described(table: pd.DataFrame, minutes: float, count: int) -> str:
    """The table for people."""
    lines = [
        "# Table III: neural solvers, the published numbers and ours",
        "",
        f"*Equal time*: trained for {minutes:g} minutes of one core, by the rates of",
        "results/rates.csv; the processor time that it took stands beside. Networks other than",
        "CycleIK's are reduced re-implementations, trained for minutes where their authors trained",
        "for hours or days: the rows say what minutes give, not what the methods can reach.",
        f"Errors of {count:,} poses of the test set. *mean of draws*: every draw counts with its",
        "own error, as IKFlow reports; *best of*: the draw that forward kinematics finds nearest,",
        "which is what the solver answers. Euclidean and geodesic errors stand apart from the",
        "paper's means over the axes. *100 poses*: median processor time of a call, one thread;",
        "published times are of graphics processors.",
        "",
        "| robot | method | source | errors | Euclidean, mm | geodesic, deg | axes, mm | axes, deg "
        "| 100 poses, ms | parameters | poses seen | training, s | device |",
        "|---|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---|",
    ]
    for row in table.to_dict("records"):
        errors = ("position_mm", "rotation_deg", "paper_position_mm", "paper_rotation_deg")
        cells = [
            robot_title(row["robot"]),
            solver_title(row["method"]),
            row["source"],
            _text(row["of"]),
            *(_number(row[name], ".3g") for name in errors),
            _number(row["call_ms"], ".3g"),
            *(_number(row[name], ",.0f") for name in ("parameters", "poses", "seconds")),
            _text(row["device"]),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _number(value: float | None, form: str) -> str:
    return "–" if value is None or pd.isna(value) else format(value, form)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else "–"


if __name__ == "__main__":
    main()
