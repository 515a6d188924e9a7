"""A study's table in results/studies, signed by what made it."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pipeline import provenance
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import write_origin

STUDIES = Path(__file__).parents[1] / "results" / "studies"


def write_study(
    name: str,
    table: pd.DataFrame,
    text: str,
    command: str,
    seeds: str,
    profile: str = "none",
    networks: str = "",
) -> None:
    """Write `name`.csv and `name`.md, and add its origin to those beside it.

    Args:
        name: Of the files.
        table: The rows.
        text: Markdown for people.
        command: Makes the study again.
        seeds: What its random numbers come from.
        profile: Of conf/profile; none where the study has sizes of its own.
        networks: Models and recipes behind neural rows.
    """
    STUDIES.mkdir(parents=True, exist_ok=True)
    table.to_csv(STUDIES / f"{name}.csv", index=False)
    made_by = Origin(
        command,
        **provenance.signature(profile),
        processor=provenance.machine()["processor"],
        seeds=seeds,
        networks=networks,
    )
    (STUDIES / f"{name}.md").write_text(f"{text.rstrip()}\n\n{made_by.sentence()}\n", "utf-8")
    write_origin(STUDIES, name, made_by)
