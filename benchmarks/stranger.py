"""A stranger's path, timed: a fresh clone, a URDF of one's own, a network for it, the page.

    python -m benchmarks.stranger                      # UR5 of example-robot-data, quick scale
    python -m benchmarks.stranger --profile smoke      # whether it works, in minutes
    python -m benchmarks.stranger --write              # results/studies/stranger.csv and .md

Each step is a command of docs/tutorials/stranger.md, typed in a clone that is gone afterwards. Wall
time is what one waits; processor time of all cores counts other work on the machine little. The
time of packages depends on the network, and on whether uv or pip has them in its cache.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import shlex
import subprocess
import sys
import sysconfig
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from benchmarks.studies import write_study
from pipeline.data.tables import read_table

ROOT = Path(__file__).parents[1]
UR5 = "cmeel.prefix/share/example-robot-data/robots/ur_description/urdf/ur5_robot.urdf"
NAME = "my_ur5"
SOLVERS = ["cycleik", "cycleik_refined", "lm"]
FENCE = re.compile(r"^```sh\n(.*?)^```", re.MULTILINE | re.DOTALL)
GOAL_MIN = 8.0
STEPS = {  # by the first words of a command
    "git": "clone",
    "make": "environment, kernels compiled",
    "python -m pipeline robot": "the robot",
    "python -m pipeline evaluate": "poses, network, answers",
    "python -m pipeline report": "the page",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--profile", default="quick", choices=("smoke", "quick"))
    parser.add_argument("--write", action="store_true", help="write results/studies/stranger.*")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        table = walked(Path(folder), options.profile)
    print(table.to_string(index=False))
    minutes = table.wall_s.iloc[-1] / 60
    print(f"{minutes:.1f} min (the goal is {GOAL_MIN:.0f})")
    if options.write:
        command = f"python -m benchmarks.stranger --profile {options.profile} --write"
        text = f"{__doc__.splitlines()[0]}\n\n{table.to_markdown(index=False)}\n"
        write_study("stranger", table, text, command, "0", profile=options.profile)


def walked(folder: Path, profile: str, environment: bool = True) -> pd.DataFrame:
    """Walk the path in a clone below a folder; a row a step, and their sum.

    Args:
        folder: Empty.
        profile: Scale of the run.
        environment: False takes the environment of this process in place of a new one.

    Raises:
        RuntimeError: A step failed, or left nothing.
    """
    rows = []
    clone = folder / "clone"
    for words in commands(sysconfig.get_path("purelib")):
        if words[0] == "make" and not environment:
            continue
        where = clone if clone.exists() else folder
        if words[:3] == ["python", "-m", "pipeline"]:
            words[0] = str(clone / ".venv/bin/python") if environment else sys.executable
            words += [] if words[3] == "robot" else [f"profile={profile}"]
        rows.append([title(words), *timed(words, where)])
    results = clone / "results" / profile
    for solver in SOLVERS:
        found = read_table(results / "evaluate" / NAME / f"{solver}.parquet")
        if not len(found):
            raise RuntimeError(f"there are no rows of {solver}")
    if NAME not in (results / "report.html").read_text(encoding="utf-8"):
        raise RuntimeError(f"{NAME} is not on the page")
    table = pd.DataFrame(rows, columns=["step", "wall_s", "processor_s"])
    table.loc[len(table)] = ["all", table.wall_s.sum(), table.processor_s.sum()]
    return table.round(1)


def commands(packages: str) -> list[list[str]]:
    """Return the commands of the page, with this checkout and the UR5 in their places."""
    page = (ROOT / "docs" / "tutorials" / "stranger.md").read_text(encoding="utf-8")
    lines = "".join(FENCE.findall(page)).replace("\\\n", " ").splitlines()
    places = {"my_ur5.urdf": str(Path(packages) / UR5), "ADDRESS": str(ROOT)}
    found = [
        [places.get(word, word) for word in shlex.split(line, comments=True)] for line in lines
    ]
    return [words for words in found if words and words[0] != "cd"]


def title(words: Sequence[str]) -> str:
    """Return what a command does."""
    line = re.sub(r"^\S*python\S*", "python", " ".join(words))
    return next(text for begin, text in STEPS.items() if line.startswith(begin))


def timed(words: Sequence[str], folder: Path) -> tuple[float, float]:
    """Run a command; returns wall and processor time [s].

    Raises:
        RuntimeError: It failed.
    """
    began, before = time.monotonic(), _children_s()
    clean = {
        key: value for key, value in os.environ.items() if key not in ("MAKEFLAGS", "VIRTUAL_ENV")
    }
    done = subprocess.run(
        words, cwd=folder, env={**clean, "PYTHONPATH": str(folder)}, capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)} failed: {done.stderr[-2000:]}")
    return time.monotonic() - began, _children_s() - before


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
