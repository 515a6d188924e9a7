"""Stage report: tables, figures and report.html, a pure function of what is on disk."""

from __future__ import annotations

from pathlib import Path

from pipeline.provenance import ROOT
from pipeline.reporting.report import make_report
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts


def run(config: Config) -> list[Path]:
    """Write tables/, figures/, report.html and metrics.json of a results folder."""
    published = ROOT / "results" / "published_results.csv"
    paths = make_report(artifacts(config).root, published, config.report, config.profile)
    return [paths.tables, paths.figures, paths.html]
