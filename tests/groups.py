"""Choices of the groups of conf/, put together so that few runs select every file."""

from __future__ import annotations

from itertools import zip_longest

from pipeline.config import OWNERS, group_choices

# Groups of which none hangs on another.
PLAIN = (
    "evaluate",
    "sample",
    "suite",
    "reach",
    "protocol",
    "plan",
    "grasp",
    "agent",
    "speech",
    "perception",
    "detector",
)
INDEPENDENT = ("robot", "dataset", "report", "engine", "tracker", *PLAIN)


def runs() -> list[list[str]]:
    """Overrides that together select every file: choices of several groups at once."""
    models = group_choices("model")
    together = [[f"model={model}"] for model in models]
    for group in INDEPENDENT:
        names = group_choices(group)
        assert len(names) <= len(together), f"not every {group} is chosen: count runs by it"
        for number, run in enumerate(together):
            run.append(f"{group}={names[number % len(names)]}")
    recipes = [name for name in group_choices("train") if name not in models]
    trained = [
        [f"{group}={name}" for group, name in zip(("train", "tune"), pair, strict=True) if name]
        for pair in zip_longest(recipes, group_choices("tune"))
    ]
    owned = [[f"{group}={name}"] for group in OWNERS for name in group_choices(group)]
    return together + trained + owned
