"""Every claim of the paper with a verdict: from the tables on disk, or by hand with its rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from pipeline.errors import PipelineError
from pipeline.presentation.columns import text
from pipeline.presentation.naming import robot_title, solver_title
from pipeline.presentation.table import Table
from pipeline.reporting.evidence import Evidence

# Undecided: tested, and what came of it has another explanation, such as chance.
HOLDS, FAILS, UNDECIDED, UNTESTED = "holds", "does not hold", "undecided", "not tested"
VERDICTS = (HOLDS, FAILS, UNDECIDED, UNTESTED)
SAID = ("id", "claim", "where", "test")  # what every claim says
LOWEST, HIGHEST = "lowest", "highest"


class ClaimsError(PipelineError):
    """The file of claims is missing or does not say what it should."""


@dataclass(frozen=True)
class Verdict:
    """What became of a claim.

    Attributes:
        verdict: Of `VERDICTS`.
        reason: What decided it, or why it is not tested.
        rows: File that shows it, seen from the results folder; empty where nothing was tested.
    """

    verdict: str
    reason: str
    rows: str = ""


@dataclass(frozen=True)
class Claim:
    """A claim of the paper.

    Attributes:
        id: Short name.
        claim: What is claimed, in our own words.
        where: Where the paper claims it.
        test: What it is tested with, and how that decides.
        verdict: What became of it.
    """

    id: str
    claim: str
    where: str
    test: str
    verdict: Verdict


COLUMNS = (
    text("id", "id"),
    text("claim", "claim"),
    text("where", "in the paper"),
    text("test", "tested with"),
    text("verdict", "verdict", lambda line: line.verdict.verdict),
    text("reason", "reason", lambda line: line.verdict.reason),
    text("rows", "rows", lambda line: line.verdict.rows or None),
)


def read_claims(path: Path) -> tuple[list[dict[str, Any]], list[dict[str, str]]]:
    """Read the claims and the reasons of published numbers.

    Returns:
        The entries under ``claims`` and those under ``numbers``.

    Raises:
        ClaimsError: There is no such file, or an entry lacks what it should say.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ClaimsError(f"there is no {path}: it holds the paper's claims") from error
    except yaml.YAMLError as error:
        raise ClaimsError(f"{path} is not readable as YAML ({error})") from error
    if not isinstance(content, dict) or not {"claims", "numbers"} <= set(content):
        raise ClaimsError(f"{path} lacks the lists claims and numbers")
    for entry in content["claims"]:
        _check(entry, path)
    return content["claims"], content["numbers"]


def every_claim(entries: Sequence[Mapping[str, Any]], evidence: Evidence) -> list[Claim]:
    """Give every claim its verdict: by its rules from tables on disk, or as the file says."""
    return [
        Claim(
            **{name: str(entry[name]) for name in SAID},
            verdict=_verdict(entry, evidence),
        )
        for entry in entries
    ]


def claims_table(claims: Sequence[Claim]) -> Table:
    """The table of every claim."""
    counts = {name: sum(c.verdict.verdict == name for c in claims) for name in VERDICTS}
    counted = ", ".join(f"{count} {name}" for name, count in counts.items())
    return Table.of(
        claims,
        COLUMNS,
        name="every_claim",
        title="Every claim",
        caption=f"What the paper claims and what became of it here: {counted}.",
    )


def _verdict(entry: Mapping[str, Any], evidence: Evidence) -> Verdict:
    if "rules" not in entry:
        return Verdict(entry["verdict"], entry["reason"], entry.get("rows", ""))
    ruled = _ruled(entry["rules"], evidence)
    if ruled.rows and entry.get("note"):
        return replace(ruled, reason=f"{ruled.reason}. {entry['note']}")
    return ruled


def _ruled(rules: Sequence[Mapping[str, Any]], evidence: Evidence) -> Verdict:
    """Decide a claim that is a ranking of solvers in Table II.

    Each rule says on which robots which solver is the best of some in a metric. One robot that
    shows otherwise refutes the claim; robots without rows leave it open.
    """
    shown: list[str] = []
    refuted: list[str] = []
    missing: list[str] = []
    rows = ""
    for rule in rules:
        for robot in rule["robots"]:
            found = {
                solver: evidence.precision(robot, solver, rule["metric"])
                for solver in (rule["solver"], *rule["among"])
            }
            known = {name: float(each.value) for name, each in found.items() if each is not None}
            rows = next((each.rows for each in found.values() if each is not None), rows)
            absent = [solver_title(name) for name in found if name not in known]
            if absent:
                missing.append(f"{robot_title(robot)} ({', '.join(absent)})")
                continue
            best = (min if rule["best"] == LOWEST else max)(known, key=lambda name: known[name])
            values = ", ".join(f"{solver_title(n)} {value:.3g}" for n, value in known.items())
            sentence = f"{robot_title(robot)}: {rule['metric']} {values}"
            (shown if best == rule["solver"] else refuted).append(sentence)
    if refuted:
        return Verdict(FAILS, "; ".join(refuted), rows)
    if missing:
        return Verdict(UNTESTED, f"no rows of {', '.join(missing)}", rows if shown else "")
    return Verdict(HOLDS, "; ".join(shown), rows)


def _check(entry: Mapping[str, Any], path: Path) -> None:
    """Refuse an entry that does not say what it should."""
    name = entry.get("id", entry)
    missing = [key for key in SAID if not entry.get(key)]
    if missing:
        raise ClaimsError(f"{path}: claim {name} lacks {', '.join(missing)}")
    if "rules" in entry:
        for rule in entry["rules"]:
            if rule.get("best") not in (LOWEST, HIGHEST):
                raise ClaimsError(f"{path}: claim {name}: best is {LOWEST} or {HIGHEST}")
        return
    if entry.get("verdict") not in VERDICTS or not entry.get("reason"):
        raise ClaimsError(
            f"{path}: claim {name} needs rules, or a reason and a verdict of {', '.join(VERDICTS)}"
        )
    if entry["verdict"] != UNTESTED and not entry.get("rows"):
        raise ClaimsError(f"{path}: claim {name} has a verdict without rows")
