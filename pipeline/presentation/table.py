"""A table as data: lines and columns in, CSV, Markdown, LaTeX and HTML out."""

from __future__ import annotations

import csv
import html
import io
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.data.files import read_json, write_json, write_text
from pipeline.presentation.columns import NOTHING, Cell, Column, absent
from pipeline.presentation.origin import Origin

MADE_BY = "made from the raw rows by the command that is named below; do not edit"
ORIGINS = "provenance.json"  # beside tables: the origin of each by its name
TEX_SPECIAL = {"&": r"\&", "%": r"\%", "_": r"\_", "#": r"\#", "$": r"\$", "{": r"\{", "}": r"\}"}
TEX_SYMBOLS = {"σ": r"$\sigma$", "Δ": r"$\Delta$", "µ": r"$\mu$", "–": "--", "±": r"$\pm$"}
TEX_SYMBOLS |= {"≤": r"$\le$", "×": r"$\times$", "−": "$-$", "°": r"$^\circ$", "…": r"\dots{}"}


@dataclass
class Table:
    """Rows under columns, with a caption that says how to read them.

    Attributes:
        name: File name without suffix.
        title: Heading.
        caption: One or two sentences: what, on what, in which unit.
        columns: The columns.
        rows: Cells by row.
        notes: Remarks below the table.
        origin: What made its rows; a table is not written without.
    """

    name: str
    title: str
    caption: str
    columns: list[Column]
    rows: list[list[Cell]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    origin: Origin | None = None

    @classmethod
    def of(
        cls,
        lines: pd.DataFrame | Iterable[Any],
        columns: Sequence[Column],
        *,
        name: str,
        title: str,
        caption: str,
        notes: Sequence[str] = (),
    ) -> Table:
        """Make a table with a row for every line.

        Args:
            lines: What the rows are made of: a data frame, mappings or objects.
            columns: What of each line is shown, and how.
            name: File name without suffix.
            title: Heading.
            caption: One or two sentences: what, on what, in which unit.
            notes: Remarks below the table.

        Raises:
            KeyError: The data frame lacks the source of a column.
        """
        if isinstance(lines, pd.DataFrame):
            named = [c.name if c.source is None else c.source for c in columns]
            missing = [s for s in named if isinstance(s, str) and s not in lines.columns]
            if missing and len(lines):
                raise KeyError(f"the lines of table {name} have no column {missing}")
            lines = lines.to_dict("records")
        rows = [[column.cell(line) for column in columns] for line in lines]
        return cls(name, title, caption, list(columns), rows, list(notes))

    def records(self) -> list[dict[str, Cell]]:
        """Return the rows, each as cells by column name."""
        names = [column.name for column in self.columns]
        return [dict(zip(names, row, strict=True)) for row in self.rows]

    def shown(self) -> list[list[str]]:
        """Return the rows as text for people."""
        return [
            [column.show(cell) for column, cell in zip(self.columns, row, strict=True)]
            for row in self.rows
        ]

    def links(self) -> list[str]:
        """Return the paths that its columns of links hold."""
        linked = [i for i, column in enumerate(self.columns) if column.link]
        return [str(row[i]) for row in self.rows for i in linked if row[i]]

    def groups(self) -> list[tuple[str, int]]:
        """Return the group headings with the number of columns under each."""
        spans: list[tuple[str, int]] = []
        for column in self.columns:
            if spans and spans[-1][0] == column.group:
                spans[-1] = (column.group, spans[-1][1] + 1)
            else:
                spans.append((column.group, 1))
        return spans

    def to_csv(self) -> str:
        """Return full-precision values under names with units, without a comment line."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([column.name for column in self.columns])
        for row in self.rows:
            writer.writerow(["" if absent(cell) else cell for cell in row])
        return stream.getvalue()

    def to_markdown(self) -> str:
        """Return a table for GitHub, under its title and caption."""
        heads = [" ".join(filter(None, (c.group, c.title))) for c in self.columns]
        rules = ["---" if column.is_text else "---:" for column in self._typed()]
        lines = [heads, rules, *self.shown()]
        body = "\n".join("| " + " | ".join(_no_bar(c) for c in line) + " |" for line in lines)
        notes = "".join(f"\n{note}  " for note in self._remarks())
        return f"<!-- {MADE_BY} -->\n**{self.title}.** {self.caption}\n\n{body}\n{notes}\n"

    def to_latex(self) -> str:
        """Return a booktabs table environment."""
        spec = "".join("l" if column.is_text else "r" for column in self._typed())
        lines = [f"% {MADE_BY}", r"% needs \usepackage{booktabs}", r"\begin{table*}", r"\centering"]
        lines += [rf"\caption{{{_tex(self.title)}. {_tex(self.caption)}}}"]
        lines += [rf"\label{{tab:{self.name}}}", rf"\begin{{tabular}}{{{spec}}}", r"\toprule"]
        if any(group for group, _ in self.groups()):
            lines.append(" & ".join(_tex_group(g, n) for g, n in self.groups()) + r" \\")
        rows = [[column.title for column in self.columns], *self.shown()]
        set_rows = [" & ".join(_tex(cell) for cell in row) + r" \\" for row in rows]
        lines += [set_rows[0], r"\midrule", *set_rows[1:], r"\bottomrule", r"\end{tabular}"]
        lines += [rf"\\ \footnotesize {_tex(note)}" for note in self._remarks()]
        return "\n".join([*lines, r"\end{table*}", ""])

    def to_html(self) -> str:
        """Return a ``table`` element; a repeated first cell is written once."""
        typed = self._typed()
        head = ""
        if any(group for group, _ in self.groups()):
            spans = "".join(f'<th colspan="{n}">{html.escape(g)}</th>' for g, n in self.groups())
            head = f'<tr class="groups">{spans}</tr>'
        titles = "".join(
            f'<th class="{column.css}">{html.escape(column.title)}</th>' for column in typed
        )
        lines, before = [], ""
        for row in self.shown():
            new = row[0] != before
            cells = [_html(column, c) for column, c in zip(self.columns, row, strict=True)]
            cells[0] = cells[0] if new else ""
            joined = "".join(
                f'<td class="{c.css}">{text}</td>' for c, text in zip(typed, cells, strict=True)
            )
            lines.append(f'<tr class="first">{joined}</tr>' if new else f"<tr>{joined}</tr>")
            before = row[0]
        body = "".join(lines)
        return f"<table><thead>{head}<tr>{titles}</tr></thead><tbody>{body}</tbody></table>"

    def write(self, folder: Path) -> list[Path]:
        """Write the table as CSV, Markdown and LaTeX, and its origin into provenance.json there.

        Raises:
            ValueError: It does not say what made its rows.
        """
        if self.origin is None:
            raise ValueError(f"table {self.name} does not say what made its rows: set its origin")
        makers: Sequence[tuple[str, Callable[[], str]]] = (
            ("csv", self.to_csv),
            ("md", self.to_markdown),
            ("tex", self.to_latex),
        )
        paths = []
        for suffix, make in makers:
            path = folder / f"{self.name}.{suffix}"
            write_text(path, make())
            paths.append(path)
        write_origin(folder, self.name, self.origin)
        return paths

    def _remarks(self) -> list[str]:
        return [*self.notes, *([self.origin.sentence()] if self.origin else [])]

    def _typed(self) -> list[_Typed]:
        columns = zip(self.columns, zip(*self.rows, strict=True), strict=True) if self.rows else ()
        texts = [any(isinstance(c, str) for c in cells) for _, cells in columns]
        texts = texts or [True] * len(self.columns)
        groups = [column.group for column in self.columns]
        starts = [i > 0 and group != groups[i - 1] for i, group in enumerate(groups)]
        return [
            _Typed(column.title, is_text, starts_group)
            for column, is_text, starts_group in zip(self.columns, texts, starts, strict=True)
        ]


@dataclass(frozen=True)
class _Typed:
    """How a column is set: text to the left, numbers to the right, groups apart."""

    title: str
    is_text: bool
    starts_group: bool

    @property
    def css(self) -> str:
        kind = "text" if self.is_text else "number"
        return f"{kind} start" if self.starts_group else kind


def write_origin(folder: Path, name: str, origin: Origin) -> None:
    """Add the origin of a table to those beside it; those of tables that are no more go."""
    path = folder / ORIGINS
    known = read_json(path) if path.exists() else {}
    known[name] = origin.facts()
    there = {other.stem for other in folder.glob("*.csv")}
    write_json(path, {each: facts for each, facts in sorted(known.items()) if each in there})


def _html(column: Column, text: str) -> str:
    """A cell in HTML: a link, or the text."""
    escaped = html.escape(text)
    if column.link and text != NOTHING:
        return f'<a href="{escaped}">{html.escape(Path(text).name)}</a>'
    return escaped


def _no_bar(text: str) -> str:
    return text.replace("|", "\\|")


def _tex(text: str) -> str:
    escaped = "".join(TEX_SPECIAL.get(character, character) for character in text)
    return "".join(TEX_SYMBOLS.get(character, character) for character in escaped)


def _tex_group(group: str, columns: int) -> str:
    return rf"\multicolumn{{{columns}}}{{c}}{{{_tex(group)}}}"
