"""Where the numbers of a report come from: commits, machine, versions, budgets, configuration."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from pipeline.presentation.naming import robot_title, solver_title
from pipeline.provenance import commit, made_by
from pipeline.reporting.results import Results


def provenance_lines(results: Results) -> list[tuple[str, str]]:
    """What made the rows and the report, one line each, without a clock."""
    now = {**made_by(), "commit": commit()}
    cards = [*results.evaluated.values(), *(card for card, _ in results.train.values())]
    cards += results.dataset.values()
    machines = [card.get("machine") for card in cards]
    described = [_machine(machine) for machine in machines if isinstance(machine, dict)]
    commits = [str(card["commit"]) for card in cards if card.get("commit")]
    versions = next((c["versions"] for c in cards if c.get("versions")), now["versions"])
    lines = [
        ("Report made at commit", now["commit"]),
        ("Results made at commit", ", ".join(_unique(commits)) or "not recorded"),
        ("Measured on", "; ".join(_unique(described)) or _machine(now["machine"])),
        ("Versions", ", ".join(f"{name} {number}" for name, number in versions.items())),
    ]
    for (robot, solver), card in sorted(results.evaluated.items()):
        budget = card.get("solver_budget")
        if budget:
            shown = ", ".join(f"{k} = {v:g}" for k, v in budget.items() if v is not None)
            lines.append((f"Budget, {robot_title(robot)}, {solver_title(solver)}", shown))
    return lines


def _machine(machine: dict[str, Any]) -> str:
    cores = machine.get("cores")
    parts = [str(machine.get("processor", "unknown processor"))]
    parts += [f"{cores} cores"] if cores else []
    parts += [str(machine["system"])] if machine.get("system") else []
    accelerator = machine.get("accelerator")
    return ", ".join([*parts, *([accelerator] if accelerator not in (None, "none") else [])])


def configurations(results: Results) -> list[tuple[str, str]]:
    """Configurations in full, to be unfolded."""
    found: list[tuple[str, str]] = []
    for robot, solver in sorted(results.evaluated):
        card = results.evaluated[robot, solver]
        settings = card.get("evaluate") or (card.get("config") or {}).get("evaluate")
        if settings and not found:
            found.append(("Evaluation", json.dumps(settings, indent=2)))
    for (robot, model), (card, _) in sorted(results.train.items()):
        if card.get("config"):
            title = f"Training, {robot_title(robot)}, {model}"
            found.append((title, json.dumps(card["config"], indent=2)))
    return found


def _unique(items: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(items))
