"""report.html: one self-contained file with every table and figure and where they come from."""

from __future__ import annotations

import base64
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from PIL import Image

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import ordered_robots, robot_title, solver_title
from pipeline.reporting.outline import OUTLINE
from pipeline.reporting.provenance import configurations, provenance_lines
from pipeline.reporting.results import VIDEOS, Results
from pipeline.reporting.table import Table

TEMPLATE = "report.html.jinja"
TYPES = {".png": "image/png", ".gif": "image/gif", ".mp4": "video/mp4"}
SHOWN_MEDIA = 12  # pictures and videos of one stage and robot; the rest is counted
BYTES_PER_MB = 1e6
PIXELS_PER_INCH = 125
FOLD_ABOVE = 36  # rows beyond which a table is folded away until it is asked for


@dataclass(frozen=True)
class Illustration:
    """A figure with what to see in it."""

    name: str
    caption: str
    path: Path


@dataclass(frozen=True)
class Page:
    """What the page shows.

    Attributes:
        results: What was on disk, with notes on what was not.
        config: Title and sizes.
        tables: All tables that have rows.
        illustrations: All figures.
    """

    results: Results
    config: ReportConfig
    tables: list[Table]
    illustrations: list[Illustration]


@dataclass
class Section:
    """A chapter of the page; it is left out where it has nothing to show."""

    anchor: str
    title: str
    lead: str
    tables: list[Table] = field(default_factory=list)
    figures: list[dict[str, Any]] = field(default_factory=list)
    media: list[dict[str, Any]] = field(default_factory=list)

    @property
    def empty(self) -> bool:
        """Whether there is nothing in it."""
        return not (self.tables or self.figures or self.media)


def render(page: Page) -> str:
    """Return the page as HTML; every picture is inside the file."""
    budget = _Budget(page.config.embed_mb * BYTES_PER_MB)
    sections = [section for section in _sections(page, budget) if not section.empty]
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE).render(
        title=page.config.title,
        profile=page.results.folder.name,
        robots=[robot_title(name) for name in ordered_robots(page.results.robots)],
        headlines=_headlines(page.tables),
        sections=sections,
        notes=page.results.notes,
        provenance=provenance_lines(page.results),
        details=configurations(page.results),
        fold_above=FOLD_ABOVE,
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


def _sections(page: Page, budget: _Budget) -> Iterable[Section]:
    tables = {table.name: table for table in page.tables}
    figures = {illustration.name: illustration for illustration in page.illustrations}
    for anchor, title, lead, table_names, figure_names, stages in OUTLINE:
        section = Section(anchor, title, lead)
        section.tables = [tables[name] for name in table_names if name in tables]
        for name in figure_names:
            if name in figures:
                shown = figures[name]
                section.figures.append(
                    {
                        "name": name,
                        "caption": shown.caption,
                        "source": _data_uri(shown.path),
                        "width": _width(shown.path, page.config.dpi),
                    }
                )
        for stage in stages:
            section.media += _media(page.results, stage, budget)
        yield section


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
    content = base64.b64encode(path.read_bytes()).decode("ascii")
    return f"data:{TYPES[path.suffix]};base64,{content}"


def _width(path: Path, dpi: int) -> int:
    """Width on the page [CSS pixel], so that letters have one size in all figures."""
    with Image.open(path) as picture:
        return round(picture.width * PIXELS_PER_INCH / dpi)


def _headlines(tables: list[Table]) -> list[dict[str, str]]:
    """A card a robot: the network's precision in the paper's metric, and the paper's."""
    cards = []
    table = next((t for t in tables if t.name == "table2_numerical_comparison"), None)
    if table is None:
        return []
    names = [column.name for column in table.columns]
    for row in table.shown():
        cells = dict(zip(names, row, strict=True))
        if cells["solver"] == solver_title("cycleik") and cells["position_error_mean"] != "–":
            cards.append(
                {
                    "robot": cells["robot"],
                    "error": cells["position_error_mean"],
                    "error_paper": cells["position_error_mean_paper"],
                    "success": cells["success_rate"],
                    "success_paper": cells["success_rate_paper"],
                }
            )
    return cards
