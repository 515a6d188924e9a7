"""Comments of YAML files by key: what a value means and its unit, as conf/ has them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import yaml

CONTINUED = re.compile(r"^\s*#\s?")


def key_comments(path: Path) -> dict[str, str]:
    """Return the comment of every key of a YAML file, by dotted path; empty where it has none.

    A comment stands on the line of its key or of the end of its value, and goes on over the lines
    below that hold nothing else and lie deeper than the key. Keys within ``{...}`` share that of
    the key that holds them.

    Args:
        path: A file of mappings; items of lists are counted, as in ``start.0.batch_size``.
    """
    text = path.read_text(encoding="utf-8")
    node = yaml.compose(text, Loader=yaml.SafeLoader)
    return dict(_walk(node, "", text.splitlines(), "")) if node is not None else {}


def _walk(
    node: yaml.Node, prefix: str, lines: list[str], inherited: str
) -> Iterator[tuple[str, str]]:
    if isinstance(node, yaml.SequenceNode):
        for number, item in enumerate(node.value):
            yield from _walk(item, f"{prefix}{number}.", lines, inherited)
        return
    if not isinstance(node, yaml.MappingNode):
        return
    for key, value in node.value:
        name = f"{prefix}{key.value}"
        comment = inherited if node.flow_style else _comment(key, value, lines)
        yield name, comment
        yield from _walk(value, f"{name}.", lines, comment)


def _comment(key: yaml.Node, value: yaml.Node, lines: list[str]) -> str:
    """The comments from the line of a key to the end of its value, or to its first nested key."""
    first, column = key.start_mark.line, key.start_mark.column
    if isinstance(value, yaml.ScalarNode) and value.style in (">", "|"):
        return _trailing(lines[first])
    block = isinstance(value, yaml.CollectionNode) and not value.flow_style
    last = first if block else value.end_mark.line
    parts = [_trailing(line) for line in lines[first : last + 1]]
    for line in lines[last + 1 :]:
        found = CONTINUED.match(line)
        if found is None or found.end() - 2 <= column:
            break
        parts.append(line[found.end() :].strip())
    return " ".join(part for part in parts if part)


def _trailing(line: str) -> str:
    """The comment behind a value; a `#` within quotes is none."""
    quote = ""
    for place, letter in enumerate(line):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'" and line[:place].rstrip()[-1:] in (":", "[", ",", "-", "{", ""):
            quote = letter
        elif letter == "#" and (place == 0 or line[place - 1].isspace()):
            return line[place + 1 :].strip()
    return ""
