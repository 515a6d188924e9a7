"""`chat` through a pseudo-terminal, as a person has it, and its lines without a simulator."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path

from pipeline.agent.transcript import read_transcript
from robots.locations import FOLDER

PATIENCE_S = 180.0


class Terminal:
    """A command on a pseudo-terminal."""

    def __init__(self, *arguments: str) -> None:
        self.master, slave = pty.openpty()
        self.process = subprocess.Popen(
            [sys.executable, "-m", "pipeline", *arguments],
            stdin=slave,
            stdout=slave,
            stderr=slave,
            cwd=FOLDER,
            env={**os.environ, "TERM": "dumb"},
        )
        os.close(slave)
        self.shown = ""

    def wait_for(self, text: str) -> str:
        """Read until a text is shown; what came with it."""
        begin, since = time.monotonic(), len(self.shown)
        while text not in self.shown[since:]:
            assert time.monotonic() - begin < PATIENCE_S, self.shown
            if select.select([self.master], [], [], 1.0)[0]:
                try:
                    self.shown += os.read(self.master, 4096).decode(errors="replace")
                except OSError:
                    break  # the command has ended
        assert text in self.shown[since:], self.shown
        return self.shown[since:]

    def type(self, line: str) -> None:
        os.write(self.master, f"{line}\n".encode())

    def close(self) -> None:
        self.process.terminate()
        self.process.wait()
        os.close(self.master)


def converse(results: Path, robot: str) -> list[str]:
    """Say two sentences to a robot; what it showed after the first, line by line."""
    solver = ["experiment=refined_grasp", "grasp.solver=lm"]  # smoke trains a network of no use
    run = [f"robot={robot}", f"results_dir={results}", "profile=smoke"]
    terminal = Terminal("chat", *run, *solver)
    try:
        assert "banana" in terminal.wait_for("quit` ends.\r\n> ")
        terminal.type("grasp the banana, then point at the orange")
        after = terminal.wait_for("\n> ")
        terminal.type("grasp the elephant")
        terminal.wait_for("\n> ")
        terminal.type("quit")
        terminal.wait_for(".jsonl")
        assert terminal.process.wait(60) == 0
    finally:
        terminal.close()
    return [line.strip() for line in after.splitlines()]


def check(results: Path, robot: str) -> None:
    lines = converse(results, robot)
    grasped = next(k for k, line in enumerate(lines) if line.startswith("grasp banana: done"))
    pointed = next(k for k, line in enumerate(lines) if line.startswith("point orange: done"))
    assert grasped < pointed, lines
    seen = lines[pointed + 1 :]
    assert any(line.startswith("orange") for line in seen)
    assert not any(line.startswith("banana") for line in seen), "it lies in a bin"
    (transcript,) = (results / "chat" / robot).glob("*.jsonl")
    entries = read_transcript(transcript)
    done = [(e["kind"], e["target"], e["done"]) for e in entries if e["role"] == "event"]
    physical = [result for result in done if result[0] in ("grasp", "point", "push")]
    assert physical == [("grasp", "banana", True), ("point", "orange", True)]
    assert {"system", "user", "assistant", "body"} <= {entry["role"] for entry in entries}


def test_a_banana_is_grasped_and_then_an_orange_pointed_at(tmp_path: Path) -> None:
    check(tmp_path, "nicol")
