"""A table as data: typed cells in, CSV, Markdown, LaTeX and HTML out."""

from __future__ import annotations

import csv
import html
import io
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.data.files import write_text

Cell = str | float | int | None
MOST_DECIMALS, SMALLEST = 4, 1e-4  # mm, deg and ms: finer is noise to a reader; the CSV has it
MADE_BY = "made by `python -m pipeline report` from the raw rows; do not edit"
NOTHING = "–"  # what is not there
TEX_SPECIAL = {"&": r"\&", "%": r"\%", "_": r"\_", "#": r"\#", "$": r"\$", "{": r"\{", "}": r"\}"}
TEX_SYMBOLS = {"σ": r"$\sigma$", "Δ": r"$\Delta$", "µ": r"$\mu$", "–": "--", "±": r"$\pm$"}
TEX_SYMBOLS |= {"≤": r"$\le$", "×": r"$\times$", "−": "$-$", "°": r"$^\circ$", "…": r"\dots{}"}


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: Name in the CSV, with its unit.
        title: Heading for people.
        group: Heading above, shared with neighbours.
        digits: Significant digits for numbers; None for text.
        signed: Show a plus sign too: a difference.
        percent: Numbers are shares, shown in per cent with that many decimals.
        decimals: Decimals instead of significant digits.
        link: Text is the path of a file, seen from the report; HTML links to it.
    """

    name: str
    title: str
    group: str = ""
    digits: int | None = None
    signed: bool = False
    percent: int | None = None
    decimals: int | None = None
    link: bool = False

    def show(self, value: Cell) -> str:
        """Format a cell for people; what is not there is a dash."""
        if value is None or (isinstance(value, float) and math.isnan(value)):
            return NOTHING
        if isinstance(value, str | bool):
            return str(value)
        sign = "+" if self.signed else ""
        if self.percent is not None:
            return f"{value * 100:{sign}.{self.percent}f}".replace("-", "−")
        if self.decimals is not None:
            return f"{value:{sign}.{self.decimals}f}".replace("-", "−")
        if self.digits is None:
            return f"{value:,}" if isinstance(value, int) else f"{value:g}"
        return significant(float(value), self.digits, self.signed)


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
    """

    name: str
    title: str
    caption: str
    columns: list[Column]
    rows: list[list[Cell]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(self, **cells: Cell) -> None:
        """Append a row by column name; columns left out stay empty."""
        unknown = set(cells) - {column.name for column in self.columns}
        if unknown:
            raise KeyError(f"table {self.name} has no column {sorted(unknown)}")
        self.rows.append([cells.get(column.name) for column in self.columns])

    def shown(self) -> list[list[str]]:
        """Return the rows as text for people."""
        return [
            [column.show(cell) for column, cell in zip(self.columns, row, strict=True)]
            for row in self.rows
        ]

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
            writer.writerow(["" if _absent(cell) else cell for cell in row])
        return stream.getvalue()

    def to_markdown(self) -> str:
        """Return a table for GitHub, under its title and caption."""
        heads = [" ".join(filter(None, (c.group, c.title))) for c in self.columns]
        rules = ["---" if column.is_text else "---:" for column in self._typed()]
        lines = [heads, rules, *self.shown()]
        body = "\n".join("| " + " | ".join(_no_bar(c) for c in line) + " |" for line in lines)
        notes = "".join(f"\n{note}  " for note in self.notes)
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
        lines += [rf"\\ \footnotesize {_tex(note)}" for note in self.notes]
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
        """Write the table as CSV, Markdown and LaTeX."""
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
        return paths

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


def significant(value: float, digits: int, signed: bool = False) -> str:
    """Format a number with so many significant digits, but at most four decimals."""
    if not math.isfinite(value):
        return str(value)
    sign = "+" if signed else ""
    if value == 0:
        return f"{0:{sign}.0f}"
    if abs(value) < SMALLEST / 2:
        return f"< {SMALLEST:g}" if value > 0 else f"> −{SMALLEST:g}"
    magnitude = math.floor(math.log10(abs(value)))
    decimals = min(max(digits - 1 - magnitude, 0), MOST_DECIMALS)
    return f"{value:{sign},.{decimals}f}".replace("-", "−")


def _html(column: Column, text: str) -> str:
    """A cell in HTML: a link, or the text."""
    escaped = html.escape(text)
    if column.link and text != NOTHING:
        return f'<a href="{escaped}">{html.escape(Path(text).name)}</a>'
    return escaped


def _absent(cell: Cell) -> bool:
    return cell is None or (isinstance(cell, float) and math.isnan(cell))


def _no_bar(text: str) -> str:
    return text.replace("|", "\\|")


def _tex(text: str) -> str:
    escaped = "".join(TEX_SPECIAL.get(character, character) for character in text)
    return "".join(TEX_SYMBOLS.get(character, character) for character in escaped)


def _tex_group(group: str, columns: int) -> str:
    return rf"\multicolumn{{{columns}}}{{c}}{{{_tex(group)}}}"
