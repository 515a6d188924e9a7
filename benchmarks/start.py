"""What a user waits for before the first answer, beside the limits that were set.

    python benchmarks/start.py

Each figure is the median processor time of fresh processes, so that other work on the machine
counts little; `compiling` is of a process with an empty cache of compiled code. The help of a stage
is a second call: the first one after an edit composes the configuration.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from statistics import median

ROUNDS = 5
SOLVERS = ("lm", "cycleik_refined")
FIRST_IMPORT = "from pipeline import load_robot, load_solver"
FIRST_ANSWER = """
import sys, time
from numba.core import event
class Compiling(event.Listener):
    depth, begin, total = 0, 0.0, 0.0
    def on_start(self, event):
        if self.depth == 0:
            self.begin = time.thread_time()
        self.depth += 1
    def on_end(self, event):
        self.depth -= 1
        if self.depth == 0:
            self.total += time.thread_time() - self.begin
compiling = Compiling()
event.register("numba:compile", compiling)
from pipeline import load_robot, load_solver
robot = load_robot("panda")
poses = robot.forward_kinematics(robot.sample(1))
assert load_solver(sys.argv[1], robot).solve(poses).found.all()
print(compiling.total)
"""


def main() -> None:
    print(f"{'':42} {'s':>6} {'limit':>6}")
    for title, seconds, limit in measured():
        print(f"{title:42} {seconds:6.2f} {limit:6.2f}{'' if seconds <= limit else '  NOT KEPT'}")


def measured() -> Iterator[tuple[str, float, float]]:
    """Yield what is measured, its time [s] and its limit [s]."""
    yield FIRST_IMPORT, _median(["-c", FIRST_IMPORT]), 0.6
    yield "python -m pipeline --help", _median(["-m", "pipeline", "--help"]), 0.3
    stage = ["-m", "pipeline", "train", "--help"]
    processor_s(stage)
    yield "python -m pipeline train --help", _median(stage), 0.3
    for solver in SOLVERS:
        with tempfile.TemporaryDirectory() as empty:
            _, said = run(["-c", FIRST_ANSWER, solver], {"NUMBA_CACHE_DIR": empty})
        yield f"compiling for a first answer of {solver}", float(said), 15.0


def processor_s(arguments: list[str]) -> float:
    """Return the processor time [s] of a Python process with some arguments."""
    return run(arguments)[0]


def run(arguments: list[str], more: Mapping[str, str] | None = None) -> tuple[float, str]:
    """Run Python; returns its processor time [s] and what it printed.

    Args:
        arguments: Of the interpreter.
        more: Variables of the environment.
    """
    before = _children_s()
    done = subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, **(more or {})},
        check=True,
        capture_output=True,
        text=True,
    )
    return _children_s() - before, done.stdout


def _median(arguments: list[str]) -> float:
    return median(processor_s(arguments) for _ in range(ROUNDS))


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
