"""Harder than the paper: clutter, unseen objects, a shake, the whole table, second chances.

    python -m benchmarks.harder [--robots nico nicol] [--trials 100] [--settings clutter ...]
                                [--as-is] [--write] [key=value ...]

Each beside the trials that it is harder than: *clutter* and *spoken* beside the paper's protocol
(rows of objects, camera, agent), *retries* beside the same with a calibration error of the eye,
*shake*, *unseen* and *table* beside single objects at known places.
Rows are kept as they are made, below results/harder: the command may be killed and given again,
with more trials too, up to the 100 that are pinned. `--write` renews
results/studies/harder.{csv,md} after every series, `--as-is` with what is kept, without a trial.
"""

from __future__ import annotations

import argparse
import shlex
from dataclasses import dataclass

import pandas as pd

from benchmarks.grasp_rows import grasp_arguments, trials
from benchmarks.studies import write_study
from pipeline.grasping.placements import pinned_version
from pipeline.locations import results
from pipeline.presentation.columns import ROBOT, count, number, share, text, under
from pipeline.presentation.naming import OUTCOMES
from pipeline.presentation.table import Table
from pipeline.reporting.topics.outcomes import SUCCESS_COLUMNS, Counted

PINNED = "grasp.placements=pinned"
ROWS, SINGLE = ["perception=camera", "agent=policy"], ["perception=perfect", "agent=none"]
OFF = ["perception=miscalibrated", "agent=policy"]
SETTINGS = {
    "protocol": ("the paper's protocol", [*ROWS, PINNED]),
    "clutter": ("clutter, gaps of 1 to 4 cm", ["experiment=clutter"]),
    "spoken": ("the sentence spoken and recognised", ["experiment=spoken", PINNED]),
    "off": ("the paper's protocol, eye off by its calibration error", [*OFF, PINNED]),
    "retries": ("the same, up to three times", ["experiment=retries", *OFF, PINNED]),
    "single": ("single objects, known places", [*SINGLE, PINNED]),
    "shake": ("the same, shaken after the lift", ["experiment=shake", *SINGLE, PINNED]),
    "unseen": ("single unseen objects, known places", ["experiment=grasp_unseen"]),
    "table": ("single objects on the whole table", ["experiment=whole_table"]),
}
COLUMNS = [  # of the raw rows, that the study keeps
    *("setting", "robot", "solver", "trial", "row", "object", "x_m", "y_m", "yaw_rad", "seed"),
    *("placements", "class", "reason", "order", "attempts", "lifted", "pushed_mm"),
    *("heard", "word_error_rate", "wall_s"),
]
DIGITS, CONFIDENCE = 6, 0.95


@dataclass(frozen=True, kw_only=True)
class Line(Counted):
    """Trials of a robot in one setting."""

    setting: str

    @property
    def title(self) -> str:
        """The setting for people."""
        return SETTINGS[self.setting][0]

    @property
    def trial_s(self) -> float:
        """Median time of a trial [s]."""
        assert self.rows is not None
        return float(self.rows["wall_s"].median())

    @property
    def attempts(self) -> float:
        """Mean number of grasps of an object, where several were allowed."""
        assert self.rows is not None
        several = self.setting == "retries"
        return float(self.rows["attempts"].mean()) if several else float("nan")

    @property
    def word_errors(self) -> float:
        """Mean share of words that were not heard as said, where something was spoken."""
        assert self.rows is not None
        return (
            float(self.rows["word_error_rate"].mean()) if self.setting == "spoken" else float("nan")
        )


def arguments() -> argparse.Namespace:
    parser = grasp_arguments(__doc__, ["nico", "nicol"])
    parser.add_argument("--trials", type=int, default=100, help="of each robot in each setting")
    parser.add_argument("--settings", nargs="+", choices=[*SETTINGS], default=[*SETTINGS])
    return parser.parse_args()


def main() -> None:
    options = arguments()
    parts: list[pd.DataFrame] = []
    networks: set[str] = set()
    for setting in options.settings:
        for robot in options.robots:
            keys = [f"robot={robot}", *SETTINGS[setting][1], f"grasp.trials={options.trials}"]
            keys += ["grasp.video=none", "grasp.protocol.evidence=failures"]
            keys += [f"results_dir={results() / 'harder' / setting}", *options.overrides]
            made = trials(keys, f"{robot} {setting}", options.as_is)
            parts.append(made.rows().assign(setting=setting))
            networks.add(made.network)
            rows = pd.concat(parts, ignore_index=True)
            if options.write and len(rows):
                write(rows, networks, options)
    if rows.empty:
        raise SystemExit("no trial has been run yet: leave out --as-is")
    print(text_of(rows, options.robots))


def write(rows: pd.DataFrame, networks: set[str], options: argparse.Namespace) -> None:
    """Write the study."""
    which = ["--robots", *options.robots, "--trials", str(options.trials)]
    if options.settings != [*SETTINGS]:
        which += ["--settings", *options.settings]
    command = ["python", "-m", "benchmarks.harder", *which, "--write", *options.overrides]
    write_study(
        "harder",
        rows.reindex(columns=COLUMNS).round(DIGITS),
        text_of(rows, options.robots),
        shlex.join(command),
        seeds=", ".join(map(str, sorted(rows["seed"].unique()))),
        networks=", ".join(sorted(networks - {""})),
    )


def text_of(rows: pd.DataFrame, robots: list[str]) -> str:
    """The study in Markdown."""
    lines = [
        Line(str(robot), "success", part, CONFIDENCE, setting=str(setting))
        for (robot, setting), part in rows.groupby(["robot", "setting"], sort=False)
    ]
    lines.sort(key=lambda line: (robots.index(line.robot), [*SETTINGS].index(line.setting)))
    classes = {key: title for key, title in OUTCOMES.items() if key != "success"}
    table = Table.of(
        lines,
        (
            ROBOT,
            text("setting", "setting", "title"),
            *SUCCESS_COLUMNS,
            *under(
                "lost",
                *(
                    count(key, title, lambda line, key=key: line.ended(key))
                    for key, title in classes.items()
                ),
            ),
            number("attempts", "grasps an object", "attempts"),
            share("word_errors", "word errors [%]"),
            number("trial_s", "s a trial", "trial_s"),
        ),
        name="harder",
        title="Harder than the paper",
        caption="Success with 95 % Wilson intervals, lost trials by class, median time of a trial. "
        "Unseen: ten further objects, for NICO's small hand the lightest five. Up to three times: "
        "the sentence is said again while something is seen on the table. Whole table: anywhere "
        "between the bins, out of reach too. Spoken: by several voices in white noise.",
    )
    versions = ", ".join(f"{robot} {pinned_version(robot)}" for robot in robots)
    shown = table.to_markdown().partition("\n")[2]
    drawn = "drawn for clutter, unseen objects and the whole table"
    return f"{shown}\nPlacements: {versions}; {drawn}."


if __name__ == "__main__":
    main()
