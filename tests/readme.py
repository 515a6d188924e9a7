"""The commands of README.md, as a reader would type them."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"
PIPELINE = "python -m pipeline"


def blocks(language: str) -> list[str]:
    """The fenced blocks of a language."""
    text = README.read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def commands() -> list[list[str]]:
    """All commands: of shell blocks, and of code in the text and in tables; each one once."""
    text = README.read_text(encoding="utf-8")
    typed = [line for block in blocks("sh") for line in block.replace("\\\n", " ").splitlines()]
    inline = re.findall(rf"`((?:{PIPELINE}|make|dvc) [^`]*)`", re.sub(r"(?s)^```.*?^```", "", text))
    found = [shlex.split(line, comments=True) for line in (*typed, *inline)]
    parted = [part for words in found for part in _parted(words)]
    return [list(words) for words in dict.fromkeys(tuple(words) for words in parted if words)]


def _parted(words: list[str]) -> list[list[str]]:
    """Several commands of a line, without variables of the environment before them."""
    parts: list[list[str]] = [[]]
    for word in words:
        parts[-1].append(word.rstrip(";"))
        if word.endswith(";"):
            parts.append([])
    return [[w for i, w in enumerate(part) if i or not re.match(r"[A-Z_]+=", w)] for part in parts]
