"""What is played: joints between samples, speed limits, the player's clock; actions that wait."""

from __future__ import annotations

import threading
import time

import numpy as np
import pytest

from pipeline.planning.config import TimingConfig
from pipeline.viewing.clip import Clip, Player, clip_of_path
from pipeline.viewing.inbox import Inbox

TIMING = TimingConfig(
    speed=0.5, swing=1.0, velocity_cap=10.0, rate=100.0, pause_s=0.0, max_duration_s=20.0
)


def test_joints_between_samples_are_linear_and_ends_hold() -> None:
    clip = Clip(
        "", "", np.array([0.0, 1.0, 3.0]), np.array([[0.0], [1.0], [5.0]]), np.empty((0, 3))
    )
    assert clip.duration == 3.0
    times = {-1.0: 0.0, 0.0: 0.0, 0.25: 0.25, 1.0: 1.0, 2.0: 3.0, 3.0: 5.0, 9.0: 5.0}
    for at, expected in times.items():
        assert clip.at(at) == pytest.approx([expected])


def test_a_path_is_played_no_faster_than_its_joints_may_go() -> None:
    joints = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, -2.0], [0.1, -2.0]])
    clip = clip_of_path("", "", joints, np.array([1.0, np.inf]), TIMING)
    # 0.1 rad at half of 1 rad/s, 2 rad at half of the cap of 10 rad/s, and one sample of 100 Hz
    assert clip.time == pytest.approx([0.0, 0.2, 0.6, 0.61])


def test_the_player_goes_round_stops_where_it_is_put_and_says_when_it_moves() -> None:
    shown = []
    player = Player(lambda: shown.append(player.time))
    player.advance(1.0)
    assert shown == []
    player.load(2.0)
    player.speed = 0.5
    player.advance(3.0)
    player.advance(2.0)
    player.seek(0.25)
    player.advance(1.0)
    assert shown == [0.0, 1.5, 0.5, 0.5]
    player.stop()
    player.playing = True
    player.advance(1.0)
    assert player.time == 0.0


def test_the_last_action_about_something_counts_and_order_is_kept() -> None:
    inbox, done = Inbox(), []
    for about, mark in (("target", 1), ("speed", 2), ("target", 3)):
        inbox.post(about, lambda mark=mark: done.append(mark))
    for action in inbox.take(0.0):
        action()
    assert done == [2, 3]
    assert inbox.take(0.0) == []


def test_waiting_ends_when_an_action_comes() -> None:
    inbox = Inbox()
    threading.Timer(0.05, lambda: inbox.post("a", lambda: None)).start()
    begin = time.monotonic()
    assert len(inbox.take(30.0)) == 1
    assert time.monotonic() - begin < 20.0
