"""What the command line offers: stages and their sweeps, and commands for looking around."""

from __future__ import annotations

from collections.abc import Callable

from pipeline.commands.benchmark import benchmark
from pipeline.commands.chat import chat
from pipeline.commands.compare import compare
from pipeline.commands.dvc import code, dvc
from pipeline.commands.export_weights import export_weights
from pipeline.commands.look import doctor, paths, robot, robots, solvers
from pipeline.commands.readme import readme
from pipeline.commands.run import everything, stage
from pipeline.commands.table import table

Command = Callable[[list[str]], int]
COMMANDS: dict[str, Command] = {
    "all": everything,
    "benchmark": benchmark,
    "chat": chat,
    "robots": robots,
    "robot": robot,
    "solvers": solvers,
    "compare": compare,
    "code": code,
    "doctor": doctor,
    "dvc": dvc,
    "paths": paths,
    "readme": readme,
    "export-weights": export_weights,
    "table": table,
}

__all__ = ["COMMANDS", "stage"]
