"""Figures as SVG by hand: small, sharp, legible in the dark, and every mark says what it is.

Neural solvers have the accent colour and filled marks, others are grey and hollow, so that nothing
rests on telling hues apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

from markupsafe import Markup

WIDTH, HEIGHT = 820, 430  # of the picture, in its own units
LEFT, RIGHT, TOP, BOTTOM = 74, 150, 18, 52  # margins around the axes
LETTER, LINE = 6.4, 15  # width of a letter of a label, height of a line
RADIUS = 5.5


@dataclass(frozen=True)
class Mark:
    """A point of a scatter.

    Attributes:
        name: Beside it.
        x: Where it is, in the unit of the axis.
        y: The same.
        said: What the pointer shows.
        strong: In the accent colour.
        front: On the Pareto front, which is drawn through it.
    """

    name: str
    x: float
    y: float
    said: str
    strong: bool = False
    front: bool = False


@dataclass(frozen=True)
class Curve:
    """A line that rises by steps.

    Attributes:
        name: At its end.
        points: (x, y), x rising.
        said: What the pointer shows.
        strong: In the accent colour.
    """

    name: str
    points: Sequence[tuple[float, float]]
    said: str
    strong: bool = False


@dataclass(frozen=True)
class Axis:
    """An axis: from where to where, and where a value lies on it.

    Attributes:
        title: With the unit.
        low: First value.
        high: Last value.
        log: Logarithmic.
    """

    title: str
    low: float
    high: float
    log: bool = True

    def share(self, value: float) -> float:
        """Return where a value lies, 0 at the low end and 1 at the high one."""
        at: Callable[[float], float] = math.log10 if self.log else float
        return (at(value) - at(self.low)) / (at(self.high) - at(self.low))

    def ticks(self) -> list[float]:
        """Return the values that are labelled."""
        if not self.log:
            return [self.low + (self.high - self.low) * i / 5 for i in range(6)]
        first, last = round(math.log10(self.low)), round(math.log10(self.high))
        return [10.0**power for power in range(first, last + 1)]


def decades(title: str, values: Sequence[float]) -> Axis:
    """Return a logarithmic axis of the powers of ten around positive values."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return Axis(title, 10.0**low, 10.0 ** max(high, low + 1))


def scatter(marks: Sequence[Mark], x: Axis, y: Axis, title: str) -> Markup:
    """Draw points with their names, and a line through those on the front."""
    front = sorted((_x(m.x, x), _y(m.y, y)) for m in marks if m.front)
    line = " ".join(f"{a:.1f},{b:.1f}" for a, b in front)
    parts = [*_axes(x, y), f'<polyline class="front" points="{line}"/>' if len(front) > 1 else ""]
    taken = [_box(_x(m.x, x), _y(m.y, y), 0) for m in marks]
    for mark in sorted(marks, key=lambda each: (not each.front, each.y)):
        at = _x(mark.x, x), _y(mark.y, y)
        css = "mark strong" if mark.strong else "mark"
        where, anchor = _label(*at, mark.name, taken)
        parts.append(
            f'<g class="{css}" tabindex="0" data-tip="{escape(mark.said)}">'
            f"<title>{escape(mark.said)}</title>"
            f'<circle cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{RADIUS}"/>'
            f'<text x="{where[0]:.1f}" y="{where[1]:.1f}" text-anchor="{anchor}">'
            f"{escape(mark.name)}</text></g>"
        )
    return _picture(parts, title)


def curves(lines: Sequence[Curve], x: Axis, y: Axis, title: str) -> Markup:
    """Draw lines that rise by steps, each named at its end."""
    ends = [_y(line.points[-1][1], y) for line in lines]
    places = spread(ends, LINE, HEIGHT - BOTTOM)
    parts = _axes(x, y)
    edge = WIDTH - RIGHT
    for line, end, place in zip(lines, ends, places, strict=True):
        css = "curve strong" if line.strong else "curve"
        parts.append(
            f'<g class="{css}" tabindex="0" data-tip="{escape(line.said)}">'
            f"<title>{escape(line.said)}</title>"
            f'<path class="reach" d="{_steps(line.points, x, y)}"/>'
            f'<path d="{_steps(line.points, x, y)}"/>'
            f'<path class="leader" d="M{edge} {end:.1f}L{edge + 14} {place:.1f}"/>'
            f'<text x="{edge + 18}" y="{place + 4:.1f}">{escape(line.name)}</text></g>'
        )
    return _picture(parts, title)


def spread(places: Sequence[float], gap: float, most: float) -> list[float]:
    """Move places apart until none is nearer than a gap to another, their order kept.

    Args:
        places: Of labels, downward.
        gap: Between two of them.
        most: The lowest place there is.
    """
    order = sorted(range(len(places)), key=lambda i: (places[i], i))
    moved = list(places)
    for before, after in pairwise(order):
        moved[after] = max(moved[after], moved[before] + gap)
    for i in reversed(order):
        moved[i] = min(moved[i], most)
        most = moved[i] - gap
    return moved


def _x(value: float, axis: Axis) -> float:
    return LEFT + axis.share(value) * (WIDTH - LEFT - RIGHT)


def _y(value: float, axis: Axis) -> float:
    return HEIGHT - BOTTOM - axis.share(value) * (HEIGHT - TOP - BOTTOM)


def _steps(points: Sequence[tuple[float, float]], x: Axis, y: Axis) -> str:
    """A path that goes right first, then up."""
    first = points[0]
    path = [f"M{_x(first[0], x):.1f} {_y(first[1], y):.1f}"]
    path += [f"H{_x(a, x):.1f}V{_y(b, y):.1f}" for a, b in points[1:]]
    return "".join(path) + f"H{WIDTH - RIGHT}"


def _axes(x: Axis, y: Axis) -> list[str]:
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    parts = []
    for tick in x.ticks():
        at = _x(tick, x)
        parts.append(f'<line class="grid" x1="{at:.1f}" x2="{at:.1f}" y1="{TOP}" y2="{bottom}"/>')
        parts.append(
            f'<text x="{at:.1f}" y="{bottom + 19}" text-anchor="middle">{tick:,.10g}</text>'
        )
    for tick in y.ticks():
        at = _y(tick, y)
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{right}" y1="{at:.1f}" y2="{at:.1f}"/>')
        parts.append(f'<text x="{LEFT - 9}" y="{at + 4:.1f}" text-anchor="end">{tick:,.10g}</text>')
    middle = (LEFT + right) / 2
    parts.append(f'<text class="axis" x="{middle}" y="{HEIGHT - 8}" text-anchor="middle">')
    parts.append(f"{escape(x.title)}</text>")
    height = (TOP + bottom) / 2
    parts.append(
        f'<text class="axis" transform="translate(16 {height}) rotate(-90)" text-anchor="middle">'
        f"{escape(y.title)}</text>"
    )
    return parts


Box = tuple[float, float, float, float]


def _box(x: float, y: float, width: float) -> Box:
    """The room of a point, or of a label that begins at it."""
    return (x - RADIUS, y - LINE / 2, x + max(width, RADIUS), y + LINE / 2)


def _label(x: float, y: float, name: str, taken: list[Box]) -> tuple[tuple[float, float], str]:
    """Where a label has room beside its point; to the right where it has none."""
    width, away = LETTER * len(name), RADIUS + 5
    tries = [
        (x + away, y, "start"),
        (x - away, y, "end"),
        *((x + away, y + LINE * step, "start") for step in (-1, 1)),
        *((x - away, y + LINE * step, "end") for step in (-1, 1)),
        *((x + away, y + LINE * step, "start") for step in (-2, 2, -3, 3)),
    ]
    chosen = tries[0]
    for at_x, at_y, anchor in tries:
        begin = at_x if anchor == "start" else at_x - width
        box = (begin, at_y - LINE / 2, begin + width, at_y + LINE / 2)
        if (
            begin > LEFT
            and at_y < HEIGHT - BOTTOM
            and not any(_meet(box, other) for other in taken)
        ):
            chosen = (at_x, at_y, anchor)
            break
    begin = chosen[0] if chosen[2] == "start" else chosen[0] - width
    taken.append((begin, chosen[1] - LINE / 2, begin + width, chosen[1] + LINE / 2))
    return (chosen[0], chosen[1] + 4), chosen[2]


def _meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _picture(parts: Sequence[str], title: str) -> Markup:
    box = f'viewBox="0 0 {WIDTH} {HEIGHT}" role="group"'
    return Markup(f'<svg {box} aria-label="{escape(title)}">{"".join(parts)}</svg>')
