"""The command line: `python -m pipeline <command> [overrides]`, also called `cycleik-bench`."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Event
from typing import Any

from pipeline.progress import set_up_logging

DESCRIPTION = "Benchmark for neural inverse kinematics and neuro-robotic grasping."
NOTES = """\
Overrides are Hydra's: robot=nico profile=smoke train.learning_rate=1.0e-4. With -m lists of values
are swept, each run in a results folder of its own: train -m train.loss=former,smooth seed=0,1
`python -m pipeline <command> --help` says more; `make reproduce` runs everything through DVC.
"""
BAD_INPUT, INTERRUPTED = 2, 130
AGAIN_S = 0.02  # until a signal that could not be raised is raised again


class Terminated(KeyboardInterrupt):
    """SIGTERM: what is running ends as it does with Ctrl-C, and keeps what it has."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; bad input gives one sentence on stderr and status 2."""
    set_up_logging()
    try:
        with _terminated_like_interrupted() as terminated:
            return _ended(sys.argv[1:] if argv is None else argv, terminated)
    except Terminated:
        print("\nterminated; the same command goes on from here", file=sys.stderr)
        return BAD_INPUT


def _ended(argv: Sequence[str], terminated: Event) -> int:
    """Run one command and turn what it raises into a sentence and a status.

    Raises:
        Terminated: The signal came, whatever the code that it met made of it: a library may answer
            with an error of its own.
    """
    try:
        return _run(argv)
    except BaseException as error:
        if terminated.is_set():
            raise Terminated from error
        return _status(error)


def _status(error: BaseException) -> int:
    """Say what went wrong and return the status; a fault of the code is raised as it came."""
    if isinstance(error, KeyboardInterrupt):
        print("\ninterrupted; the same command goes on from here", file=sys.stderr)
        return INTERRUPTED
    if isinstance(error, BrokenPipeError):
        return 0
    if isinstance(error, SystemExit):  # argparse, after it has printed the help of a command
        return int(error.code or 0)
    if isinstance(error, OSError):
        named = error.filename is not None and error.strerror
        print(f"error: {f'{error.filename}: {named}' if named else error}", file=sys.stderr)
        return BAD_INPUT
    if isinstance(error, ValueError | ImportError) and _is_ours(error):
        print(f"error: {error}", file=sys.stderr)
        return BAD_INPUT
    raise error


@contextmanager
def _terminated_like_interrupted() -> Iterator[Event]:
    """Turn SIGTERM into an exception, in this process and not in those forked from it.

    Yields:
        Whether the signal came.
    """
    came = Event()
    if threading.current_thread() is not threading.main_thread():  # Python sets handlers there only
        yield came
        return
    process = os.getpid()

    def end(number: int, frame: object) -> None:
        if os.getpid() != process:
            os._exit(128 + number)
        came.set()
        raise Terminated

    def not_lost(unraisable: Any) -> None:
        """Raise again what met a place that cannot raise, such as a finaliser."""
        if isinstance(unraisable.exc_value, Terminated):
            signal.setitimer(signal.ITIMER_REAL, AGAIN_S)
        else:
            hook(unraisable)

    before = {number: signal.signal(number, end) for number in (signal.SIGTERM, signal.SIGALRM)}
    hook, sys.unraisablehook = sys.unraisablehook, not_lost
    try:
        yield came
    finally:
        sys.unraisablehook = hook
        for number, handler in before.items():
            signal.signal(number, handler)


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
