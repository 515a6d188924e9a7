"""Stage report: tables, figures and report.html, a pure function of what is on disk."""

from __future__ import annotations

from pathlib import Path

from pipeline.provenance import ROOT
from pipeline.reporting import make_report
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts


def run(config: Config) -> list[Path]:
    """Write tables/, figures/, report.html and metrics.json of a results folder."""
    paths = make_report(
        artifacts(config).root, ROOT / "results" / "published_results.csv", config.report
    )
    return [paths.tables, paths.figures, paths.html]
