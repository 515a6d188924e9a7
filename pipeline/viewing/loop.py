"""The loop of a page: what the user wants, what plays, picture after picture, until Ctrl-C."""

from __future__ import annotations

import time
from collections.abc import Callable

from baselines import SolverError
from pipeline.errors import PipelineError
from pipeline.viewing.clip import Player
from pipeline.viewing.inbox import Inbox
from robots import RobotError


def turn(inbox: Inbox, player: Player, patience_s: float, say: Callable[[str], object]) -> None:
    """Do what has come in, then let what plays go on by the time that went by.

    What cannot be done is said, and the page goes on.

    Args:
        inbox: What the user wants.
        player: What plays.
        patience_s: Time until the next picture [s].
        say: Receives the sentence of an error.
    """
    begin = time.monotonic()
    for action in inbox.take(patience_s):
        try:
            action()
        except (PipelineError, RobotError, SolverError) as error:
            say(str(error))
    if (left := patience_s - (time.monotonic() - begin)) > 0.0:
        time.sleep(left)
    player.advance(time.monotonic() - begin)


def run_until_interrupted(
    inbox: Inbox, player: Player, rate: float, say: Callable[[str], object]
) -> None:
    """Turn after turn until Ctrl-C, which is how a page ends.

    Args:
        inbox: What the user wants.
        player: What plays.
        rate: Pictures a second at most [Hz].
        say: Receives the sentence of an error.
    """
    try:
        while True:
            turn(inbox, player, 1.0 / rate, say)
    except KeyboardInterrupt:
        print()
