"""The pages of `view` and `watch` as Chromium shows them, with a renderer that needs no card."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np
import pytest
from PIL import Image

from robots.locations import FOLDER

pytest.importorskip("viser")
from tests.browser import PROGRAM, Browser, browse

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(PROGRAM is None, reason="Chromium is not installed"),
]
PANEL_X = 890  # pixels, where the panel begins in a window of 1280
PATIENCE_S = 600.0
COLUMNS = re.compile(r"LM, compiled\S*\s+([\d.]+)\s+([\d.]+)\s+([\d.]+)\s+([\d.]+)")


@contextmanager
def served(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A command that serves a page, and the page's address; it is ended by Ctrl-C."""
    command = [sys.executable, "-m", "pipeline", *arguments, "port=0", "open=false"]
    # What a shell starts in the background ignores Ctrl-C, and so would what that starts.
    heed = partial(signal.signal, signal.SIGINT, signal.default_int_handler)
    with subprocess.Popen(
        command, cwd=FOLDER, stdout=subprocess.PIPE, text=True, preexec_fn=heed
    ) as process:
        try:
            yield process, printed(process, r"(http://\S+) shows it")
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE_S) == 0
        finally:
            process.kill()


def printed(process: subprocess.Popen[str], wanted: str) -> str:
    """Read lines until one has what is wanted; its first group."""
    assert process.stdout is not None
    begin = time.monotonic()
    for line in process.stdout:
        if found := re.search(wanted, line):
            return found[1]
        assert time.monotonic() - begin < PATIENCE_S
    raise AssertionError(f"it ended without {wanted}")


def drawn(picture: Image.Image) -> np.ndarray:
    """Pixels of the 3D part that are neither background nor floor, as a mask."""
    pixels = np.asarray(picture)[:, :PANEL_X].astype(int)
    return (pixels.min(axis=2) < 150) | (np.ptp(pixels, axis=2) > 40)


def arrow(picture: Image.Image) -> tuple[np.ndarray, np.ndarray]:
    """The red arrow of the target: where it begins and near its tip [pixels, right and down]."""
    pixels = np.asarray(picture)[:, :PANEL_X].astype(int)
    red = (pixels[..., 0] > 200) & (pixels[..., 1] < 90) & (pixels[..., 2] < 140)
    places = np.argwhere(red)[:, ::-1]
    assert len(places) > 20
    middle = places.mean(axis=0)
    farthest = places[np.linalg.norm(places - middle, axis=1).argmax()]
    return middle, middle + 0.95 * (farthest - middle)


def settled(browser: Browser) -> Image.Image:
    """A picture once two in a row are the same; the software renderer takes its time."""
    before = browser.picture()
    for _ in range(30):
        time.sleep(1.0)
        now = browser.picture()
        if drawn(now).sum() > 1000 and now.tobytes() == before.tobytes():
            return now
        before = now
    return before


def test_solvers_answer_in_the_browser() -> None:
    with (
        served("view", "robot=panda", "solvers=[lm,cycleik]", "solver=lm") as (_, address),
        browse(address) as browser,
    ):
        text = browser.wait_for("LM, compiled", "CycleIK", "panda_joint1", "Play the null space")
        assert COLUMNS.search(text) is not None
        home = settled(browser)
        assert drawn(home).mean() > 0.01
        assert len(home.crop((0, 0, PANEL_X, home.height)).getcolors(1 << 20) or []) > 200
        browser.click("Random")
        jump = 0.0
        for _ in range(100):
            found = COLUMNS.search(browser.text())
            assert found is not None
            if (jump := float(found[4])) > 0.05:
                break
            time.sleep(0.3)
        assert jump > 0.05
        assert float(found[1]) < 0.1
        moved = settled(browser)
        assert (drawn(moved) != drawn(home)).sum() > 1000
        begin, tip = arrow(moved)
        pull = 60.0 * (begin - tip) / np.linalg.norm(begin - tip)  # inwards: it stays in reach
        browser.drag((tip[0], tip[1]), (tip[0] + pull[0], tip[1] + pull[1]))
        dragged = settled(browser)
        assert (drawn(dragged) != drawn(moved)).sum() > 300
        again = COLUMNS.search(browser.text())
        assert again is not None
        assert again.groups() != found.groups()
        assert float(again[1]) < 0.1
        browser.click("Play the null space")
        browser.wait_for("same pose, joints move by up to")
        if folder := os.environ.get("PICTURES"):
            moved.save(f"{folder}/view.png")


def test_a_trial_is_watched_in_the_browser() -> None:
    run = ["robot=panda", "trial=0", "experiment=refined_grasp", "grasp.solver=lm"]
    with served("watch", *run) as (process, address), browse(address) as browser:
        browser.wait_for("Panda, trial 0")
        outcome = printed(process, r"^(\w+: \w.*, .*)$")
        browser.wait_for(outcome, "Time [s]", "Running")
        picture = browser.picture()
        assert drawn(picture).mean() > 0.01
        if folder := os.environ.get("PICTURES"):
            picture.save(f"{folder}/watch.png")
