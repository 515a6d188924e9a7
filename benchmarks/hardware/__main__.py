"""What must the hardware have been like? Errors under which the published grasps are likely.

    python -m benchmarks.hardware [--robots nico nicol] [--trials 320] [--check 100] [--rounds 3]
                                  [--as-is] [--write] [key=value ...]

The simulator's trials succeed nearly always, those of the robots 72 and 82 times in 100. Trials on
the pinned placements, each with errors of its own sizes (place, zeros, play, tension, friction,
masses), and `--check` without any give the chances of the outcomes as a function of the errors;
then the smallest errors are sought that the published counts do not contradict, and those with
which the counts are likely. `--check` trials are run with the latter and fitted too, `--rounds`
times: a model is best where it is asked.

Rows are kept as they are made, below results/hardware: the command may be killed and given again,
with more trials too. `--as-is` runs nothing; `--write` writes hardware.{csv,md,png} into
results/studies.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Mapping

import numpy as np
import pandas as pd

from benchmarks.grasp_rows import grasp_arguments
from benchmarks.hardware.chances import CLASSES
from benchmarks.hardware.drawing import draw
from benchmarks.hardware.errors import ERRORS
from benchmarks.hardware.explanation import Explanation, explain
from benchmarks.hardware.tables import LAST_RUN, NONE_RUN, Robot, outcomes, tables
from benchmarks.hardware.trials import SEED, design, run
from benchmarks.studies import STUDIES, write_study
from pipeline.grasping.outcome import DETECTION, LANGUAGE
from pipeline.grasping.placements import TRIALS, pinned_version
from pipeline.locations import published_results
from pipeline.presentation.naming import robot_title
from pipeline.presentation.published import Published, read_published
from pipeline.presentation.style import save, styled
from pipeline.provenance import digest

NAME, DPI, DIGITS = "hardware", 150, 6
FEWEST = 60  # trials that a model is fitted to
SHARES = [f"share_{error.key}" for error in ERRORS]
COLUMNS = [
    *("robot", "run", "solver", "number", "trial", "seed", "object", *SHARES),
    *("class", "reason", "lifted", "tracking_error_mm", "pushed_mm", "closing_share", "wall_s"),
]


def arguments() -> argparse.Namespace:
    parser = grasp_arguments(__doc__, ["nico", "nicol"])
    parser.add_argument("--trials", type=int, default=320, help="with errors of many sizes")
    parser.add_argument(
        "--check", type=int, default=100, help="with none, and with the best errors"
    )
    parser.add_argument(
        "--rounds", type=int, default=3, help="of best errors, run and fitted again"
    )
    options = parser.parse_args()
    if options.trials < FEWEST:
        parser.error(f"--trials must be {FEWEST} at least: a model is fitted to them")
    if not 1 <= options.check <= TRIALS:
        parser.error(f"--check must be 1 to {TRIALS}, the number of placements")
    return options


def main() -> None:
    options = arguments()
    published = read_published(published_results())
    robots: list[Robot] = []
    parts: list[pd.DataFrame] = []
    networks: set[str] = set()
    for robot in options.robots:
        same = (options.overrides, options.as_is)
        none, network = run(robot, np.zeros((options.check, len(ERRORS))), "none", *same)
        many, _ = run(robot, design(options.trials), "design", *same)
        if many.empty:
            raise SystemExit("no trial has been run yet: leave out --as-is")
        made = {"no error": none, "many errors": many}
        counted = counts(published, robot)
        for number in range(options.rounds):
            best = fitted(made, counted).best
            name = f"best-{digest(best.tolist())[:12]}"
            made[f"best errors of round {number + 1}"], _ = run(
                robot, np.tile(best, (options.check, 1)), name, *same
            )
        found = fitted(made, counted)
        runs = {NONE_RUN: outcomes(none)} if len(none) else {}
        last = [*made.values()][-1]
        if options.rounds and len(last):
            runs[LAST_RUN] = outcomes(last)
        parts += [part.assign(run=name) for name, part in made.items() if len(part)]
        robots.append(Robot(robot, found, sum(map(len, made.values())), runs))
        networks.add(network)
    said = text_of(robots, published)
    print(said)
    if options.write:
        table = pd.concat(parts, ignore_index=True)[COLUMNS].round(DIGITS)
        which = ["--robots", *options.robots, "--trials", str(options.trials)]
        which += ["--check", str(options.check), "--rounds", str(options.rounds)]
        which += ["--write", *options.overrides]
        command = shlex.join(["python", "-m", "benchmarks.hardware", *which])
        seeds = f"{table['seed'].min()} to {table['seed'].max()}, of sizes {SEED}"
        write_study(NAME, table, said, command, seeds, networks=", ".join(sorted(networks - {""})))
        with styled():
            save(draw(robots), STUDIES, NAME, DPI)


def fitted(made: Mapping[str, pd.DataFrame], counted: np.ndarray) -> Explanation:
    """Explain published counts by all trials that were made."""
    rows = pd.concat(made.values(), ignore_index=True)
    shares, places = rows[SHARES].to_numpy(np.float64), rows["trial"].to_numpy(np.int64)
    return explain(shares, outcomes(rows), places, counted)


def counts(published: Published, robot: str) -> np.ndarray:
    """Published trials by class, of those that neither detection nor language model lost."""
    keys = ("success", "slipped", "not_grasped")
    return np.array([published.number("grasping", robot, "cycleik", key) or 0.0 for key in keys])


def text_of(robots: list[Robot], published: Published) -> str:
    """The study in Markdown."""
    parts = [table.to_markdown().partition("\n")[2] for table in tables(robots)]
    lines = [f"- Range of {error.title}: {error.source}." for error in ERRORS]
    for each in robots:
        foretold = each.found.chances
        lines.append(
            f"- {robot_title(each.robot)}: multinomial logistic model of {each.trials} trials "
            f"(penalty {foretold.penalty:g}); it foretells a trial that it has not seen "
            f"{foretold.gain:.2f} nat better than the classes' frequencies do. Of the refits "
            f"{each.found.explained:.0%} explain the counts."
        )
        lost = [
            f"{published.number('grasping', each.robot, 'cycleik', key) or 0:.0f} to {name}"
            for key, name in (("detection", DETECTION), ("llm", LANGUAGE))
        ]
        lines.append(
            f"- {robot_title(each.robot)}: the paper lost {' and '.join(lost)}, which no error of "
            "arm, hand or place explains."
        )
    lines.append(
        "- What the counts cannot decide is the width of *not contradicted*: two numbers, the "
        "slipped and the not grasped of a robot, cannot tell six errors apart."
    )
    versions = ", ".join(f"{each.robot} {pinned_version(each.robot)}" for each in robots)
    lines.append(f"- Classes: {', '.join(CLASSES)}. Placements: {versions}.")
    return "\n".join([*parts, *lines])


if __name__ == "__main__":
    main()
