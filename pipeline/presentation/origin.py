"""Where a table comes from: command, commit, date, processor, seeds, profile and networks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

UNRECORDED = "not recorded"
BEFORE = "older than the record of commit, date, processor, seeds and profile"
OLDER = "older"  # rows that were made before this was recorded: nothing is invented for them


@dataclass(frozen=True)
class Origin:
    """What made the rows of a table; several values of one kind stand behind commas.

    Attributes:
        command: Makes the table again from the rows.
        commit: Of the code that made the rows.
        date: Day on which the rows were made, UTC.
        processor: That they were made on, an accelerator behind it.
        seeds: Root seeds.
        profile: Of conf/profile.
        networks: Models and recipes behind neural rows.
    """

    command: str
    commit: str = UNRECORDED
    date: str = UNRECORDED
    processor: str = UNRECORDED
    seeds: str = UNRECORDED
    profile: str = UNRECORDED
    networks: str = ""

    def sentence(self) -> str:
        """Return it as one line for people."""
        if {self.commit, self.date, self.processor, self.seeds, self.profile} == {OLDER}:
            return f"Made by `{self.command}`; {BEFORE}."
        shown = {name: value for name, value in self.facts().items() if value and name != "command"}
        said = "; ".join(f"{name} {value}" for name, value in shown.items())
        return f"Made by `{self.command}`; {said}."

    def facts(self) -> dict[str, str]:
        """Return it by name."""
        return asdict(self)


def origin_of(command: str, cards: Iterable[Mapping[str, Any]], profile: str = "") -> Origin:
    """Return the origin of a table whose rows these cards are about.

    Args:
        command: Makes the table from the rows.
        cards: Provenance of each file of rows; one that lacks a fact is older than its record.
        profile: Of the run, for cards that do not say it.
    """
    cards = list(cards)
    if not cards:
        return Origin(command, profile=profile or UNRECORDED)
    found = {
        "commit": [card.get("commit") for card in cards],
        "date": [card.get("date") for card in cards],
        "processor": [_processor(card.get("machine")) for card in cards],
        "seeds": [_seed(card) for card in cards],
        "profile": [card.get("profile") or profile for card in cards],
    }
    networks = dict.fromkeys(str(card["network"]) for card in cards if card.get("network"))
    texts = {name: _joined(values) for name, values in found.items()}
    return Origin(command, **texts, networks=", ".join(networks))


def older(command: str) -> Origin:
    """Return the origin of a table that was made before any of this was recorded."""
    kinds = [field.name for field in fields(Origin) if field.name not in ("command", "networks")]
    return Origin(command, **dict.fromkeys(kinds, OLDER))


def _joined(values: Iterable[Any]) -> str:
    texts = [OLDER if value in (None, "") else str(value) for value in values]
    return ", ".join(dict.fromkeys(texts))


def _seed(card: Mapping[str, Any]) -> Any:
    inner = card.get("config")
    return card.get("seed", inner.get("seed") if isinstance(inner, dict) else None)


def _processor(machine: Any) -> str | None:
    if not isinstance(machine, dict):
        return None
    accelerator = machine.get("accelerator")
    also = f" with {accelerator}" if accelerator not in (None, "none") else ""
    return f"{machine.get('processor', 'unknown')}{also}"
