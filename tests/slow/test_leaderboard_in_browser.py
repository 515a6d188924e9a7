"""The leaderboard of the committed lines in a browser: sorted by a click, filtered, complete."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.leaderboard.boards import read_boards
from pipeline.site.boards import leaderboard_page
from pipeline.site.build import Site, write_site
from pipeline.site.files import claim
from tests.pages import ROOT
from tests.unit.reporting.synthetic import report_config

pytest.importorskip("websockets")
browser_module = pytest.importorskip("tests.browser")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(browser_module.PROGRAM is None, reason="no chromium"),
]
TABLE = "document.querySelector('table[data-name=leaderboard_lines]')"
TOOLS = "document.querySelector('form[data-for=leaderboard_lines]')"
HEADS = f"[...{TABLE}.tHead.rows[{TABLE}.tHead.rows.length - 1].cells]"


@pytest.fixture(scope="module")
def lines() -> pd.DataFrame:
    return read_boards(ROOT / "results" / "leaderboard")


@pytest.fixture(scope="module")
def page(lines: pd.DataFrame, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    folder = tmp_path_factory.mktemp("site")
    claim(folder)
    made = leaderboard_page(lines, report_config())
    write_site(Site("Boards", "quick", [made], []), folder)
    address = (folder / "leaderboard.html").as_uri()
    with browser_module.browse(address, 1500, 900) as opened:
        opened.wait_for("Every line", "rank")
        yield opened


def place(page: Any, title: str) -> int:
    return int(page.evaluate(f"{HEADS}.findIndex(each => each.innerText.trim() === '{title}')"))


def seen(page: Any, title: str) -> list[str]:
    """Cells of a column in the rows that are not filtered out."""
    rows = f"[...{TABLE}.tBodies[0].rows].filter(row => !row.hidden)"
    texts = page.evaluate(f"{rows}.map(row => row.cells[{place(page, title)}].innerText.trim())")
    return list(texts)


def select(page: Any, value: str) -> None:
    """Choose in the menu that has a value, or everything again with ""."""
    menus = f"[...{TOOLS}.querySelectorAll('select')]"
    menu = f"{menus}.find(each => [...each.options].some(o => o.value === '{value}'))"
    page.evaluate(
        f"(menu => {{ menu.value = '{value}'; "
        f"menu.dispatchEvent(new Event('change', {{bubbles: true}})); "
        f"menu.dispatchEvent(new Event('input', {{bubbles: true}})); }})({menu})"
    )


def test_every_committed_line_is_there(page: Any, lines: pd.DataFrame) -> None:
    assert len(seen(page, "Robot")) == len(lines) >= 360


def test_a_click_on_a_heading_sorts_by_numbers(page: Any) -> None:
    place_of = place(page, "geometric mean")
    page.evaluate(f"{HEADS}[{place_of}].querySelector('button').click()")
    times = [float(text.replace(",", "")) for text in seen(page, "geometric mean") if text != "–"]
    assert len(times) > 300 and times == sorted(times)
    page.evaluate(f"{HEADS}[{place_of}].querySelector('button').click()")
    times = [float(text.replace(",", "")) for text in seen(page, "geometric mean") if text != "–"]
    assert times == sorted(times, reverse=True)


def test_a_menu_and_words_filter_the_lines(page: Any, lines: pd.DataFrame) -> None:
    select(page, "Panda")
    assert set(seen(page, "Robot")) == {"Panda"}
    assert len(seen(page, "Robot")) == (lines.robot == "panda").sum()
    page.evaluate(
        f"(box => {{ box.value = 'placo'; "
        f"box.dispatchEvent(new Event('input', {{bubbles: true}})); }})"
        f"({TOOLS}.querySelector('input'))"
    )
    assert set(seen(page, "Solver")) == {"placo"}
    assert len(seen(page, "Solver")) == ((lines.robot == "panda") & (lines.solver == "placo")).sum()
    assert page.picture().size == (1500, 900)


def test_robots_of_packages_say_where_they_are_from(lines: pd.DataFrame) -> None:
    built_in = {path.parent.name for path in Path(ROOT / "robots").glob("*/weights")}
    for line in lines.itertuples():
        assert bool(line.robot_source) == (line.robot not in built_in), line.robot
