"""Stage report: tables, figures and report.html, a pure function of what is on disk."""

from __future__ import annotations

from pathlib import Path

from pipeline.locations import published_results
from pipeline.reporting import make_report
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts


def run(config: Config) -> list[Path]:
    """Write tables/, figures/, report.html and metrics.json of a results folder."""
    root = artifacts(config).root
    paths = make_report(root, published_results(), config.report, config.profile)
    return [paths.tables, paths.figures, paths.html]
