"""Who is to blame for lost grasps: every part of the chain replaced by an oracle, in all ways.

    python -m benchmarks.ladder [--trials 100] [--robots nico nicol] [--agents policy]
                                [--replay FILE] [--cells camera/policy/cycleik ...] [--as-is]
                                [--write] [key=value ...]

Perception {with calibration error, camera, true places} x agent {policy} x solver {CycleIK, refined
CycleIK} on the pinned initial states of each robot. Rows are kept as they are made, below
results/ladder: the command may be killed and given again, with more trials too. `--write` renews
results/studies/ladder.{csv,md} after every cell, `--as-is` with what is kept, without a trial.

A language model joins in with `--agents local policy`, or `endpoint` and the keys of
`agent.endpoint`. What it answers is kept, with `--write` in results/studies/ladder_messages.jsonl
too, and `--replay FILE` repeats its trials without it.
"""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from benchmarks.grasp_rows import trials
from benchmarks.ladder.cells import AGENTS, cells, keep_messages
from benchmarks.ladder.owners import with_owners
from benchmarks.ladder.tables import tables
from benchmarks.studies import STUDIES, write_study
from pipeline.config import compose
from pipeline.grasping.placements import pinned_version

COLUMNS = [  # of the raw rows, that the study keeps
    *("robot", "perception", "agent", "solver", "trial", "row", "object", "x_m", "y_m", "yaw_rad"),
    *("seed", "placements", "rate_hz", "iterations", "class", "reason", "owner", "order"),
    *("seen_as", "score", "sighting_error_mm", "lifted", "bin", "reach_error_mm", "pushed_mm"),
    *("tracking_error_mm", "closing_share", "approach_tip_error_mm", "deposit_tip_error_mm"),
    *("turns", "problem", "wall_s"),
]
MESSAGES = "ladder_messages.jsonl"
DIGITS = 6  # decimals of numbers in the CSV
NOTE = """\
- Calibration error: the eye's pose is off by {translation:g} mm and {rotation:g} mrad, in one \
direction and about one axis for all trials of a robot; another draw gives other numbers.
- Trials of one row share a table: what one of them knocks over, a later one finds there.
- How much of a difference is the simulator's own chance: `python -m benchmarks.noise_floor`.
- Times are those of a clock on the wall: other work on the machine lengthens them.
- Placements: {placements}.
- A trial again, in the browser: `python -m pipeline watch robot=nico trial=17 perception=camera \
agent=policy grasp.solver=cycleik grasp.placements=pinned`."""


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--trials", type=int, default=100, help="of each cell")
    parser.add_argument("--robots", nargs="+", default=["nico", "nicol"])
    parser.add_argument("--agents", nargs="+", choices=AGENTS, default=["policy"])
    parser.add_argument("--replay", type=Path, help="file that models answer from")
    parser.add_argument("--cells", nargs="+", help="perception/agent/solver; all where left out")
    parser.add_argument("--as-is", action="store_true", help="run nothing: what is kept")
    parser.add_argument("--write", action="store_true", help="into results/studies")
    parser.add_argument("overrides", nargs="*", help="such as engine.workers=4")
    options = parser.parse_args()
    known = [cell.name for cell in cells(options.robots[:1], options.agents)]
    if unknown := {*(options.cells or [])} - {*known}:
        parser.error(f"no cell {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    return options


def main() -> None:
    options = arguments()
    wanted = [
        cell
        for cell in cells(options.robots, options.agents)
        if not options.cells or cell.name in options.cells
    ]
    parts: list[pd.DataFrame] = []
    networks: list[str] = []
    for cell in wanted:
        keys = [*cell.overrides(options.trials, options.replay), *options.overrides]
        made = trials(keys, f"{cell.robot} {cell.name}", options.as_is)
        parts.append(made.rows())
        networks.append(made.network)
        rows = pd.concat(parts, ignore_index=True)
        if options.write and len(rows):
            write(rows, networks, options)
    if rows.empty:
        raise SystemExit("no trial has been run yet: leave out --as-is")
    print(text_of(with_owners(rows), options.robots))


def write(rows: pd.DataFrame, networks: Sequence[str], options: argparse.Namespace) -> None:
    """Write the study."""
    owned = with_owners(rows)
    which = ["--trials", str(options.trials), "--robots", *options.robots]
    replayed = ["--replay", str(options.replay)] if options.replay else []
    which += ["--agents", *options.agents, *replayed, "--write"]
    which += ["--cells", *options.cells] if options.cells else []
    command = shlex.join(["python", "-m", "benchmarks.ladder", *which, *options.overrides])
    keep_messages(cells(options.robots, options.agents), STUDIES / MESSAGES)
    write_study(
        "ladder",
        owned[COLUMNS].round(DIGITS),
        text_of(owned, options.robots),
        command,
        seeds=", ".join(map(str, sorted(owned["seed"].unique()))),
        networks=", ".join(sorted({*networks} - {""})),
    )


def text_of(rows: pd.DataFrame, robots: Sequence[str]) -> str:
    """The study in Markdown."""
    wrong = compose(["perception=miscalibrated"]).perception.calibration_error
    note = NOTE.format(
        translation=1e3 * wrong.translation,
        rotation=1e3 * wrong.rotation,
        placements=", ".join(f"{robot} {pinned_version(robot)}" for robot in robots),
    )
    shown = [table.to_markdown().partition("\n")[2] for table in tables(rows)]
    return "\n".join([*shown, note])


if __name__ == "__main__":
    main()
