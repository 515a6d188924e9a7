"""How much of a grasp's outcome is the simulator's own chance?

    python -m benchmarks.noise_floor [--robots nico nicol] [--trials 20] [--seeds 10]
                                     [--rates 120 240 480] [--as-is] [--write] [key=value ...]

The same pinned trials with every object laid a micrometre off its place (experiment=grasp_noise):
nobody could see or place that, so trials that end otherwise are noise, and a difference between two
solvers or two perceptions has to be larger. Rows are kept as they are made, below
results/noise_floor: the command may be killed and given again, with more trials too. `--as-is` runs
nothing; `--write` writes results/studies/noise_floor.{csv,md}.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
import pandas as pd

from benchmarks.grasp_rows import grasp_arguments, trials
from benchmarks.studies import write_study
from pipeline.grasping.outcome import SUCCESS
from pipeline.grasping.placements import pinned_version
from pipeline.locations import results
from pipeline.presentation.columns import ROBOT, count, number, share, text, under
from pipeline.presentation.table import Table

COLUMNS = [  # of the raw rows, that the study keeps
    *("robot", "solver", "rate_hz", "noise_seed", "trial", "object", "x_m", "y_m", "yaw_rad"),
    *("class", "reason", "lifted", "bin", "pushed_mm", "closing_share", "wall_s"),
]
DIGITS = 6  # decimals of numbers in the CSV


@dataclass(frozen=True)
class Rate:
    """Trials of a robot at one rate of the physics.

    Attributes:
        robot: Its name.
        rate: Of the physics [Hz].
        success: A line a trial, a column a seed; trials that lack a seed are left out.
        trial_s: Median time of a trial [s].
    """

    robot: str
    rate: float
    success: pd.DataFrame
    trial_s: float

    @property
    def by_seed(self) -> pd.Series:
        """Share of successes with each seed."""
        return self.success.mean()

    @property
    def by_trial(self) -> pd.Series:
        """Share of the seeds with which each trial succeeded."""
        return self.success.mean(axis=1)

    @property
    def undecided(self) -> int:
        """How many trials succeed with some seeds and fail with others."""
        return int(((self.by_trial > 0) & (self.by_trial < 1)).sum())


def disagreement(first: Rate, second: Rate) -> float:
    """How often one and the same trial ends otherwise with another seed, or at another rate.

    With shares p and q of the seeds that a trial succeeds with, two runs differ with probability
    p (1 - q) + q (1 - p). Two different seeds of one rate: 2 k (n - k) / (n (n - 1)) where k of n
    seeds succeed. Mean over the trials; not a number with a single seed.
    """
    both = first.success.index.intersection(second.success.index)
    p, q = first.by_trial[both], second.by_trial[both]
    if first is not second:
        return float((p * (1 - q) + q * (1 - p)).mean())
    seeds = first.success.shape[1]
    return float((2 * p * (1 - p)).mean() * seeds / (seeds - 1)) if seeds > 1 else np.nan


def rates_of(rows: pd.DataFrame) -> Iterator[Rate]:
    """Yield the trials by robot and rate."""
    for (robot, rate), part in rows.groupby(["robot", "rate_hz"], sort=False):
        success = part.assign(success=part["class"] == SUCCESS).pivot(
            index="trial", columns="noise_seed", values="success"
        )
        whole = success.dropna().astype(bool)
        yield Rate(str(robot), float(rate), whole, float(part["wall_s"].median()))


def tables(rows: pd.DataFrame) -> Iterator[Table]:
    """Yield the tables of the study."""
    found = list(rates_of(rows))
    yield Table.of(
        found,
        (
            ROBOT,
            number("rate_hz", "rate [Hz]", "rate"),
            count("seeds", "seeds", lambda line: line.success.shape[1]),
            count("trials", "trials", lambda line: len(line.success)),
            *under(
                "success by seed [%]",
                share("mean", "mean", lambda line: line.by_seed.mean()),
                share("least", "least", lambda line: line.by_seed.min()),
                share("most", "most", lambda line: line.by_seed.max()),
            ),
            count("always", "always won", lambda line: int((line.by_trial == 1).sum())),
            count("never", "always lost", lambda line: int((line.by_trial == 0).sum())),
            count("undecided", "now and then", "undecided"),
            number("trial_s", "s a trial", "trial_s"),
        ),
        name="noise_floor",
        title="Noise floor",
        caption="The same pinned trials with every object a micrometre off its place, in another "
        "direction with each seed. Trials by how they end: always won, always lost, or won with "
        "some seeds only.",
    )
    pairs = [
        (first, second)
        for first, second in combinations_with_replacement(found, 2)
        if first.robot == second.robot
    ]
    yield Table.of(
        pairs,
        (
            ROBOT_OF_PAIR,
            text("rates", "rates [Hz]", lambda pair: f"{pair[0].rate:g}, {pair[1].rate:g}"),
            share("disagreement", "ends otherwise [%]", lambda pair: disagreement(*pair)),
        ),
        name="noise_floor_pairs",
        title="How often a trial ends otherwise",
        caption="The same trial with two seeds, at one rate of the physics or at two. In a "
        "comparison of two runs so many trials in a hundred differ by chance, half of them to "
        "either side.",
    )


ROBOT_OF_PAIR = text("robot", "Robot", lambda pair: ROBOT.cell({"robot": pair[0].robot}))


def arguments() -> argparse.Namespace:
    parser = grasp_arguments(__doc__)
    parser.add_argument("--trials", type=int, default=20, help="with each seed at each rate")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--rates", type=float, nargs="+", default=[120.0, 240.0, 480.0])
    return parser.parse_args()


def main() -> None:
    options = arguments()
    parts: list[pd.DataFrame] = []
    networks: list[str] = []
    for robot in options.robots:
        made = trials(overrides(robot, options), robot, options.as_is)
        parts.append(made.rows())
        networks.append(made.network)
    rows = pd.concat(parts, ignore_index=True)
    if rows.empty:
        raise SystemExit("no trial has been run yet: leave out --as-is")
    said = [table.to_markdown().partition("\n")[2] for table in tables(rows)]
    said.append(f"Placements: {', '.join(f'{r} {pinned_version(r)}' for r in options.robots)}.")
    print("\n".join(said))
    if options.write:
        which = ["--robots", *options.robots, "--trials", str(options.trials)]
        which += ["--seeds", str(options.seeds), "--rates", *(f"{r:g}" for r in options.rates)]
        command = ["python", "-m", "benchmarks.noise_floor", *which, "--write", *options.overrides]
        write_study(
            "noise_floor",
            rows[COLUMNS].round(DIGITS),
            "\n".join(said),
            shlex.join(command),
            seeds=f"of placement noise 0 to {options.seeds - 1}",
            networks=", ".join(sorted({*networks} - {""})),
        )


def overrides(robot: str, options: argparse.Namespace) -> list[str]:
    """The keys of a robot's study; `python -m pipeline grasp` takes them as well."""
    return [
        "experiment=grasp_noise",
        f"robot={robot}",
        f"grasp.trials={options.trials}",
        f"grasp.ablation.vary.noise_seed={[*range(options.seeds)]}",
        f"grasp.ablation.vary.rate={options.rates}",
        f"results_dir={results() / 'noise_floor'}",
        *options.overrides,
    ]


if __name__ == "__main__":
    main()
