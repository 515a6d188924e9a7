"""Chromium without a window, by its DevTools protocol: pictures, texts and clicks of a page."""

from __future__ import annotations

import base64
import io
import json
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from PIL import Image
from websockets.sync.client import connect

PROGRAM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chrome"))), None)
PATIENCE_S = 120.0
OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--remote-debugging-port=0",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--hide-scrollbars",
    "--no-first-run",
    "--disable-dev-shm-usage",
)


class Browser:
    """One page."""

    def __init__(self, socket: Any) -> None:
        self._socket, self._number = socket, 0

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and wait for its result."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        self._socket.send(json.dumps(message))
        while True:
            came = json.loads(self._socket.recv(timeout=PATIENCE_S))
            if came.get("id") == self._number:
                assert "error" not in came, came
                return came["result"]

    def evaluate(self, script: str) -> Any:
        """The value of an expression in JavaScript."""
        return self.call("Runtime.evaluate", expression=script, returnByValue=True)["result"].get(
            "value"
        )

    def text(self) -> str:
        """All text of the page."""
        return str(self.evaluate("document.body.innerText"))

    def wait_for(self, *texts: str) -> str:
        """Wait until texts are on the page, and all of it is there; all of its text."""
        begin = time.monotonic()
        while not (
            all(text in (shown := self.text()) for text in texts)
            and self.evaluate("document.readyState") == "complete"
        ):
            assert time.monotonic() - begin < PATIENCE_S, f"{texts} not in: {shown}"
            time.sleep(0.3)
        return shown

    def picture(self) -> Image.Image:
        """What is to be seen."""
        data = self.call("Page.captureScreenshot", format="png")["data"]
        return Image.open(io.BytesIO(base64.b64decode(data))).convert("RGB")

    def click(self, label: str) -> None:
        """Press the first button with a label."""
        wanted = f"each => each.innerText.trim() === {json.dumps(label)}"
        buttons = f"[...document.querySelectorAll('button, label')].filter({wanted})"
        found = self.evaluate(f"{buttons}.map(each => each.click()).length > 0")
        assert found, f"no button {label}: {self.text()}"

    def drag(self, begin: tuple[float, float], end: tuple[float, float], steps: int = 12) -> None:
        """Press the mouse at one place and let go at another one [pixels]."""

        def mouse(kind: str, x: float, y: float) -> None:
            button = "none" if kind == "mouseMoved" and not self._down else "left"
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button=button, clickCount=1)
            time.sleep(0.05)

        self._down = False
        mouse("mouseMoved", *begin)
        self._down = True
        mouse("mousePressed", *begin)
        for k in range(1, steps + 1):
            share = k / steps
            x, y = (a + share * (b - a) for a, b in zip(begin, end, strict=True))
            mouse("mouseMoved", x, y)
        mouse("mouseReleased", *end)


@contextmanager
def browse(address: str, width: int = 1280, height: int = 800) -> Iterator[Browser]:
    """Open a page in a browser that is gone afterwards."""
    assert PROGRAM is not None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        command = [
            PROGRAM,
            *OPTIONS,
            f"--window-size={width},{height}",
            f"--user-data-dir={folder}",
        ]
        process = subprocess.Popen(
            [*command, "about:blank"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            port = _port(Path(folder) / "DevToolsActivePort")
            with urlopen(f"http://127.0.0.1:{port}/json/list") as answer:
                pages = [each for each in json.load(answer) if each["type"] == "page"]
            with connect(pages[0]["webSocketDebuggerUrl"], max_size=None) as socket:
                browser = Browser(socket)
                browser.call(
                    "Emulation.setDeviceMetricsOverride",
                    width=width,
                    height=height,
                    deviceScaleFactor=1,
                    mobile=False,
                )
                browser.call("Page.navigate", url=address)
                yield browser
        finally:
            process.terminate()
            process.wait(20)


def _port(path: Path) -> int:
    begin = time.monotonic()
    while not path.exists() or not path.read_text():
        assert time.monotonic() - begin < PATIENCE_S, "Chromium does not start"
        time.sleep(0.1)
    return int(path.read_text().split()[0])
