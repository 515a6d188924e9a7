"""The site of a run, from the command line, in a browser: sorted, filtered, dark, on a phone."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pipeline.__main__ import main
from tests.site_pages import parsed
from tests.unit.reporting.synthetic import write_results

sync_api = pytest.importorskip("playwright.sync_api")
CHROMIUM = shutil.which("chromium")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium: apt-get install chromium"),
]
PATIENCE_MS = 180_000.0  # a shared machine may take its time
DESKTOP, PHONE = {"width": 1400, "height": 900}, {"width": 390, "height": 844}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("made")
    write_results(made / "quick")
    write_results(made / "other", poses=150)
    call = ["site", f"results_dir={made / 'quick'}", f"compare={made / 'other'}"]
    assert main(call) == 0
    (made / "letter.txt").write_text("dear")
    assert main([*call, f"site.dir={made}"]) == 2  # it holds other files
    return made / "quick" / "site"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with sync_api.sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@pytest.fixture(autouse=True)
def pages_are_closed(browser: Any) -> Iterator[None]:
    yield
    for context in browser.contexts:
        context.close()


def opened(browser: Any, path: Path, size: dict[str, int] = DESKTOP, scheme: str = "light") -> Any:
    page = browser.new_context(viewport=size, color_scheme=scheme).new_page()
    page.set_default_timeout(PATIENCE_MS)
    page.faults = []
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("requestfailed", lambda request: page.faults.append(request.url))
    page.goto(path.as_uri())
    return page


def column(page: Any, table: str, title: str) -> tuple[Any, list[str]]:
    """The heading of a column, and the cells of the rows that can be seen."""
    found = page.locator(f"table[data-name={table}]")
    heads = found.locator("thead tr").last.locator("th")
    titles = [text.strip() for text in heads.all_inner_texts()]
    number = titles.index(title)
    cells = found.locator(f"tbody tr:not([hidden]) td:nth-child({number + 1})")
    return heads.nth(number), [text.strip() for text in cells.all_inner_texts()]


def test_every_link_of_every_page_leads_somewhere(site: Path) -> None:
    pages = {path.name: parsed(path) for path in site.glob("*.html")}
    assert {"index.html", "paper.html", "studies.html", "leaderboard.html"} <= set(pages)
    assert {"solvers.html", "suites.html", "protocols.html", "compare.html"} <= set(pages)
    for name, page in pages.items():
        assert page.unbalanced == [], name
        assert len(set(page.ids)) == len(page.ids), name
        for link in page.links:
            path, _, anchor = link.partition("#")
            target = pages.get(path or name)
            assert link == "data:," or (site / (path or name)).is_file(), f"{name}: {link}"
            assert not anchor or (target and anchor in target.ids), f"{name}: {link}"
    assert len(pages["paper.html"].tables["every_claim"]) == 43
    assert len(pages["paper.html"].tables["every_number"]) == 160


def test_a_column_sorts_by_click_and_by_keyboard(site: Path, browser: Any) -> None:
    page = opened(browser, site / "solvers.html")
    head, before = column(page, "time", "mean")
    assert head.get_attribute("aria-sort") == "none"
    head.click()
    assert head.get_attribute("aria-sort") == "ascending"
    values = [float(text.replace(",", "")) for text in column(page, "time", "mean")[1]]
    assert values == sorted(values)
    assert len(values) == len(before)
    head.locator("button").focus()
    page.keyboard.press("Enter")
    assert head.get_attribute("aria-sort") == "descending"
    values = [float(text.replace(",", "")) for text in column(page, "time", "mean")[1]]
    assert values == sorted(values, reverse=True)
    other, _ = column(page, "time", "Robot")
    assert other.get_attribute("aria-sort") == "none"
    assert page.faults == []


def test_rows_are_filtered_by_words_and_by_menu_and_counted(site: Path, browser: Any) -> None:
    page = opened(browser, site / "solvers.html")
    tools = page.locator("form[data-for=time]")
    every = len(column(page, "time", "Robot")[1])
    tools.locator("select").first.select_option("Panda")
    robots = column(page, "time", "Robot")[1]
    assert set(robots) == {"Panda"}
    assert tools.locator("output").inner_text() == f"{len(robots)} of {every} rows"
    tools.locator("input").fill("placo")
    assert set(column(page, "time", "Solver")[1]) == {"placo"}
    tools.locator("input").fill("no such")
    assert column(page, "time", "Solver")[1] == []
    tools.locator("input").fill("")
    tools.locator("select").first.select_option("")
    assert len(column(page, "time", "Robot")[1]) == every


def test_the_theme_follows_the_system_until_the_button_says_otherwise(
    site: Path, browser: Any
) -> None:
    ground = "getComputedStyle(document.body).backgroundColor"
    light = opened(browser, site / "index.html").evaluate(ground)
    page = opened(browser, site / "index.html", scheme="dark")
    dark = page.evaluate(ground)
    assert light == "rgb(255, 255, 255)" != dark
    page.locator("#theme").click()
    assert page.evaluate(ground) == light
    page.goto((site / "paper.html").as_uri())
    assert page.evaluate(ground) == light
    page.locator("#theme").click()
    assert page.evaluate(ground) == dark


def test_no_page_is_wider_than_a_phone_and_wide_tables_scroll_inside(
    site: Path, browser: Any
) -> None:
    for path in sorted(site.glob("*.html")):
        for size in (PHONE, DESKTOP):
            page = opened(browser, path, size)
            wide = page.evaluate("document.documentElement.scrollWidth")
            assert wide == size["width"], path.name
            assert page.faults == [], path.name
            if folder := os.environ.get("PICTURES"):
                name = f"site_{path.stem}_{size['width']}.png"
                page.screenshot(path=Path(folder) / name, full_page=True)
            page.context.close()
    page = opened(browser, site / "solvers.html", PHONE)
    box = "document.querySelector('#precision .box')"
    assert page.evaluate(f"{box}.scrollWidth > {box}.clientWidth")
    page.evaluate(f"{box}.scrollLeft = 500")
    assert page.evaluate(f"{box}.scrollLeft") > 100


def test_a_number_has_an_address_that_opens_what_is_folded(site: Path, browser: Any) -> None:
    page = opened(browser, site / "solvers.html")
    cell = page.locator("table[data-name=time] td[id]").nth(3)
    name = cell.get_attribute("id")
    cell.click()
    assert page.evaluate("decodeURIComponent(location.hash)") == f"#{name}"
    folded = parsed(site / "studies.html")
    inside = next(each for each in folded.ids if each.startswith("study_published_robots."))
    page.goto(f"{(site / 'studies.html').as_uri()}#{inside}")
    assert page.locator(f'[id="{inside}"]').is_visible()


def test_marks_of_a_figure_say_what_they_are(site: Path, browser: Any) -> None:
    page = opened(browser, site / "solvers.html")
    charts = page.locator(".chart")
    assert [charts.nth(i).is_visible() for i in range(charts.count())] == [True, False]
    page.locator("form.show select").select_option(label="Panda")
    assert [charts.nth(i).is_visible() for i in range(charts.count())] == [False, True]
    page.locator(".chart:not([hidden]) .mark circle").first.hover()
    assert "µs a call" in page.locator("#tip").inner_text()


def test_without_javascript_all_is_there(site: Path, browser: Any) -> None:
    page = browser.new_context(java_script_enabled=False).new_page()
    page.set_default_timeout(PATIENCE_MS)
    page.goto((site / "solvers.html").as_uri())
    assert page.locator("table[data-name=time] tbody tr").count() > 10
    assert page.locator(".chart").nth(1).is_visible()
    assert not page.locator("form.tools").first.is_visible()
