"""`claims`: every published number beside ours, and every claim of the paper with a verdict."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pipeline.commands.readme import renew_block
from pipeline.config import compose
from pipeline.locations import need_checkout
from pipeline.presentation.origin import Origin
from pipeline.presentation.published import read_published
from pipeline.presentation.table import Table
from pipeline.provenance import signature
from pipeline.reporting.claims import VERDICTS, Claim, claims_table, every_claim, read_claims
from pipeline.reporting.evidence import Evidence
from pipeline.reporting.numbers import Line, Setting, every_number, numbers_table
from robots import load_robot

COMMAND = "python -m pipeline claims --write FOLDER"
NO_PROFILE = "those of the rows named in it"
NONE = "none: it is read off other tables"
HELP = """\
Prints every published number beside ours, and every claim of the paper with its verdict, from
results/published_results.csv, results/claims.yaml and the tables below results/.
"""


def claims(arguments: list[str]) -> int:
    """Print both tables; with a folder they are written there as CSV, Markdown and LaTeX too."""
    parser = argparse.ArgumentParser(prog="python -m pipeline claims", description=HELP)
    parser.add_argument("--write", metavar="FOLDER", type=Path, help="write both tables there too")
    parser.add_argument("--readme", action="store_true", help="renew their short form in README.md")
    options = parser.parse_args(arguments)
    root, folder = need_checkout("the table of claims"), options.write
    if options.readme:
        renew_block(root / "README.md", "claims", in_short(*closing_rows(root / "results")))
        return 0
    for table in closing_tables(root / "results"):
        print(table.to_markdown())
        for path in table.write(folder) if folder else ():
            print(path, file=sys.stderr)
    return 0


def closing_tables(results: Path) -> tuple[Table, Table]:
    """Make the tables of every published number and of every claim, see `closing_rows`."""
    return closing_tables_of(*closing_rows(results))


def closing_tables_of(numbers: list[Line], claims: list[Claim]) -> tuple[Table, Table]:
    """Make the same tables of rows that were made before."""
    made = numbers_table(numbers), claims_table(claims)
    for table in made:
        table.origin = Origin(COMMAND, **signature(NO_PROFILE), processor=NONE, seeds=NONE)
    return made


def closing_rows(results: Path) -> tuple[list[Line], list[Claim]]:
    """Set ours beside every published number and give every claim its verdict.

    Args:
        results: Folder with `published_results.csv`, `claims.yaml` and the folders of tables.
    """
    published = read_published(results / "published_results.csv")
    entries, reasons = read_claims(results / "claims.yaml")
    evidence = Evidence(results)
    settings = {robot: table_one(robot) for robot in published.robots("hyperparameters")}
    numbers = every_number(published, evidence, settings, reasons)
    return numbers, every_claim(entries, evidence)


def in_short(numbers: list[Line], claims: list[Claim]) -> str:
    """Return what README.md says of both tables: verdicts with the ids of their claims, counts."""
    lines = ["| verdict | claims of the paper |", "| --- | --- |"]
    for verdict in VERDICTS:
        ids = [claim.id.replace("_", " ") for claim in claims if claim.verdict.verdict == verdict]
        lines.append(f"| {verdict}: {len(ids)} | {', '.join(ids)} |")
    ours = sum(number.measured is not None for number in numbers)
    return "\n".join(
        [
            *lines,
            "",
            f"Of the {len(numbers)} numbers that the paper publishes, {ours} have one of ours "
            "beside them, the others the reason why not.",
        ]
    )


def table_one(robot: str) -> Setting:
    """Return what Table I's network of a robot is configured with here."""
    config = compose([f"robot={robot}"]).robot.table_one
    names = ("batch_size", "learning_rate", "tanh_layers", "position_weight", "rotation_weight")
    values = {name: float(getattr(config, name)) for name in names}
    return Setting(values, config.hidden, load_robot(robot).dof)
