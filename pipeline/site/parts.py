"""What a page is made of: sections with tables, charts, pictures and prose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from markupsafe import Markup

from pipeline.presentation.table import Table


@dataclass(frozen=True)
class Sheet:
    """A table on a page.

    Attributes:
        table: What is in it.
        folded: It is shown when it is opened.
        most: Rows on the page, the first ones; the file beside it has all.
    """

    table: Table
    folded: bool = False
    most: int | None = None
    kind: str = "sheet"


@dataclass(frozen=True)
class Picture:
    """A figure or a video of the results, copied beside the page.

    Attributes:
        name: Its anchor.
        caption: How to read it.
        source: Where it lies, seen from the page.
        video: It moves.
        further: Another form of it, such as a PDF.
    """

    name: str
    caption: str
    source: str
    video: bool = False
    further: str = ""
    kind: str = "picture"


@dataclass(frozen=True)
class Chart:
    """A figure that answers to the pointer.

    Attributes:
        name: Its anchor.
        title: Heading.
        caption: How to read it.
        svg: The picture.
        group: Charts of one group share a menu that shows one of them; empty for one by itself.
        choice: How it is called in that menu.
    """

    name: str
    title: str
    caption: str
    svg: Markup
    group: str = ""
    choice: str = ""
    kind: str = "chart"


@dataclass(frozen=True)
class Card:
    """A number of the first page.

    Attributes:
        title: What it is.
        value: The number and its unit.
        beside: What it is to be compared with.
        link: Page with the whole of it.
    """

    title: str
    value: str
    beside: str
    link: str


@dataclass(frozen=True)
class Cards:
    """Numbers side by side."""

    cards: Sequence[Card]
    kind: str = "cards"


@dataclass(frozen=True)
class Prose:
    """Paragraphs."""

    html: Markup
    kind: str = "prose"


Item = Sheet | Picture | Chart | Cards | Prose


@dataclass(frozen=True)
class Section:
    """Items under a heading.

    Attributes:
        anchor: Link to it on the page.
        title: Heading; empty for what stands at the top.
        items: In order.
    """

    anchor: str
    title: str
    items: Sequence[Item]


@dataclass(frozen=True)
class Page:
    """A page.

    Attributes:
        name: Of its file, without suffix.
        title: Heading, and what it is called in the list of pages.
        lead: One sentence below it.
        sections: In order.
        kicker: Group of pages that it stands under in the list.
    """

    name: str
    title: str
    lead: str
    sections: Sequence[Section] = field(default_factory=list)
    kicker: str = ""
