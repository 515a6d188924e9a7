"""What tables and figures are made of, and how a topic says which ones it has."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from pipeline.presentation.published import Published
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.results import Results


@dataclass(frozen=True)
class ReportData:
    """What tables and figures are made of.

    Attributes:
        results: Everything on disk.
        published: The paper's numbers.
        summary: One line a robot, solver and batch size.
        pairs: Two solvers on the same poses, one line a pair.
        effects: One solver from home and from a neural seed, one line a batch size.
        config: Policies, confidence, looks.
        profile: Of the run that asks; empty where nobody said.
    """

    results: Results
    published: Published
    summary: pd.DataFrame
    pairs: pd.DataFrame
    effects: pd.DataFrame
    config: ReportConfig
    profile: str = ""


@dataclass(frozen=True)
class Plot:
    """A figure of a topic.

    Attributes:
        name: File name without suffix.
        caption: How to read it; a function where it depends on the rows.
        needs: What it is drawn from; where that is empty there is no figure.
        draw: Draws it.
    """

    name: str
    caption: str | Callable[[ReportData], str]
    needs: Callable[[ReportData], Any]
    draw: Callable[[ReportData], Figure]

    def caption_for(self, data: ReportData) -> str:
        """Return the caption."""
        return self.caption if isinstance(self.caption, str) else self.caption(data)


@dataclass(frozen=True)
class Topic:
    """Tables and figures of one topic; a table without rows is left out.

    Attributes:
        tables: Make one table each.
        plots: The figures.
        stages: Whose rows the tables are made of: their origin stands with each table.
    """

    tables: tuple[Callable[[ReportData], Table], ...] = ()
    plots: tuple[Plot, ...] = ()
    stages: tuple[str, ...] = ("evaluate",)
