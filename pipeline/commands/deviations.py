"""`deviations`: docs/deviations.md, where paper, released code and this project differ."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pipeline.commands.arguments import command_parser
from pipeline.config import values
from pipeline.data.files import read_yaml, write_text
from pipeline.errors import PipelineError
from pipeline.locations import need_checkout

SOURCE, PAGE = "docs/deviations.yaml", "docs/deviations.md"
PROFILE = "profile=paper"
ROBOT = "robot=nicol"  # whose values the page shows, where they differ between robots
PLACE = re.compile(r"\{([\w.]+)\}")
COLUMNS = ("what", "paper", "released code", "here", "why", "override")
HELP = f"""\
Writes {PAGE} from {SOURCE}; values are those of {PROFILE} as it is composed.
"""
HEADER = f"""\
<!-- made by `python -m pipeline deviations` from {SOURCE}; do not edit -->
# Where paper, released code and this project differ

The paper is Habekost, Gäde, Allgeuer, Wermter, IROS 2024; the released code is jangerritha/CycleIK.
`here` is what `{PROFILE}` composes to by default, on NICOL where robots differ; a test holds every
value to the configuration. `override` brings back the published choice or takes another one.
"""


@dataclass(frozen=True)
class Deviation:
    """One difference.

    Attributes:
        what: What differs.
        paper: What the paper says.
        code: What the released code does.
        here: What we do, with ``{key}`` for values of the configuration.
        why: Why.
        override: Overrides that choose otherwise; empty where there are none.
        values: Keys that `here` speaks of, and what the paper's profile composes them to.
        modules: Names of what does it where no key says so.
    """

    what: str
    paper: str
    code: str
    here: str
    why: str
    override: str = ""
    values: dict[str, Any] = field(default_factory=dict)
    modules: tuple[str, ...] = ()


def deviations(arguments: list[str]) -> int:
    """Write the page."""
    command_parser("deviations", HELP).parse(arguments)
    root = need_checkout(PAGE)
    write_text(root / PAGE, page(read_deviations(root / SOURCE)))
    print(root / PAGE)
    return 0


def read_deviations(path: Path) -> dict[str, list[Deviation]]:
    """Return the differences by the title of their section.

    Raises:
        PipelineError: An entry has a key that it should not have, or lacks one.
    """
    found = {}
    for section in read_yaml(path)["sections"]:
        entries = []
        for entry in section["entries"]:
            entry["modules"] = tuple(entry.get("modules", ()))
            try:
                entries.append(Deviation(**entry))
            except TypeError as error:
                raise PipelineError(f"{path}: {entry.get('what')}: {error}") from error
        found[section["title"]] = entries
    return found


def page(sections: dict[str, list[Deviation]]) -> str:
    """Return the Markdown of the page, values filled in."""
    composed = values([PROFILE, ROBOT])
    return "\n".join([HEADER, *_lines(sections, composed)])


def value_at(composed: Any, key: str) -> Any:
    """Return the value of a key such as ``tune.start.0.batch_size``.

    Raises:
        KeyError: There is none.
    """
    for part in key.split("."):
        composed = composed[int(part)] if isinstance(composed, list) else composed[part]
    return composed


def _lines(sections: dict[str, list[Deviation]], composed: Any) -> Iterator[str]:
    for title, entries in sections.items():
        yield from (f"## {title}", "")
        yield f"| {' | '.join(COLUMNS)} |"
        yield "|" + " --- |" * len(COLUMNS)
        for each in entries:
            here = PLACE.sub(lambda m: _shown(value_at(composed, m[1])), each.here)
            override = f"`{each.override}`" if each.override else "–"
            cells = (each.what, each.paper, each.code, here, each.why, override)
            yield f"| {' | '.join(cell.replace('|', '&#124;') for cell in cells)} |"
        yield ""


def _shown(value: Any) -> str:
    """A value as YAML has it, large numbers with commas."""
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, list):
        return ", ".join(map(_shown, value)) or "none"
    return f"{value:g}" if isinstance(value, float) else str(value)
