"""Pages to files: one template, one style, one script, and the rows of every table beside them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment
from markupsafe import Markup, escape

from pipeline.artifacts import exclusive
from pipeline.data.files import write_text
from pipeline.presentation.templates import environment
from pipeline.site.files import remove_others
from pipeline.site.parts import Page, Picture, Sheet
from pipeline.site.sheet import view_of

HERE = Path(__file__).parent
TEMPLATE = "page.html.jinja"
DATA = "data"


@dataclass(frozen=True)
class Site:
    """What all pages share.

    Attributes:
        title: Of the whole.
        profile: Of the run that it shows.
        pages: In the order of the list.
        footer: Below each page.
    """

    title: str
    profile: str
    pages: Sequence[Page]
    footer: Sequence[str]


def write_site(site: Site, folder: Path) -> Path:
    """Write all pages and remove those of an earlier site that are no more.

    Args:
        site: The pages; their figures are in the folder already.
        folder: Where to, see `pipeline.site.files.claim`.

    Returns:
        The first page.
    """
    with exclusive(folder / "index.html"):
        template = _environment().get_template(TEMPLATE)
        for page in site.pages:
            for table in sheets_of(page):
                write_text(folder / DATA / f"{table.table.name}.csv", table.table.to_csv())
            write_text(folder / f"{page.name}.html", template.render(_shown(site, page)))
        remove_others(folder, written(site))
    return folder / "index.html"


def sheets_of(page: Page) -> list[Sheet]:
    """Return the tables of a page."""
    return [item for each in page.sections for item in each.items if isinstance(item, Sheet)]


def written(site: Site) -> set[str]:
    """Return the addresses of what belongs to a site, seen from its pages."""
    return {address for page in site.pages for address in _addresses(page)}


def _addresses(page: Page) -> Iterator[str]:
    yield f"{page.name}.html"
    for sheet in sheets_of(page):
        yield f"{DATA}/{sheet.table.name}.csv"
        yield from sheet.table.links()
    for item in (item for section in page.sections for item in section.items):
        if isinstance(item, Picture):
            yield from filter(None, (item.source, item.further))


def inline(text: str) -> Markup:
    """Return a text with `code`, *stress* and **more of it** as HTML, all else escaped."""
    safe = str(escape(text))
    safe = re.sub(r"(`+)([^`]+)\1", r"<code>\2</code>", safe)
    safe = re.sub(r"\*\*([^*]+)\*\*", r"<strong>\1</strong>", safe)
    return Markup(re.sub(r"(?<![\w*])\*([^*\s][^*]*)\*(?![\w*])", r"<em>\1</em>", safe))


def _environment() -> Environment:
    made = environment(HERE)
    made.filters["inline"] = inline
    return made


def _shown(site: Site, page: Page) -> dict[str, Any]:
    """What the template needs of a page."""
    menu: dict[str, list[Page]] = {}
    for each in site.pages:
        menu.setdefault(each.kicker, []).append(each)
    sections = [
        {"anchor": each.anchor, "title": each.title, "shown": [_item(item) for item in each.items]}
        for each in page.sections
    ]
    return {
        "title": site.title,
        "profile": site.profile,
        "page": page,
        "menu": list(menu.items()),
        "sections": sections,
        "footer": site.footer,
    }


def _item(item: Any) -> Any:
    if isinstance(item, Sheet):
        return {"kind": item.kind, "folded": item.folded, "view": view_of(item.table, item.most)}
    return item
