"""Tables, figures and report.html: a pure function of what the stages left on disk."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pipeline.reporting.config import ReportConfig
    from pipeline.reporting.report import ReportPaths


def make_report(
    results_dir: Path, published: Path, config: ReportConfig, profile: str = ""
) -> ReportPaths:
    """Write tables, figures, report.html and metrics.json; see `pipeline.reporting.report`."""
    # The configuration schema imports this package: what draws is loaded when something is drawn.
    from pipeline.reporting.report import make_report as build

    return build(results_dir, published, config, profile)
