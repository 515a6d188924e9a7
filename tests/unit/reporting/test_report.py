"""The whole report from a synthetic results folder: complete, self-contained, the same twice."""

import importlib
import json
import re
from pkgutil import iter_modules
from threading import Thread

import pytest
from synthetic import PUBLISHED, raw_rows, report_config, write_results

from pipeline.artifacts import exclusive
from pipeline.data.tables import write_table
from pipeline.errors import MissingArtifactError
from pipeline.presentation.published import read_published
from pipeline.presentation.style import save, styled
from pipeline.reporting import report, topics
from pipeline.reporting.chapters import TOPICS
from pipeline.reporting.report import make_report, make_table
from pipeline.reporting.results import read_results
from pipeline.reporting.topics.training import training_curves

CONFIG = report_config(dpi=50, resamples=20)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    root = write_results(
        tmp_path_factory.mktemp("run") / "quick", ("panda",), ("cycleik", "lm"), 60
    )
    still = root / "grasp" / "panda" / "still_01.png"
    still.write_bytes(b"\x89PNG not really")
    return root, make_report(root, PUBLISHED, CONFIG)


def test_every_table_and_figure_is_there(made):
    _, paths = made
    tables = {path.stem for path in paths.tables.iterdir()}
    assert {"table1_hyperparameters", "table2_numerical_comparison", "precision"} <= tables
    assert {"table3_neural_comparison", "time", "planner", "figure5_grasping"} <= tables
    for name in ("success_against_tolerance", "training_curves", "grasp_outcomes", "win_matrix"):
        assert (paths.figures / f"{name}.png").stat().st_size > 1000
        assert (paths.figures / f"{name}.pdf").read_bytes().startswith(b"%PDF")


def test_every_topic_stands_in_one_chapter():
    names = [f"{topics.__name__}.{module.name}" for module in iter_modules(topics.__path__)]
    modules = [importlib.import_module(name) for name in names]
    assert len(modules) > 10
    assert sorted(map(id, TOPICS)) == sorted(id(module.TOPIC) for module in modules)


def test_names_of_tables_columns_and_figures_are_their_own(made):
    data = report.load(made[0], read_published(PUBLISHED), CONFIG)
    every = [make(data) for topic in TOPICS for make in topic.tables]
    plots = [plot.name for topic in TOPICS for plot in topic.plots]
    for names in (
        [table.name for table in every],
        plots,
        *([column.name for column in table.columns] for table in every),
    ):
        assert len(names) == len(set(names)), names


def test_the_page_needs_no_other_file_to_be_seen(made):
    page = made[1].html.read_text(encoding="utf-8")
    sources = re.findall(r'src="([^"]{0,40})', page)
    assert len(sources) >= 9
    assert all(source.startswith("data:") for source in sources)
    assert not re.search(r"<(script|link)\b", page)
    assert "Table II" in page
    assert "still 01" in page


def test_links_lead_to_files(made):
    root, paths = made
    links = re.findall(r'href="([^"#][^"]*)"', paths.html.read_text(encoding="utf-8"))
    assert links
    assert [link for link in links if not (root / link).exists()] == []


def test_metrics_are_numbers_by_stage_robot_and_solver(made):
    metrics = json.loads(made[1].metrics.read_text())
    assert 0 <= metrics["evaluate"]["panda"]["lm"]["success_strict"] <= 1
    assert metrics["grasp"]["panda"] == {"success": 0.85, "trials": 20}
    assert metrics["plan"]["panda"]["cycleik"]["plan_time_ms_median"] > 0


def test_the_same_rows_give_the_same_bytes(made, tmp_path):
    root, paths = made
    data = report.load(root, read_published(PUBLISHED), CONFIG)
    for table in report.make_tables(data):
        for path in table.write(tmp_path):
            assert path.read_bytes() == (paths.tables / path.name).read_bytes(), path.name
    with styled():
        figure = training_curves(data.results.train)
        for path in save(figure, tmp_path, "training_curves", CONFIG.dpi):
            assert path.read_bytes() == (paths.figures / path.name).read_bytes(), path.name


def test_stages_that_left_nothing_are_named(tmp_path):
    (tmp_path / "quick" / "dataset" / "panda").mkdir(parents=True)
    paths = make_report(tmp_path / "quick", PUBLISHED, CONFIG)
    page = paths.html.read_text(encoding="utf-8")
    for stage in ("tune", "train", "evaluate", "plan", "grasp"):
        assert f"The {stage} stage has left nothing" in page
    assert json.loads(paths.metrics.read_text()) == {}


def test_a_second_report_of_a_folder_waits_for_the_first(tmp_path):
    folder = tmp_path / "quick"
    (folder / "dataset" / "panda").mkdir(parents=True)
    second = Thread(target=make_report, args=(folder, PUBLISHED, CONFIG), daemon=True)
    with exclusive(folder / "report.html"):
        second.start()
        second.join(0.5)
        assert second.is_alive()
        assert not (folder / "report.html").exists()
    second.join(60.0)
    assert (folder / "report.html").exists()


def test_a_folder_that_no_stage_wrote_to_is_refused_and_not_made(tmp_path):
    with pytest.raises(MissingArtifactError, match=r"typo.*check results_dir.*dataset"):
        make_report(tmp_path / "typo", PUBLISHED, CONFIG)
    assert not list(tmp_path.iterdir())


def test_leftovers_of_a_kill_and_of_an_earlier_report_are_not_shown(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "draw_figures", lambda data, topics, folder: [])
    root = write_results(tmp_path / "quick", ("panda",), ("lm",), 20)
    (root / "evaluate" / "panda" / ".placo.123.partial.parquet").write_bytes(b"PAR1")
    (root / "plan" / "panda" / ".plans.123.partial.parquet").write_bytes(b"PAR1")
    for name in ("tables/old.csv", "tables/README.txt", "figures/old.png", "figures/old.pdf"):
        (root / name).parent.mkdir(exist_ok=True)
        (root / name).write_text("old")
    paths = make_report(root, PUBLISHED, CONFIG)
    assert "partial" not in paths.html.read_text(encoding="utf-8")
    assert not list(root.glob("*/old.*"))
    assert (paths.tables / "README.txt").exists()
    assert (paths.tables / "precision.csv").exists()


@pytest.mark.parametrize(("folder", "profile"), [("x", "smoke"), ("smoke", ""), ("x", "")])
def test_numbers_of_a_smoke_run_come_with_a_warning_wherever_they_lie(tmp_path, folder, profile):
    warned = any("mean nothing" in note for note in read_results(tmp_path / folder, profile).notes)
    assert warned == ("smoke" in (folder, profile))


def test_the_rows_say_that_they_are_of_a_smoke_run(tmp_path):
    write_table(tmp_path / "evaluate/nico/lm.parquet", raw_rows("nico", "lm"), {"profile": "smoke"})
    assert "mean nothing" in read_results(tmp_path, "quick").notes[0]


def test_damaged_files_are_named_and_the_rest_is_shown(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "draw_figures", lambda data, topics, folder: [])
    root = write_results(tmp_path / "quick", ("panda",), ("cycleik", "lm"), 20)
    damaged = root / "evaluate" / "panda" / "lm.parquet"
    damaged.write_bytes(damaged.read_bytes()[:200])
    (root / "train" / "panda" / "compact" / "curve.csv").unlink()
    (root / "dataset" / "panda" / "card.json").write_text("{")
    table = make_table(root, PUBLISHED, CONFIG, "precision")
    assert [row[1] for row in table.rows] == ["CycleIK"]
    page = make_report(root, PUBLISHED, CONFIG).html.read_text(encoding="utf-8")
    assert "lm.parquet could not be read" in page
    assert "There is no quick/train/panda/compact/curve.csv" in page
    assert "card.json could not be read" in page


def test_one_table_by_name(made):
    assert make_table(made[0], PUBLISHED, CONFIG, "time").rows
    with pytest.raises(ValueError, match="table2_numerical_comparison"):
        make_table(made[0], PUBLISHED, CONFIG, "tabel2")
