"""Tables II and III alone, straight from raw rows: seconds, where a whole report takes minutes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.data.tables import read_metadata, read_table
from pipeline.errors import MissingArtifactError, PipelineError
from pipeline.evaluation.config import solver_of_rows
from pipeline.presentation.naming import NEURAL
from pipeline.presentation.origin import origin_of
from pipeline.presentation.published import Published
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.summary import summarise
from pipeline.reporting.topics.paper import neural_comparison, numerical_comparison
from robots.suggestions import unknown_name

Maker = Callable[[pd.DataFrame, Published], Table]
# Name on the command line: what makes the table, and the solvers that it is about (all if empty).
MAKERS: dict[str, tuple[Maker, Collection[str]]] = {
    "table2": (numerical_comparison, ()),
    "table3": (neural_comparison, NEURAL),
}
READERS = 2  # files read at a time: decompression and checksums leave Python alone


def paper_table(
    name: str, folders: Sequence[Path], published: Published, config: ReportConfig
) -> tuple[Table, Path]:
    """Make one of the paper's tables from the first folder that holds rows for it.

    Args:
        name: ``table2`` or ``table3``.
        folders: Results folders, the one that is preferred first.
        published: The paper's numbers.
        config: Not-found policy, success, confidence.

    Returns:
        The table, whose last note says where its rows come from, and that folder.

    Raises:
        PipelineError: There is no such table.
        MissingArtifactError: None of the folders has rows for it.
        TableError: A file of rows is damaged.
    """
    if name not in MAKERS:
        raise PipelineError(unknown_name("table", name, list(MAKERS)))
    make, solvers = MAKERS[name]
    for folder in folders:
        paths = sorted(
            path
            for path in (folder / "evaluate").glob("*/*.parquet")
            if not path.name.startswith(".")
            and (not solvers or solver_of_rows(path.stem) in solvers)
        )
        if paths:
            cards = [read_metadata(path) for path in paths]
            table = make(_summary(paths, cards, config), published)
            table.origin = origin_of(f"python -m pipeline table {name}", cards)
            robots = sorted({path.parent.name for path in paths})
            table.notes.append(f"Rows: {folder.name}/evaluate, {', '.join(robots)}.")
            return table, folder
    searched = " or ".join(str(folder / "evaluate") for folder in folders)
    raise MissingArtifactError(
        f"no rows for {name} in {searched}; make them with: python -m pipeline evaluate"
    )


def _summary(
    paths: Sequence[Path], cards: Sequence[dict[str, Any]], config: ReportConfig
) -> pd.DataFrame:
    """Summarise rows one file at a time; bootstrap intervals are in neither table."""
    plain = replace(config, resamples=1)
    with ThreadPoolExecutor(READERS) as pool:
        lines = pool.map(lambda path: summarise(read_table(path), plain), paths)
        named = [
            line.assign(network=card.get("network") or None)
            for line, card in zip(lines, cards, strict=True)
        ]
        return pd.concat(named, ignore_index=True)
