"""What stands on the pages: of the run, of the paper, of suites, protocols and studies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import yaml
from markupsafe import Markup

from pipeline.locations import CONF_DIR
from pipeline.presentation.columns import Column, plain, significant, text
from pipeline.presentation.naming import ordered_robots, robot_title
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import Table
from pipeline.reporting.chapters import CHAPTERS, Chapter
from pipeline.reporting.claims import VERDICTS, Claim
from pipeline.reporting.data import ReportData
from pipeline.reporting.numbers import Line
from pipeline.reporting.page import LIMITS, SHOWN_MEDIA
from pipeline.reporting.provenance import provenance_lines
from pipeline.reporting.report import draw_figures, make_tables
from pipeline.reporting.results import VIDEOS
from pipeline.site.figures import error_and_time
from pipeline.site.files import copied
from pipeline.site.parts import Card, Cards, Item, Page, Picture, Prose, Section, Sheet
from pipeline.site.studies import MANY, MOST, committed_table, pictures_beside

THIS_RUN, PROJECT = "This run", "The project"
PAPER = "paper"  # chapter of the report that the page of the paper takes in
CLAIMS = ("id", "verdict", "claim", "reason", "where", "test", "rows")  # columns as shown
FIGURES, MEDIA = "figures", "media"
PAPER_TABLES = ("paper/tables/*.csv", "paper/table_one/*/table*.csv", "paper/older/*.csv")


@dataclass(frozen=True)
class Closing:
    """The paper's numbers and claims with ours, as rows and as tables.

    Attributes:
        numbers: Every published number.
        claims: Every claim.
        tables: Both as tables, in this order.
    """

    numbers: Sequence[Line]
    claims: Sequence[Claim]
    tables: tuple[Table, Table]


def start_page(data: ReportData, closing: Closing, title: str) -> Page:
    """Make the first page: what this is, the numbers to know, what they do not say."""
    run = [
        Section("notes", "What this run lacks", [Prose(_list(data.results.notes))]),
    ]
    lines = provenance_lines(data.results)
    return Page(
        "index",
        "Start",
        f"{title}: the method of Habekost, Gäde, Allgeuer and Wermter (IROS 2024) written anew, "
        "its experiments run again in simulation, and every published number beside ours.",
        [
            Section("claims", "", [_claim_cards(closing)]),
            Section("headlines", "CycleIK in the paper's metric", _headline_items(closing)),
            Section("limits", "Known limitations", [Prose(Markup(LIMITS.read_text("utf-8")))]),
            *(run if data.results.notes else []),
            Section("provenance", "Provenance of this run", [Prose(_pairs(lines))]),
        ],
    )


def paper_page(data: ReportData, closing: Closing, results: Path, folder: Path) -> Page:
    """Make the page of every published number and every claim."""
    chapter = next(each for each in CHAPTERS if each.anchor == PAPER)
    paths = [path for pattern in PAPER_TABLES for path in sorted(results.glob(pattern))]
    numbers, claims = closing.tables
    sections = [
        Section("claims", "Every claim", [Sheet(_reordered(claims, CLAIMS))]),
        Section("numbers", "Every published number", [Sheet(numbers)]),
        Section("tables", "The paper's tables, this run", _sheets(data, chapter, folder)),
        Section(
            "committed",
            "The paper's tables, at its scale",
            [Sheet(committed_table(path, path.parent.name)) for path in paths],
        ),
    ]
    lead = "What the paper says and what came out here: each claim with its verdict and reason."
    return Page("paper", "The paper", lead, [each for each in sections if each.items])


def chapter_pages(data: ReportData, folder: Path) -> Iterator[Page]:
    """Make a page for each other chapter of the report that has anything to show."""
    for chapter in CHAPTERS:
        if chapter.anchor == PAPER:
            continue
        defined = {"suites": suite_table, "protocols": protocol_table}.get(chapter.anchor)
        charts: list[Item] = []
        if chapter.anchor == "solvers":
            charts = list(error_and_time(data.summary))
        sections = [
            Section("figure", "Error and time", charts),
            Section("tables", "Tables", _sheets(data, chapter, folder)),
            Section("figures", "Figures", list(_figures(data, chapter, folder))),
            Section("media", "Pictures and videos", list(_media(data, chapter, folder))),
            Section("defined", "What is measured", [Sheet(defined())] if defined else []),
        ]
        kept = [section for section in sections if section.items]
        if kept:
            yield Page(chapter.anchor, chapter.title, chapter.lead, kept, THIS_RUN)


def studies_page(results: Path, folder: Path) -> Page:
    """Make the page of all committed studies."""
    root = results / "studies"
    paths = sorted(root.rglob("*.csv"))
    pictures = pictures_beside(root, [path.stem for path in paths if path.parent == root])
    sections = []
    for path in paths:
        group = "study" if path.parent == root else path.parent.name
        table = committed_table(path, group)
        mine = pictures.get(path.stem, []) if path.parent == root else []
        sheet = Sheet(table, folded=len(table.rows) > MANY, most=MOST)
        items: list[Item] = [sheet, *_shown(mine, folder)]
        place = path.stem if path.parent == root else f"{path.parent.name}: {path.stem}"
        sections.append(Section(f"{table.name}-study", plain(place).capitalize(), items))
    others = list(_shown(pictures.get("", []), folder))
    sections += [Section("pictures", "Further figures", others)] if others else []
    lead = "Experiments beside the pipeline, as they were committed, each with its command."
    return Page("studies", "Studies", lead, sections, PROJECT)


def suite_table() -> Table:
    """The table of suites of conf/suite."""
    columns = (
        text("name", "Suite", convert=plain),
        text("version", "version"),
        text("what", "poses"),
    )
    return _defined("suite", columns, "What is in a suite")


def protocol_table() -> Table:
    """The table of protocols of conf/protocol."""
    columns = (text("title", "Protocol"), text("source", "source"), text("what", "how it measures"))
    return _defined("protocol", columns, "What a protocol is")


def _defined(group: str, columns: Sequence[Column], title: str) -> Table:
    """What the files of a group of the configuration say of themselves."""
    lines = []
    for path in sorted((CONF_DIR / group).glob("*.yaml")):
        content = path.read_text(encoding="utf-8")
        said = [line.removeprefix("#").strip() for line in _head(content)]
        values = yaml.safe_load(content)
        lines.append({"what": " ".join(said), **{key: values.get(key) for key in _NAMED}})
    table = Table.of(
        lines,
        columns,
        name=f"{group}_definitions",
        title=title,
        caption=f"As `conf/{group}` says it.",
    )
    table.origin = Origin("python -m pipeline site", *["none: it is the configuration"] * 5)
    return table


_NAMED = ("name", "version", "title", "source")


def _head(content: str) -> Iterator[str]:
    for line in content.splitlines():
        if not line.startswith("#"):
            return
        yield line


def _reordered(table: Table, names: Sequence[str]) -> Table:
    """A table with its columns in another order, what is looked for first."""
    places = [[column.name for column in table.columns].index(name) for name in names]
    rows = [[row[i] for i in places] for row in table.rows]
    return replace(table, columns=[table.columns[i] for i in places], rows=rows)


def _sheets(data: ReportData, chapter: Chapter, folder: Path) -> list[Item]:
    return [
        Sheet(with_linked_files(table, data.results.folder, folder), len(table.rows) > 3 * MANY)
        for table in make_tables(data, chapter.topics)
    ]


def with_linked_files(table: Table, results: Path, folder: Path) -> Table:
    """Copy the files that a table links to beside the pages, and return it with links to them.

    Args:
        table: Paths in its columns of links are seen from the results folder.
        results: The results folder.
        folder: Of the pages.

    Returns:
        The table; a cell whose file is not there is empty.
    """
    links = [column.link for column in table.columns]
    rows = [
        [
            _copied_result(results / cell, results, folder)
            if link and isinstance(cell, str)
            else cell
            for link, cell in zip(links, row, strict=True)
        ]
        for row in table.rows
    ]
    return replace(table, rows=rows)


def _copied_result(path: Path, results: Path, folder: Path) -> str | None:
    """Copy a file of the results and return its address; None where there is none."""
    if not path.is_file():
        return None
    return copied(path, folder, MEDIA, path.relative_to(results).as_posix())


def _figures(data: ReportData, chapter: Chapter, folder: Path) -> Iterator[Picture]:
    for figure in draw_figures(data, chapter.topics, folder / FIGURES):
        source = f"{FIGURES}/{figure.path.name}"
        further = f"{FIGURES}/{figure.path.with_suffix('.pdf').name}"
        name = f"figure-{figure.name}"  # a table may have the same
        yield Picture(name, figure.caption, source, further=further)


def _shown(paths: Sequence[Path], folder: Path) -> Iterator[Picture]:
    for path in paths:
        source = copied(path, folder, FIGURES, f"study_{path.name}")
        yield Picture(f"figure-{path.stem}", plain(path.stem).capitalize() + ".", source)


def _media(data: ReportData, chapter: Chapter, folder: Path) -> Iterator[Picture]:
    """Pictures and videos of a chapter's stages, not more of each than the report shows."""
    for (stage, robot), paths in data.results.media.items():
        if stage not in chapter.media:
            continue
        for path in paths[:SHOWN_MEDIA]:
            source = _copied_result(path, data.results.folder, folder)
            caption = f"{robot_title(robot)}: {plain(path.stem)}."
            if source:
                name = source.replace("/", "-")
                yield Picture(name, caption, source, video=path.suffix in VIDEOS)


def _claim_cards(closing: Closing) -> Cards:
    found = [claim.verdict.verdict for claim in closing.claims]
    cards = [
        Card(
            name.capitalize(),
            str(found.count(name)),
            f"of {len(found)} claims",
            "paper.html#claims",
        )
        for name in VERDICTS
    ]
    ours = sum(line.measured is not None for line in closing.numbers)
    return Cards(
        [
            *cards,
            Card(
                "Published numbers",
                str(ours),
                f"of {len(closing.numbers)} have one of ours",
                "paper.html#numbers",
            ),
        ]
    )


def _headline_items(closing: Closing) -> list[Item]:
    """A card a robot: mean position error and success of the network, and the paper's."""
    found: dict[tuple[str, str], Line] = {
        (line.robot, line.metric): line
        for line in closing.numbers
        if (line.table, line.method) == ("numerical_comparison", "cycleik") and line.measured
    }
    cards = []
    for robot in ordered_robots(robot for robot, _ in found):
        error = found.get((robot, "position_error_mean"))
        success = found.get((robot, "success_rate"))
        if error is None or success is None:
            continue
        shown = [
            significant(float(each.measured.value), 3) for each in (error, success) if each.measured
        ]
        cards.append(
            Card(
                robot_title(robot),
                f"{shown[0]} mm · {shown[1]} %",
                f"paper {error.published} mm · {success.published} %",
                "paper.html#every_number",
            )
        )
    said = Markup(
        "<p class='caption'>Mean position error and success (10 mm, 20 deg), errors averaged over "
        "the axes; the network alone, from committed rows.</p>"
    )
    return [Cards(cards), Prose(said)] if cards else []


def _list(items: Sequence[str]) -> Markup:
    return Markup("<ul>{}</ul>").format(
        Markup("").join(Markup("<li>{}</li>").format(i) for i in items)
    )


def _pairs(pairs: Sequence[tuple[str, str]]) -> Markup:
    lines = Markup("").join(Markup("<li><b>{}</b>: {}</li>").format(*pair) for pair in pairs)
    return Markup("<ul>{}</ul>").format(lines)
