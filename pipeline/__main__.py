"""The command line: `python -m pipeline <command> [overrides]`, also called `cycleik-bench`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence

from pipeline.progress import set_up_logging
from pipeline.stages.graph import STAGES

USAGE = """\
Benchmark for neural inverse kinematics and neuro-robotic grasping.

  python -m pipeline <command> [key=value ...] [-m]

Stages, in the order they build on each other:
{stages}
  all        every stage above but sample and compare-tuned, without DVC: robots=[...]
  benchmark  evaluate the numerical solvers on all robots, unattended: benchmark profile=paper
  chat       talk to a robot at its table, by text or by speech: chat robot=nicol

Looking around:
  robots     the robots, their joints and limits        robot add FILE  bring one of your own
                                                        robot picture NAME  draw one anew
  solvers    the inverse-kinematics solvers and what each needs
  compare    what two results folders changed, in configuration and figures: compare A B
  doctor     versions, threads, accelerator, and what is missing
  paths      where the tables, figures and the report are
  table      Table II or III of the paper from the raw rows, in seconds: table table2
  export-weights
             put trained weights beside the robot's description: export-weights robot=panda
  dvc        write dvc.yaml from the graph of stages; dvc profile=smoke sets that scale as well
  code       write down what code each step depends on: the first thing that DVC runs
  readme     renew the table and the picture of README.md from the last run: readme [ROBOT]

Overrides are Hydra's: robot=nico profile=smoke train.learning_rate=1.0e-4. With -m lists of values
are swept, each run in a results folder of its own: train -m train.loss=former,smooth seed=0,1
`python -m pipeline <command> --help` says more; `make reproduce` runs everything through DVC.
"""
BAD_INPUT, INTERRUPTED = 2, 130
# Commands by their old names, for one release.
ALIASES = {"contest": "compare-tuned", "ship": "export-weights", "where": "paths"}


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; bad input gives one sentence on stderr and status 2."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    set_up_logging()
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        listed = "\n".join(f"  {name:<13} {stage.summary}" for name, stage in STAGES.items())
        print(USAGE.format(stages=listed), end="")
        return 0
    command, rest = arguments[0], arguments[1:]
    try:
        return _command(command)(rest)
    except KeyboardInterrupt:
        print("\ninterrupted; the same command goes on from here", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        return 0
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except (ValueError, ImportError) as error:
        if not _is_ours(error):
            raise
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT


def _command(name: str) -> Callable[[list[str]], int]:
    from pipeline import commands

    name = ALIASES.get(name, name)
    if name in STAGES:
        return lambda rest: commands.stage(name, rest)
    if name in commands.COMMANDS:
        return commands.COMMANDS[name]
    from pipeline.errors import PipelineError, choices

    raise PipelineError(choices("command", name, [*STAGES, *commands.COMMANDS]))


def _is_ours(error: Exception) -> bool:
    """Errors of our own packages are sentences for the user; any other is a fault to be seen."""
    return type(error).__module__.split(".")[0] in ("pipeline", "baselines", "robots")


if __name__ == "__main__":
    sys.exit(main())
