"""The command line: `python -m pipeline <command> [overrides]`, also called `cycleik-bench`."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from pipeline.progress import set_up_logging

DESCRIPTION = "Benchmark for neural inverse kinematics and neuro-robotic grasping."
NOTES = """\
Overrides are Hydra's: robot=nico profile=smoke train.learning_rate=1.0e-4. With -m lists of values
are swept, each run in a results folder of its own: train -m train.loss=former,smooth seed=0,1
`python -m pipeline <command> --help` says more; `make reproduce` runs everything through DVC.
"""
BAD_INPUT, INTERRUPTED = 2, 130


class Terminated(KeyboardInterrupt):
    """SIGTERM: what is running ends as it does with Ctrl-C, and keeps what it has."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; bad input gives one sentence on stderr and status 2."""
    set_up_logging()
    try:
        with _terminated_like_interrupted():
            return _run(sys.argv[1:] if argv is None else argv)
    except Terminated:
        print("\nterminated; the same command goes on from here", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("\ninterrupted; the same command goes on from here", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        return 0
    except OSError as error:
        said = error.filename is not None and error.strerror
        print(f"error: {f'{error.filename}: {said}' if said else error}", file=sys.stderr)
        return BAD_INPUT
    except (ValueError, ImportError) as error:
        if not _is_ours(error):
            raise
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    except SystemExit as leaving:  # argparse, after it has printed the help of a command
        return int(leaving.code or 0)


@contextmanager
def _terminated_like_interrupted() -> Iterator[None]:
    """Turn SIGTERM into an exception, in this process and not in those forked from it."""
    if threading.current_thread() is not threading.main_thread():  # Python sets handlers there only
        yield
        return
    process = os.getpid()

    def end(number: int, frame: object) -> None:
        if os.getpid() == process:
            raise Terminated
        os._exit(128 + number)

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _run(argv: Sequence[str]) -> int:
    from pipeline.commands import listing, run_command
    from pipeline.commands.arguments import PROGRAM, CommandParser

    parser = CommandParser(
        prog=PROGRAM,
        usage="%(prog)s <command> [key=value ...] [-m]",
        description=DESCRIPTION,
        epilog=f"{listing()}\n\n{NOTES}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("command", nargs="?", default="help", help=argparse.SUPPRESS)
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    given = parser.parse_args(argv)
    if given.command == "help":
        parser.print_help()
        return 0
    return run_command(given.command, given.arguments)


def _is_ours(error: Exception) -> bool:
    """Errors of our own packages are sentences for the user; any other is a fault to be seen."""
    return type(error).__module__.split(".")[0] in ("pipeline", "baselines", "robots")


if __name__ == "__main__":
    sys.exit(main())
