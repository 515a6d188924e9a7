"""A site as a reader's browser takes it: pages parsed, ids, links, tables."""

from __future__ import annotations

from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path

VOID = {"meta", "link", "img", "input", "br", "circle", "line", "polyline", "path"}


@dataclass
class Parsed(HTMLParser):
    """What stands on a page."""

    ids: list[str] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    tables: dict[str, list[list[str]]] = field(default_factory=dict)
    heads: dict[str, list[str]] = field(default_factory=dict)
    tags: list[tuple[str, dict[str, str]]] = field(default_factory=list)
    open: list[str] = field(default_factory=list)
    unbalanced: list[str] = field(default_factory=list)
    text: str = ""
    _name: str = ""

    def __post_init__(self) -> None:
        super().__init__(convert_charrefs=True)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {key: value or "" for key, value in attrs}
        self.tags.append((tag, found))
        self.ids += [found["id"]] if "id" in found else []
        self.links += [found[key] for key in ("href", "src") if key in found]
        if tag == "table":
            self._name = found["data-name"]
            self.tables[self._name], self.heads[self._name] = [], []
        if tag == "tr" and "tbody" in self.open:
            self.tables[self._name].append([])
        if tag == "td":
            self.tables[self._name][-1].append("")
        if tag == "th" and found.get("scope") == "col":
            self.heads[self._name].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID:
            return
        if not self.open or self.open.pop() != tag:
            self.unbalanced.append(tag)

    def handle_data(self, data: str) -> None:
        self.text += data
        if "td" in self.open:
            self.tables[self._name][-1][-1] += data
        elif "th" in self.open and self.heads[self._name]:
            self.heads[self._name][-1] += data


def parsed(path: Path) -> Parsed:
    """Parse a page."""
    page = Parsed()
    page.feed(path.read_text(encoding="utf-8"))
    page.close()
    return page
