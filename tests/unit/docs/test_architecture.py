"""The picture of the architecture is that of the imports."""

from __future__ import annotations

import re
import runpy
from typing import Any

import pytest

from tests.pages import ROOT

SCRIPT = ROOT / "docs" / "architecture.py"


@pytest.fixture(scope="module")
def drawn() -> dict[str, Any]:
    return runpy.run_path(str(SCRIPT))


def test_the_picture_on_disk_is_that_of_the_imports(drawn: dict[str, Any]) -> None:
    text = SCRIPT.with_suffix(".svg").read_text(encoding="utf-8")
    assert text == drawn["picture"](), "run: python docs/architecture.py"


def test_every_package_is_a_box_and_each_lies_above_what_it_imports(drawn: dict[str, Any]) -> None:
    edges = drawn["imports"]()
    assert set(edges) == set(drawn["BOXES"])
    packages = {path.parent.name for path in (ROOT / "pipeline").glob("*/__init__.py")}
    assert packages <= set(edges)
    place = drawn["places"](edges)
    for box, named in edges.items():
        assert all(place[box][1] < place[other][1] for other in named), box


def test_only_lines_that_follow_from_others_are_left_out(drawn: dict[str, Any]) -> None:
    edges = {"a": {"b", "c", "d"}, "b": {"c"}, "c": set(), "d": set()}
    assert drawn["reduced"](edges) == {"a": {"b", "d"}, "b": {"c"}, "c": set(), "d": set()}
    assert drawn["rows"](edges) == [["c", "d"], ["b"], ["a"]]


def test_a_line_passes_a_gap_in_each_row_between(drawn: dict[str, Any]) -> None:
    edges = {"a": {"b", "d"}, "b": {"c"}, "c": set(), "d": set()}
    assert drawn["routes"](edges)["a", "d"] == ["a", "a>d@1", "d"]


def test_every_box_and_every_line_lies_inside_the_picture(drawn: dict[str, Any]) -> None:
    text = drawn["picture"]()
    width, height = map(float, re.findall(r'viewBox="0 0 (\d+) (\d+)"', text)[0])
    ways = [re.findall(r"(-?\d+) (-?\d+)", path) for path in re.findall(r' d="([^"]+)"', text)]
    points = [(float(x), float(y)) for way in ways for x, y in way]
    assert len(points) > 100
    assert all(0 < x < width and 0 < y < height for x, y in points)
