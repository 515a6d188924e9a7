"""Pace and pause of what plays, as handles of a page."""

from __future__ import annotations

from typing import Any

from pipeline.viewing.clip import Player
from pipeline.viewing.inbox import Inbox

SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
SLIDING_S = 0.4  # after a slider was moved, in which it is the user's


class Playback:
    """A checkbox that lets a player run, and a choice of its speed."""

    def __init__(self, gui: Any, player: Player, inbox: Inbox) -> None:
        """Add the handles.

        Args:
            gui: `viser.GuiApi`.
            player: What plays.
            inbox: Receives what the user wants.
        """
        self._player = player
        self._running = running = gui.add_checkbox("Running", True, hint="of what plays")
        speed = gui.add_dropdown("Speed", SPEEDS, initial_value="1")

        def toggled(event: Any) -> None:
            if event.client is not None:  # not one of our own
                wanted = running.value
                inbox.post("running", lambda: setattr(player, "playing", wanted))

        running.on_update(toggled)

        def chosen(event: Any) -> None:
            inbox.post("speed", lambda: setattr(player, "speed", float(speed.value)))

        speed.on_update(chosen)

    def show(self) -> None:
        """Tick the checkbox where something plays: what is new does so by itself."""
        if self._player.duration > 0.0 and self._running.value != self._player.playing:
            self._running.value = self._player.playing
