"""docs/deviations.md says what the composed configuration says, and leaves nothing unproven."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any

import pytest

from pipeline.commands.deviations import (
    PAGE,
    PLACE,
    PROFILE,
    ROBOT,
    SOURCE,
    Deviation,
    page,
    read_deviations,
    value_at,
)
from pipeline.config import compose, values
from robots.locations import FOLDER

SECTIONS = read_deviations(FOLDER / SOURCE)
ENTRIES = [entry for entries in SECTIONS.values() for entry in entries]


@pytest.fixture(scope="module")
def composed() -> dict[str, Any]:
    return values([PROFILE, ROBOT])


def test_the_committed_page_is_the_generated_one() -> None:
    made = (FOLDER / PAGE).read_text(encoding="utf-8")
    assert made == page(SECTIONS), "run: python -m pipeline deviations"


def test_every_value_is_that_of_the_composed_configuration(composed: dict[str, Any]) -> None:
    wrong = [
        f"{entry.what}: {key} is {value_at(composed, key)}, not {wanted}"
        for entry in ENTRIES
        for key, wanted in entry.values.items()
        if value_at(composed, key) != wanted
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("entry", ENTRIES, ids=lambda entry: entry.what)
def test_every_row_is_tied_to_something(entry: Deviation) -> None:
    """To keys, to an override that composes to something else, or to code that exists."""
    assert entry.values or entry.modules or entry.override
    assert {*PLACE.findall(entry.here)} <= {*entry.values}
    numbers = re.findall(r"(?<![\w.{])\d[\d,.]*\d", PLACE.sub("", entry.here))
    assert not (numbers and entry.values and not PLACE.findall(entry.here)), "typed, not filled in"
    for name in entry.modules:
        assert exists(name), name


@pytest.mark.parametrize("override", sorted({e.override for e in ENTRIES if e.override}))
def test_every_override_can_be_composed_and_changes_something(override: str) -> None:
    plain = compose([PROFILE, ROBOT])
    assert compose([PROFILE, *([ROBOT] if "robot=" not in override else []), override]) != plain


def exists(name: str) -> bool:
    """Whether a dotted name is a module or what lies in one."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found: Any = import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            found = getattr(found, part, None)
        return found is not None
    return False
