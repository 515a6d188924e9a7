"""Stage report: tables, figures and report.html, a pure function of what is on disk."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.locations import published_results
from pipeline.reporting.report import make_report
from pipeline.stages.inputs import artifacts

if TYPE_CHECKING:
    from pipeline.settings import Config


def run(config: Config) -> list[Path]:
    """Write tables/, figures/, report.html and metrics.json of a results folder."""
    root = artifacts(config).root
    paths = make_report(root, published_results(), config.report, config.profile)
    return [paths.tables, paths.figures, paths.html]
