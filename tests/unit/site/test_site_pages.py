"""Pages of the site: parsed as a browser does, complete against their sources, every link there."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote

import pandas as pd
import pytest
from markupsafe import Markup

from pipeline.leaderboard.boards import put, read_boards
from pipeline.presentation.columns import number, share, text
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import Table
from pipeline.reporting.summary import summarise
from pipeline.site.boards import leaderboard_page
from pipeline.site.build import Site, inline, sheets_of, write_site
from pipeline.site.charts import spread
from pipeline.site.content import protocol_table, studies_page, suite_table, with_linked_files
from pipeline.site.figures import error_and_time
from pipeline.site.files import SiteError, claim, copied
from pipeline.site.parts import Page, Prose, Section, Sheet
from pipeline.site.sheet import row_keys, view_of
from pipeline.site.studies import MOST, described
from tests.leaderboard_lines import LINE
from tests.pages import ROOT
from tests.site_pages import Parsed, parsed
from tests.unit.reporting.synthetic import raw_rows, report_config

ODD = """<script>alert("1")</script> & 'odd' "name" """
STUDIES = ROOT / "results" / "studies"


def odd_table() -> Table:
    lines = [
        {"robot": ODD, "solver": "lm", "error": -0.5, "rate": 0.25},
        {"robot": ODD, "solver": "placo", "error": float("nan"), "rate": 1.0},
    ]
    columns = (
        text("robot", "Robot"),
        text("solver", ODD),
        number("error", "e"),
        share("rate", "%"),
    )
    table = Table.of(lines, columns, name="odd", title=ODD, caption=f"As `{ODD}` says.")
    table.origin = Origin(f"make {ODD}", date="2026-11-28", processor=ODD)
    return table


@pytest.fixture(scope="module")
def boards(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    folder = tmp_path_factory.mktemp("boards")
    for machine in ("desk", "lap"):
        for robot in ("panda", "nico"):
            for i, solver in enumerate(("lm", "placo", "cycleik", "trac_ik")):
                error = 0.01 * (4 - i)
                line = {"solver": solver, "robot": robot, "position_median_mm": error}
                put(folder, machine, {**LINE, **line, "time_geometric_us": 10.0 + i})
    return read_boards(folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, boards: pd.DataFrame) -> Path:
    made = tmp_path_factory.mktemp("site")
    claim(made)
    pages = [
        Page("index", "Start", "", [Section("first", ODD, [Sheet(odd_table(), folded=True)])]),
        leaderboard_page(boards, report_config()),
        studies_page(ROOT / "results", made),
        Page("suites", "Suites", "", [Section("a", "", [Sheet(suite_table())])], "This run"),
        Page("protocols", "Protocols", "", [Section("a", "", [Sheet(protocol_table())])]),
    ]
    write_site(Site("A site", "quick", pages, [f"By {ODD}"]), made)
    return made


@pytest.fixture(scope="module")
def pages(folder: Path) -> dict[str, Parsed]:
    return {path.name: parsed(path) for path in folder.glob("*.html")}


def test_elements_are_closed_and_ids_are_there_once(pages: dict[str, Parsed]) -> None:
    for name, page in pages.items():
        assert page.unbalanced == [], name
        assert page.open == [], name
        assert len(set(page.ids)) == len(page.ids), name


def test_every_link_leads_to_a_file_or_an_id_that_is_there(
    folder: Path, pages: dict[str, Parsed]
) -> None:
    links = [(name, link) for name, page in pages.items() for link in page.links]
    assert len(links) > 100
    for name, link in links:
        if link == "data:,":
            continue
        assert ":" not in link, f"{name} needs something from elsewhere: {link}"
        path, _, anchor = link.partition("#")
        target = path or name
        assert (folder / target).is_file(), f"{name}: {link}"
        assert not anchor or unquote(anchor) in pages[target].ids, f"{name}: {link}"


def test_a_page_says_where_it_cuts_rows(folder: Path) -> None:
    whole = pd.read_csv(STUDIES / "ladder.csv")
    said = f"the first {MOST} of {len(whole)} rows"
    assert said in (folder / "studies.html").read_text(encoding="utf-8")


def test_names_of_any_kind_are_text_and_nothing_else(pages: dict[str, Parsed]) -> None:
    page = pages["index.html"]
    assert [attrs for tag, attrs in page.tags if tag == "script"] == [
        {"src": "site.js", "defer": ""}
    ]
    assert page.tables["odd"][0] == [ODD, "lm", "−0.500", "25.0"]
    assert page.tables["odd"][1] == [ODD, "placo", "–", "100.0"]
    assert page.text.count("alert(") > 6


def test_studies_have_all_rows_and_columns_of_their_sources(
    folder: Path, pages: dict[str, Parsed]
) -> None:
    page = pages["studies.html"]
    sources = sorted(STUDIES.rglob("*.csv"))
    assert len(page.tables) == len(sources) >= 30
    for source in sources:
        group = "study" if source.parent == STUDIES else source.parent.name
        rows, shown = pd.read_csv(source), page.tables[f"{group}_{source.stem}"]
        assert len(shown) == min(len(rows), MOST), source.stem
        assert {len(line) for line in shown} == {rows.shape[1]}, source.stem
        assert len(pd.read_csv(folder / "data" / f"{group}_{source.stem}.csv")) == len(rows)
    pictures = [attrs["src"] for tag, attrs in page.tags if tag == "img"]
    assert len(pictures) == len(list(STUDIES.glob("*.png")))


def test_the_leaderboard_has_every_line_a_menu_for_each_kind_and_a_chart_a_board(
    pages: dict[str, Parsed], boards: pd.DataFrame
) -> None:
    page = pages["leaderboard.html"]
    assert len(page.tables["leaderboard_lines"]) == len(boards) == 16
    assert len(page.tables["leaderboard_overall"]) == 8
    heads = page.heads["leaderboard_lines"]
    first = dict(zip(heads, page.tables["leaderboard_lines"][0], strict=True))
    # 90 of 100, Wilson.
    assert (first["share"], first["from"], first["to"], first["rank"]) == (
        "90.0",
        "82.6",
        "94.5",
        "1",
    )
    menus = [int(attrs["data-column"]) for tag, attrs in page.tags if tag == "select"]
    assert {heads[column] for column in menus} >= {"Machine", "Robot", "Solver"}
    charts = [attrs for tag, attrs in page.tags if "chart" in attrs.get("class", "").split()]
    assert len(charts) == 8
    tips = [attrs["data-tip"] for tag, attrs in page.tags if "data-tip" in attrs]
    assert len(tips) == 2 * 16
    assert "LM, compiled: 90.0% in the end, half within 100 µs" in tips


def test_definitions_say_what_each_suite_and_protocol_is(pages: dict[str, Parsed]) -> None:
    suites = {row[0]: row[2] for row in pages["suites.html"].tables["suite_definitions"]}
    assert len(suites) == len(list((ROOT / "conf" / "suite").glob("*.yaml")))
    assert "start that the solver is given" in suites["warm"]
    protocols = pages["protocols.html"].tables["protocol_definitions"]
    assert len(protocols) == len(list((ROOT / "conf" / "protocol").glob("*.yaml")))
    assert all(len(row[2]) > 20 for row in protocols)


def test_each_table_says_what_made_it(pages: dict[str, Parsed]) -> None:
    for page in pages.values():
        for name in page.tables:
            assert f"data/{name}.csv" in page.links
    text = " ".join(pages["studies.html"].text.split())
    assert "commandpython -m benchmarks.calibration --poses 10000" in text


def test_numbers_keep_their_address_when_rows_come_and_go() -> None:
    table = odd_table()
    keys = row_keys(table, table.shown())
    table.rows.reverse()
    assert row_keys(table, table.shown()) == keys[::-1]
    assert keys[1].endswith("-placo")
    cell = view_of(table).lines[1].cells[2]
    assert (cell.id, cell.value) == (f"odd.{keys[0]}.error", "-0.5")
    table.rows.append(list(table.rows[0]))
    assert len(set(row_keys(table, table.shown()))) == 3


def test_a_second_site_leaves_nothing_of_the_first_and_a_strange_folder_alone(
    tmp_path: Path,
) -> None:
    made = tmp_path / "site"
    claim(made)
    (tmp_path / "a.png").write_bytes(b"1")
    copied(tmp_path / "a.png", made, "figures", "a.png")
    page = Page("index", "Start", "", [Section("t", "", [Sheet(odd_table())])])
    write_site(Site("A", "quick", [page, Page("more", "More", "")], []), made)
    assert (made / "data" / "odd.csv").exists()
    claim(made)  # its pages say that they are ours
    bare = Page("index", "Start", "", [Section("t", "", [Prose(Markup("<p>1</p>"))])])
    write_site(Site("A", "quick", [bare], []), made)
    there = {path.name for path in made.rglob("*") if path.is_file()}
    assert there - {".index.html.lock"} == {"index.html", "site.css", "site.js"}
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.html").write_text("dear")
    with pytest.raises(SiteError, match="holds other files"):
        claim(tmp_path / "mine")
    assert (tmp_path / "mine" / "letter.html").read_text() == "dear"


def test_pages_of_somebody_with_a_style_of_that_name_are_left_alone(tmp_path: Path) -> None:
    for name in ("site.css", "index.html", "diary.html"):
        (tmp_path / name).write_text("mine")
    with pytest.raises(SiteError, match="holds other files"):
        claim(tmp_path)
    assert {path.read_text() for path in tmp_path.iterdir()} == {"mine"}


def test_a_site_that_was_stopped_is_gone_on_with(tmp_path: Path) -> None:
    claim(tmp_path)
    (tmp_path / "figures").mkdir()
    claim(tmp_path)


def test_a_copy_is_of_what_the_file_holds(tmp_path: Path) -> None:
    source = tmp_path / "a.png"
    source.write_bytes(b"now")
    copy = tmp_path / "site" / copied(source, tmp_path / "site", "figures", "a.png")
    copy.write_bytes(b"old")  # as long, and later
    copied(source, tmp_path / "site", "figures", "a.png")
    assert copy.read_bytes() == b"now"


def test_what_has_no_place_on_a_logarithmic_axis_is_not_drawn() -> None:
    summary = summarise(raw_rows(solver="lm"), report_config())
    (chart,) = error_and_time(summary)
    assert chart.svg.count("<circle") == 1
    for name, value in (("position_error_mm_median", float("nan")), ("time_per_pose_mean_us", 0.0)):
        assert error_and_time(summary.assign(**{name: value})) == []


def test_files_that_a_table_links_to_are_copied_beside_the_pages(tmp_path: Path) -> None:
    results, made = tmp_path / "results", tmp_path / "site"
    there, gone = "grasp/nico/evidence/trial1.png", "grasp/nico/evidence/trial2.png"
    (results / there).parent.mkdir(parents=True)
    (results / there).write_bytes(b"picture")
    lines = [{"picture": there}, {"picture": gone}, {"picture": None}]
    columns = (text("picture", "picture", link=True),)
    table = Table.of(lines, columns, name="failures", title="Failures", caption="")
    claim(made)
    stale = made / copied(results / there, made, "media", "grasp/nico/earlier.png")
    shown = with_linked_files(table, results, made)
    page = Page("index", "Start", "", [Section("a", "", [Sheet(shown)])])
    write_site(Site("A site", "quick", [page], []), made)
    assert [row[0] for row in shown.rows] == [f"media/{there}", None, None]
    assert (made / "media" / there).read_bytes() == b"picture"
    assert f"media/{there}" in parsed(made / "index.html").links
    assert parsed(made / "index.html").tables["failures"] == [["trial1.png"], ["–"], ["–"]]
    assert not stale.exists()


def test_an_empty_leaderboard_says_how_to_begin() -> None:
    page = leaderboard_page(pd.DataFrame(), report_config())
    assert not sheets_of(page)
    assert "leaderboard add" in str(page.sections[0].items[0])


def test_labels_are_spread_and_stay_in_order_and_inside() -> None:
    assert spread([10.0, 10.0, 50.0], 15.0, 100.0) == [10.0, 25.0, 50.0]
    assert spread([95.0, 96.0, 97.0], 15.0, 100.0) == [70.0, 85.0, 100.0]


def test_captions_have_code_and_stress_and_no_other_markup(tmp_path: Path) -> None:
    assert inline("`a<b` and *bad*: 2 * 3 * 4") == "<code>a&lt;b</code> and <em>bad</em>: 2 * 3 * 4"
    path = tmp_path / "a.md"
    path.write_text("<!-- made -->\n**A title.** A caption.\n\n| a |\n")
    assert described(path) == ("A title", "A caption.")
    path.write_text("# Head\n\nWords\nof it.\n\n| a |\n")
    assert described(path) == ("Head", "Words of it.")
    path.write_text("| a |\n| b |\n")
    assert described(path) == ("", "")
