"""How an agent does on the suite of instructions: plan success and confusion by family."""

from __future__ import annotations

from typing import Any

import pandas as pd

from pipeline.evaluation.statistics import wilson_interval
from pipeline.instructions.plans import CLASSES
from pipeline.instructions.suite import ALL, in_families
from pipeline.presentation.columns import count, share, text, under
from pipeline.presentation.table import Table

EXECUTED = "instructions_executed"  # name of the table of deeds
_FAMILY = text("family", "Family", convert=lambda name: name.replace("_", " "))
_HALVES = {"open": "open", "held_out": "held out"}


def plan_success(rows: pd.DataFrame, confidence: float) -> Table:
    """Plan success by family, those held out apart.

    Args:
        rows: Raw rows of one agent.
        confidence: Of the intervals, for example 0.95.
    """
    columns = [
        column
        for half, title in _HALVES.items()
        for column in under(
            title,
            count(f"{half}_n", "n"),
            share(f"{half}_share", "success [%]", decimals=0),
            share(f"{half}_low", "from", decimals=0),
            share(f"{half}_high", "to", decimals=0),
        )
    ]
    return Table.of(
        [_success(family, part, confidence) for family, part in in_families(rows)],
        [_FAMILY, *columns],
        name="instructions",
        title="Instructions fulfilled",
        caption="Share of instructions whose plan is one of the right ones: all of its actions, in "
        "order, and no other. The held-out half was written before the policy's grammar, by "
        "the same hand, and the grammar was not changed for it. "
        f"Wilson intervals of {confidence:.0%}.",
    )


def execution_success(rows: pd.DataFrame, confidence: float) -> Table:
    """How many instructions were fulfilled in simulation, by family, beside the right plans.

    Args:
        rows: Raw rows of one agent, carried out.
        confidence: Of the intervals.
    """
    return Table.of(
        [_executed(family, part, confidence) for family, part in in_families(rows)],
        [
            _FAMILY,
            count("instructions", "instructions"),
            count("planned", "right plans"),
            count("executed", "carried out"),
            *under(
                "fulfilled [%]",
                share("share", "share", decimals=0),
                share("low", "from", decimals=0),
                share("high", "to", decimals=0),
            ),
            text("failed", "deeds that failed"),
        ],
        name=EXECUTED,
        title="Instructions carried out",
        caption="Of all instructions, both halves: those with a right plan, and those whose plan "
        "was right and of which every action was done in simulation; where no action is due, "
        f"words are the deed. Wilson intervals of {confidence:.0%}.",
    )


def confusion(rows: pd.DataFrame) -> Table:
    """What the plans of each family are."""
    present = [name for name in CLASSES if (rows["class"] == name).any()]
    lines = [
        {"family": family, **{name: int((part["class"] == name).sum()) for name in present}}
        for family, part in in_families(rows)
    ]
    return Table.of(
        lines,
        [_FAMILY, *(count(name, name) for name in present)],
        name="instructions_confusion",
        title="What became of the instructions",
        caption="Plans by family, both halves: right; the right actions in a wrong order; some "
        "missing; too many; others; a question, or words, in place of actions that were due.",
    )


def _executed(family: str, rows: pd.DataFrame, confidence: float) -> dict[str, Any]:
    right = rows[rows["class"] == "right"]
    interval = wilson_interval(int(rows["executed"].sum()), len(rows), confidence)
    failed = [f"{words} ({number})" for words, number in _reasons(right).items()]
    return {
        "family": family,
        "instructions": len(rows),
        "planned": len(right),
        "executed": int(rows["executed"].sum()),
        "share": interval.estimate,
        "low": interval.low,
        "high": interval.high,
        "failed": "; ".join(failed) if family != ALL else "",
    }


def _reasons(right: pd.DataFrame) -> dict[str, int]:
    """Why first actions of right plans failed, without names and numbers, and how often."""
    failed = right.loc[right["failed"] != "", "failed"]
    failed = failed.str.replace(r"^(\w+) \S+:", r"\1:", regex=True)
    failed = failed.str.replace(r"\d+ mm", "some mm", regex=True)
    return {str(words): int(number) for words, number in failed.value_counts().items()}


def _success(family: str, rows: pd.DataFrame, confidence: float) -> dict[str, Any]:
    line: dict[str, Any] = {"family": family}
    for half in _HALVES:
        part = rows[rows["held_out"] == (half == "held_out")]
        interval = wilson_interval(int((part["class"] == "right").sum()), len(part), confidence)
        line |= {
            f"{half}_n": len(part),
            f"{half}_share": interval.estimate,
            f"{half}_low": interval.low,
            f"{half}_high": interval.high,
        }
    return line
