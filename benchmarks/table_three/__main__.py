"""Table III with rows of our own: every learned method on the same poses, with equal training time.

    python -m benchmarks.table_three [--minutes 3] [--robots panda valkyrie] [--poses 1000]
                                     [--as-is] [--write] [key=value ...]

Each method is trained for the same time of one core, by the rates of results/rates.csv. Trainings
that ended with that length are kept and one that was stopped goes on: the command may be killed
and given again. Networks lie in results/table_three, apart from those of a profile. Errors are of
poses of the test set: of single draws, as IKFlow reports them, and of the solvers' answers, the
best of several draws by forward kinematics. Times are those of calls of 100 poses.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.studies import STUDIES
from benchmarks.table_three.measures import CALL, DRAWS, SEED, measured
from benchmarks.table_three.training import trained, training_of
from pipeline import load_robot, provenance
from pipeline.commands.arguments import with_defaults
from pipeline.config import compose
from pipeline.data.dataset import read_split
from pipeline.data.files import write_text
from pipeline.errors import PipelineError
from pipeline.learning.card import shipped_weights
from pipeline.locations import published_results, results
from pipeline.presentation.naming import robot_title, solver_title
from pipeline.presentation.origin import Origin
from pipeline.presentation.published import read_published
from pipeline.presentation.table import write_origin
from pipeline.reporting.evidence import Evidence
from pipeline.reporting.topics.learned import NAME, learned_methods
from pipeline.reporting.topics.paper import NETWORKS
from pipeline.stages.inputs import dataset_of

METHODS = {  # models by robot: those that the paper or its related work has numbers for
    "panda": ("compact", "gan", "iknet", "flow", "node_ik", "eem"),
    "valkyrie": ("flow", "eem"),
}
SOLVERS = {"compact": "cycleik"}  # of models that are called otherwise
PUBLISHED_AXES = ("cycleik",)  # whose published errors are means over the axes
TRAINED = (
    "Equal time: {minutes:g} min of a core by results/rates.csv. Errors: {poses:,} test poses."
)
MINUTES = 3.0  # of one core: about what the quick profile's recipe of the compact network takes


def main() -> None:
    """Train, measure, print and, with --write, write the study."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--minutes", type=float, default=MINUTES)
    parser.add_argument("--robots", nargs="+", choices=METHODS, default=[*METHODS])
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--as-is", action="store_true", help="train nothing: what is there")
    parser.add_argument("--write", action="store_true", help="into results/studies")
    parser.add_argument("overrides", nargs="*", help="such as results_dir=results/slow")
    options = parser.parse_args()
    overrides = with_defaults(options.overrides, {"results_dir": str(results() / NAME)})
    config = compose(overrides)
    count = pose_count(options.poses, config.dataset.test)
    rows: list[dict[str, Any]] = []
    for robot in options.robots:
        rows += published(robot) + table_one(robot)
        rows += ours(robot, options.minutes, count, overrides, options.as_is)
    table = learned_methods(pd.DataFrame(rows))
    which = ["--minutes", f"{options.minutes:g}", "--robots", *options.robots]
    which += ["--poses", str(count), "--write", *options.overrides]
    table.origin = Origin(
        shlex.join(["python", "-m", "benchmarks.table_three", *which]),
        **provenance.signature(config.profile),
        processor=provenance.machine()["processor"],
        seeds=f"of weights, order and poses {config.seed}, of draws {SEED}",
    )
    table.notes.append(TRAINED.format(minutes=options.minutes, poses=count))
    print(table.to_markdown())
    if options.write:
        write_text(STUDIES / f"{table.name}.csv", table.to_csv())
        write_text(STUDIES / f"{table.name}.md", table.to_markdown())
        write_origin(STUDIES, table.name, table.origin)


def pose_count(wanted: int, there_are: int) -> int:
    """Return the poses of as many whole calls as were wanted, one at least.

    Raises:
        PipelineError: The test set has fewer.
    """
    count = max(1, wanted // CALL) * CALL
    if count > there_are:
        raise PipelineError(f"{count} poses are wanted, and the test set has {there_are}")
    return count


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
                "solver": method,
                "source": "published",
                f"{prefix}position_mm": errors[0],
                f"{prefix}rotation_deg": errors[1],
                "call_ms": source.number(NETWORKS, robot, method, "time_per_batch_of_100"),
            }
        )
    return rows


def table_one(robot: str) -> list[dict[str, Any]]:
    """Row of Table I's network, which was trained at the published scale and is committed."""
    evidence, title = Evidence(results()), robot_title(robot)
    cycleik = {"robot": title, "solver": solver_title("cycleik")}
    errors = evidence.line("table2_numerical_comparison", "euclidean_mm", **cycleik)
    training = evidence.line("training", "samples", robot=title, model="paper")
    if errors is None or training is None:
        return []
    call = evidence.number("table3_neural_comparison", "time_per_batch_of_100", **cycleik)
    columns = {
        "position_mm": "euclidean_mm",
        "rotation_deg": "geodesic_deg",
        "paper_position_mm": "position_error_mean",
        "paper_rotation_deg": "rotation_error_mean",
    }
    return [
        {
            "robot": robot,
            "solver": "cycleik",
            "source": f"Table I, {errors[0].poses:,.0f} poses ({errors[1].rpartition('/')[0]})",
            "of": "answers",
            **{name: errors[0][column] for name, column in columns.items()},
            "call_ms": None if call is None else call.value,
            "parameters": training[0].parameters,
            "poses": training[0].samples,
            "device": training[0].device,
        }
    ]


def ours(
    robot: str, minutes: float, count: int, overrides: Sequence[str], as_is: bool
) -> list[dict[str, Any]]:
    """Two rows a network of a robot: its single draws, and the answers of its solver."""
    folders: dict[tuple[str, str], Path | None] = {
        (model, "equal time"): trained(robot, model, minutes, overrides, as_is)
        for model in METHODS[robot]
    }
    folders["compact", "comes with the project"] = shipped_weights(robot)
    config = compose([*overrides, f"robot={robot}"])
    known = load_robot(robot)
    poses = read_split(dataset_of(config), "test", known).poses[:count]
    rows = []
    for (model, trained_how), folder in folders.items():
        if folder is None:
            continue
        solver = SOLVERS.get(model, model)
        result = measured(known, solver, folder, poses)
        print(f"{robot} {model} measured", flush=True)
        draws = f"{DRAWS} draws" if model != "compact" else "4 hypotheses"
        facts = {"robot": robot, "solver": solver, "source": trained_how}
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


if __name__ == "__main__":
    main()
