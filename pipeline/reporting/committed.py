"""Tables of studies that are committed: what takes its own command, whatever the profile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import pandas as pd

from pipeline.data.files import read_json
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import ORIGINS, Table
from pipeline.reporting.results import Results

STUDIES = "studies"  # beside the results folders of profiles


def committed(results: Results, name: str, make: Callable[[pd.DataFrame], Table]) -> Table:
    """Return the table of a study beside a results folder, signed by the command that made it.

    Args:
        results: Of a profile.
        name: Of the study: its rows are in ``studies/<name>.csv``.
        make: Makes the table of the rows; of none where there is no such study.
    """
    path = results.folder.parent / STUDIES / f"{name}.csv"
    if not path.exists():
        return make(pd.DataFrame())
    table = make(pd.read_csv(path))
    facts = read_json(path.with_name(ORIGINS))[name]
    table.origin = Origin(**{field.name: facts[field.name] for field in fields(Origin)})
    return table
