"""What README.md and the pages of docs/ show as code: commands, snippets and files."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
PAGES = (README, *sorted((ROOT / "docs").rglob("*.md")))
STRANGER = ROOT / "docs" / "tutorials" / "stranger.md"  # benchmarks/stranger.py types its commands
OTHERS = tuple(page for page in PAGES if page != STRANGER)
PIPELINE = "python -m pipeline"
FENCE = re.compile(
    r"^```(?P<language>\w+)(?: title=\"(?P<title>[^\"]+)\")?\n(?P<text>.*?)^```",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Attributes:
        language: Of its fence.
        title: Path of the file that it shows, from the root of the checkout; empty for none.
        text: What is in it.
    """

    language: str
    title: str
    text: str


def blocks(page: Path) -> list[Block]:
    """The fenced blocks of a page in order."""
    found = FENCE.finditer(page.read_text(encoding="utf-8"))
    return [Block(m["language"], m["title"] or "", m["text"]) for m in found]


def snippets(page: Path) -> list[str]:
    """Code in Python of a page that is no file."""
    found = [each for each in blocks(page) if each.language == "python"]
    return [each.text for each in found if not each.title]


def files(page: Path) -> dict[str, str]:
    """The files that a page shows, by their paths from the root of the checkout."""
    return {each.title: each.text for each in blocks(page) if each.title}


def commands(pages: tuple[Path, ...] = OTHERS) -> list[list[str]]:
    """All commands: of shell blocks, and of code in the text and in tables; each one once."""
    parted = [part for page in pages for words in _typed(page) for part in _parted(words)]
    return [list(words) for words in dict.fromkeys(tuple(words) for words in parted if words)]


def _typed(page: Path) -> Iterator[list[str]]:
    shell = [each.text for each in blocks(page) if each.language == "sh"]
    lines = [line for text in shell for line in text.replace("\\\n", " ").splitlines()]
    text = re.sub(r"(?s)^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    inline = re.findall(rf"`((?:{PIPELINE}|make|dvc) [^`]*)`", text)
    for line in (*lines, *inline):
        yield shlex.split(line, comments=True)


def _parted(words: list[str]) -> list[list[str]]:
    """Several commands of a line, without variables of the environment before them."""
    parts: list[list[str]] = [[]]
    for word in words:
        parts[-1].append(word.rstrip(";"))
        if word.endswith(";"):
            parts.append([])
    return [[w for i, w in enumerate(part) if i or not re.match(r"[A-Z_]+=", w)] for part in parts]
