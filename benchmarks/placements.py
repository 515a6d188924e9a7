"""The pinned initial states of the grasp trials: are they still what the generator gives?

    python -m benchmarks.placements [--write]

Says for each robot whether today's generator gives the committed file. `--write` makes the files
that differ and raises their versions in `pipeline/grasping/pinned/checksums.csv`. Results of
one version are not to be paired with those of another.
"""

from __future__ import annotations

import argparse

import pandas as pd

from pipeline.config import compose
from pipeline.data.files import sha256, write_text
from pipeline.embodiment.row import row_setup
from pipeline.grasping.config import GraspConfig
from pipeline.grasping.placements import CHECKSUMS, FOLDER, ROW, SINGLE, TRIALS, to_text
from pipeline.grasping.trial import trial_setup

SEED = 0


def generated(grasp: GraspConfig, robot: str) -> str:
    """The content of a robot's file by today's generator: a hundred trials of each protocol."""
    width = len(grasp.scenes[robot].objects)
    rows = range(-(-TRIALS // width))  # the last one is whole
    return to_text(
        {
            SINGLE: [trial_setup(grasp, robot, number, SEED) for number in range(TRIALS)],
            ROW: [each for number in rows for each in row_setup(grasp, robot, number, SEED)],
        }
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    grasp = compose(["grasp.placements=drawn"]).grasp
    known = pd.read_csv(CHECKSUMS, index_col="robot") if CHECKSUMS.exists() else pd.DataFrame()
    lines = []
    for robot in sorted(grasp.scenes):
        path, text = FOLDER / f"{robot}.csv", generated(grasp, robot)
        version = int(known.version[robot]) if robot in known.index else 0
        same = path.exists() and path.read_text(encoding="utf-8") == text
        print(f"{robot}: version {version}, {'the same' if same else 'the generator differs'}")
        if options.write and not same:
            write_text(path, text)
            version += 1
        if path.exists():
            lines.append({"robot": robot, "version": version, "sha256": sha256(path)})
    if options.write:
        write_text(CHECKSUMS, pd.DataFrame(lines).to_csv(index=False, lineterminator="\n"))


if __name__ == "__main__":
    main()
