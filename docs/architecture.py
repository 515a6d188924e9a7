"""Draws docs/architecture.svg from the imports of the code: python docs/architecture.py.

A box is a package, or modules that belong together. A line goes from a box to one that it imports,
and is left out where it follows from others: what a box imports is all that lies below it on lines.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from html import escape
from itertools import pairwise
from pathlib import Path
from statistics import fmean

import grimp

PICTURE = Path(__file__).with_suffix(".svg")
PACKAGES = ("pipeline", "baselines", "robots")
# What each box is; a test holds the names to the code.
BOXES = {
    "robots": "URDF, kinematics, collision, samples",
    "baselines": "numerical solvers, the solver protocol",
    "foundation": "errors, locations, seeds, provenance",
    "data": "pose sets, Parquet, checkpoints of rows",
    "engine": "tasks: processes, SLURM, Ray",
    "evaluation": "raw rows, errors, statistics",
    "suites": "hard poses, answers re-judged",
    "protocols": "everyone's way to measure",
    "learning": "networks, training, neural solvers",
    "exporting": "ONNX, TorchScript, a header of C",
    "planning": "Bezier motions, branches, timing",
    "reachability": "maps of places and orientations",
    "grasping": "PyBullet trials",
    "perception": "camera, detectors",
    "agent": "dialogue, action tags, language model",
    "speech": "recogniser, synthesiser",
    "instructions": "what is said, and what is meant",
    "embodiment": "an agent in a body at a table",
    "tuning": "hyperparameter search",
    "viewing": "solvers and trials in a browser",
    "presentation": "tables and figures",
    "reporting": "report.html, claims",
    "leaderboard": "committed lines, ranks",
    "site": "pages that open from disk",
    "solvers": "which network a solver takes",
    "configuration": "conf/ composed and checked",
    "Python API": "load_solver, evaluate",
    "stages": "one thin file a stage, their graph",
    "zoo": "many arms, where a seed pays",
    "commands": "the command line",
}
GROUPS = {  # modules of `pipeline` beside its packages; all others are the foundation
    "config": "configuration",
    "conversion": "configuration",
    "settings": "configuration",
    "loading": "Python API",
    "evaluating": "Python API",
    "solvers": "solvers",
    "__main__": "commands",
}
COLOURS = {"robots": "#d7ecdf", "baselines": "#d6e4f5"}
OTHER, EDGE, INK, SOFT = "#f4efe6", "#9aa4ad", "#1f2a33", "#5b6670"
WIDTH, HEIGHT, GAP_X, GAP_Y, MARGIN = 236, 50, 20, 40, 24  # pixels
GAP = 4  # pixels, width of the gap that a line passes a row in
SWEEPS = 12  # of ordering boxes by where their neighbours lie
Edges = Mapping[str, set[str]]


def imports() -> dict[str, set[str]]:
    """Return which boxes each box imports, those for types alone left out."""
    graph = grimp.build_graph(*PACKAGES, exclude_type_checking_imports=True, cache_dir=None)
    found: dict[str, set[str]] = {}
    folders = {module.split(".")[1] for module in graph.modules if module.count(".") > 1}
    for module in graph.modules - {"pipeline"}:
        box = _box(module, folders)
        named = {_box(other, folders) for other in graph.find_modules_directly_imported_by(module)}
        found.setdefault(box, set()).update(named - {box})
    return found


def _box(module: str, folders: set[str]) -> str:
    package, _, rest = module.partition(".")
    if package != "pipeline":
        return package
    name = rest.partition(".")[0]
    return name if name in folders else GROUPS.get(name, "foundation")


def reduced(edges: Edges) -> dict[str, set[str]]:
    """Return the edges that do not follow from others (transitive reduction)."""
    below = {box: _below(box, edges) for box in edges}
    return {
        box: {to for to in named if not any(to in below[other] for other in named - {to})}
        for box, named in edges.items()
    }


def _below(box: str, edges: Edges) -> set[str]:
    seen: set[str] = set()
    waiting = list(edges[box])
    while waiting:
        other = waiting.pop()
        if other not in seen:
            seen.add(other)
            waiting += edges[other]
    return seen


def rows(edges: Edges) -> list[list[str]]:
    """Return the boxes by height, lowest first: each lies above all that it imports."""
    height: dict[str, int] = {}

    def level(box: str) -> int:
        if box not in height:
            height[box] = 1 + max((level(other) for other in edges[box]), default=-1)
        return height[box]

    found: list[list[str]] = [[] for _ in range(max(map(level, edges)) + 1)]
    for box in sorted(edges):
        found[level(box)].append(box)
    return found


def routes(edges: Edges) -> dict[tuple[str, str], list[str]]:
    """Return the way of each line: a box, a gap in each row that it passes, and another box."""
    levels, found = rows(edges), {}
    height = {box: k for k, row in enumerate(levels) for box in row}
    for box, named in sorted(reduced(edges).items()):
        for other in sorted(named):
            passed = range(height[box] - 1, height[other], -1)
            gaps = [f"{box}>{other}@{level}" for level in passed]
            found[box, other] = [box, *gaps, other]
    return found


def places(edges: Edges) -> dict[str, tuple[float, float]]:
    """Return the middle of each box and gap, neighbours near each other."""
    levels, near = rows(edges), defaultdict[str, set[str]](set)
    for way in routes(edges).values():
        for above, below in pairwise(way):
            near[above].add(below)
            near[below].add(above)
        for gap in way[1:-1]:
            levels[int(gap.rpartition("@")[2])].append(gap)
    x: dict[str, float] = {}

    def spread(row: list[str]) -> None:
        widths = [_width(name) + GAP_X for name in row]
        left = -sum(widths) / 2
        for name, width in zip(row, widths, strict=True):
            x[name] = left + width / 2
            left += width

    for row in levels:
        spread(row)
    for sweep in range(SWEEPS):
        for row in levels if sweep % 2 else levels[::-1]:
            row.sort(key=lambda name: (round(fmean(x[b] for b in near[name]), 3), name))
            spread(row)
    left, top = min(x[name] - _width(name) / 2 for name in x), len(levels) - 1
    return {
        name: (MARGIN + x[name] - left, MARGIN + HEIGHT / 2 + (top - k) * (HEIGHT + GAP_Y))
        for k, row in enumerate(levels)
        for name in row
    }


def picture() -> str:
    """Return the picture as SVG."""
    edges = imports()
    place = places(edges)
    boxes = sorted(set(place) & set(edges))
    width = max(place[name][0] + _width(name) / 2 for name in place) + MARGIN
    height = max(place[box][1] for box in boxes) + HEIGHT / 2 + MARGIN
    size = f"{width:.0f} {height:.0f}"
    return "\n".join(
        [
            "<!-- made by `python docs/architecture.py` from the imports; do not edit -->",
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size}" '
            'font-family="Helvetica, Arial, sans-serif">',
            '<rect width="100%" height="100%" rx="8" fill="#ffffff"/>',
            *(_line([place[name] for name in way]) for _, way in sorted(routes(edges).items())),
            *(_drawn(box, *place[box]) for box in boxes),
            "</svg>",
            "",
        ]
    )


def _width(name: str) -> int:
    """Pixels of a box, or of the gap that a line passes a row in."""
    return GAP if "@" in name else WIDTH


def _line(way: list[tuple[float, float]]) -> str:
    """A line that passes each gap upright and bends between two rows."""
    half = HEIGHT / 2
    path = f"M{way[0][0]:.0f} {way[0][1] + half:.0f}"
    for (x1, y1), (x2, y2) in pairwise(way):
        top, bottom = y1 + half, y2 - half
        middle = (top + bottom) / 2
        path += f" L{x1:.0f} {top:.0f} C{x1:.0f} {middle:.0f} {x2:.0f} {middle:.0f}"
        path += f" {x2:.0f} {bottom:.0f}"
    return f'<path d="{path}" fill="none" stroke="{EDGE}" stroke-width="1.3"/>'


def _drawn(box: str, middle: float, centre: float) -> str:
    x, y, colour = middle - WIDTH / 2, centre - HEIGHT / 2, COLOURS.get(box, OTHER)
    return (
        f'<g text-anchor="middle"><rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" '
        f'rx="6" fill="{colour}" stroke="{SOFT}" stroke-width="0.8"/>'
        f'<text x="{middle:.0f}" y="{y + 20:.0f}" font-size="15" font-weight="bold" fill="{INK}">'
        f"{escape(box)}</text>"
        f'<text x="{middle:.0f}" y="{y + 38:.0f}" font-size="11" fill="{SOFT}">'
        f"{escape(BOXES[box])}</text></g>"
    )


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
    print(PICTURE)
