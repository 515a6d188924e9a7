"""report.html: one self-contained file with every table and figure and where they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image

from pipeline.presentation.columns import NOTHING
from pipeline.presentation.naming import ordered_robots, robot_title, solver_title
from pipeline.presentation.table import Table
from pipeline.presentation.templates import environment
from pipeline.reporting.chapters import Chapter
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.provenance import configurations, provenance_lines
from pipeline.reporting.results import VIDEOS, Results
from pipeline.reporting.wall import data_uri, walls

TEMPLATE = "report.html.jinja"
LIMITS = Path(__file__).with_name("limits.html.jinja")  # what the numbers do not say
TYPES = {".png": "image/png", ".gif": "image/gif", ".mp4": "video/mp4"}
SHOWN_MEDIA = 12  # pictures and videos of one stage and robot; the rest is counted
BYTES_PER_MB = 1e6
PIXELS_PER_INCH = 125
FOLD_ABOVE = 36  # rows beyond which a table is folded away until it is opened


@dataclass(frozen=True)
class Illustration:
    """A figure with what to see in it."""

    name: str
    caption: str
    path: Path


@dataclass(frozen=True)
class Section:
    """A chapter with what there is for it."""

    chapter: Chapter
    tables: list[Table]
    figures: list[Illustration]


def render(results: Results, config: ReportConfig, sections: Sequence[Section]) -> str:
    """Return the page as HTML; every picture is inside the file.

    Args:
        results: What was on disk, with notes on what was not.
        config: Title and sizes.
        sections: The chapters, in order; one that has nothing to show is left out.
    """
    budget = _Budget(config.embed_mb * BYTES_PER_MB)
    shown = [_section(section, results, config, budget) for section in sections]
    return (
        environment(Path(__file__).parent)
        .get_template(TEMPLATE)
        .render(
            title=config.title,
            profile=results.folder.name,
            robots=[robot_title(name) for name in ordered_robots(results.robots)],
            headlines=_headlines([table for section in sections for table in section.tables]),
            sections=[s for s in shown if s["tables"] or s["figures"] or s["media"] or s["walls"]],
            notes=results.notes,
            provenance=provenance_lines(results),
            details=configurations(results),
            fold_above=FOLD_ABOVE,
        )
    )


class _Budget:
    """Bytes of video that may still go into the file."""

    def __init__(self, left: float) -> None:
        self.left = left

    def take(self, size: int) -> bool:
        if size > self.left:
            return False
        self.left -= size
        return True


def _section(
    section: Section, results: Results, config: ReportConfig, budget: _Budget
) -> dict[str, Any]:
    """What the template shows of a chapter."""
    chapter = section.chapter
    return {
        "chapter": chapter,
        "tables": section.tables,
        "figures": [
            {
                "name": figure.name,
                "caption": figure.caption,
                "source": _data_uri(figure.path),
                "width": _width(figure.path, config.dpi),
            }
            for figure in section.figures
        ],
        "media": [item for stage in chapter.media for item in _media(results, stage, budget)],
        "walls": walls(results) if chapter.wall else [],
    }


def _media(results: Results, stage: str, budget: _Budget) -> list[dict[str, Any]]:
    shown = []
    for (name, robot), paths in results.media.items():
        if name != stage:
            continue
        for path in paths[:SHOWN_MEDIA]:
            is_video = path.suffix in VIDEOS
            link = path.relative_to(results.folder).as_posix()
            fits = budget.take(path.stat().st_size)
            shown.append(
                {
                    "caption": f"{robot_title(robot)}: {path.stem.replace('_', ' ')}",
                    "video": is_video,
                    "link": link,
                    "source": _data_uri(path) if fits else None,
                }
            )
        if len(paths) > SHOWN_MEDIA:
            more = f"{robot_title(robot)}: {len(paths) - SHOWN_MEDIA} more in the folder"
            folder = paths[0].parent.relative_to(results.folder).as_posix()
            shown.append({"caption": more, "video": False, "link": folder, "source": None})
    return shown


def _data_uri(path: Path) -> str:
    return data_uri(path.read_bytes(), TYPES[path.suffix])


def _width(path: Path, dpi: int) -> int:
    """Width on the page [CSS pixel], so that letters have one size in all figures."""
    with Image.open(path) as picture:
        return round(picture.width * PIXELS_PER_INCH / dpi)


def _headlines(tables: list[Table]) -> list[dict[str, str]]:
    """A card a robot: the network's precision in the paper's metric, and the paper's."""
    table = next((t for t in tables if t.name == "table2_numerical_comparison"), None)
    if table is None:
        return []
    names = [column.name for column in table.columns]
    rows = [dict(zip(names, row, strict=True)) for row in table.shown()]
    return [
        {
            "robot": cells["robot"],
            "error": cells["position_error_mean"],
            "error_paper": cells["position_error_mean_paper"],
            "success": cells["success_rate"],
            "success_paper": cells["success_rate_paper"],
        }
        for cells in rows
        if cells["solver"] == solver_title("cycleik") and cells["position_error_mean"] != NOTHING
    ]
