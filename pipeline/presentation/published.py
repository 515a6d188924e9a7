"""The paper's numbers, as `results/published_results.csv` holds them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from pipeline.errors import PipelineError

COLUMNS = ("table", "robot", "method", "metric", "value", "unit")


class PublishedError(PipelineError):
    """The file of published numbers is missing or does not hold what it should."""


@dataclass(frozen=True)
class Published:
    """Published numbers by table, robot, method and metric.

    Attributes:
        rows: One row a number, with the columns table, robot, method, metric, value, unit.
    """

    rows: pd.DataFrame

    def text(self, table: str, robot: str, method: str, metric: str) -> str | None:
        """Return a number as it stands in the file, None where the paper has none."""
        rows = self.rows
        found = rows[
            (rows.table == table)
            & (rows.robot == robot)
            & (rows.method == method)
            & (rows.metric == metric)
        ]
        return None if found.empty else str(found.value.iloc[0])

    def number(self, table: str, robot: str, method: str, metric: str) -> float | None:
        """Return a published number, None where the paper has none."""
        text = self.text(table, robot, method, metric)
        return None if text is None else float(text)

    def methods(self, table: str, robot: str) -> list[str]:
        """Return the methods that a table lists for a robot, in its order."""
        rows = self.rows
        return list(dict.fromkeys(rows[(rows.table == table) & (rows.robot == robot)].method))

    def robots(self, table: str) -> list[str]:
        """Return the robots of a table, in its order."""
        return list(dict.fromkeys(self.rows[self.rows.table == table].robot))


def read_published(path: Path) -> Published:
    """Read the published numbers.

    Raises:
        PublishedError: There is no such file, or a column is missing.
    """
    try:
        rows = pd.read_csv(path, dtype=str, keep_default_na=False)
    except FileNotFoundError as error:
        raise PublishedError(f"there is no {path}: it holds the paper's numbers") from error
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise PublishedError(f"{path} is not readable as CSV ({error})") from error
    missing = [name for name in COLUMNS if name not in rows.columns]
    if missing:
        raise PublishedError(f"{path} lacks the column(s) {', '.join(missing)}")
    return Published(rows)
