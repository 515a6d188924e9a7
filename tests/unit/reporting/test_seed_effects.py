"""What a neural seed gives a solver: paired on the same poses, its own time apart."""

import pandas as pd
import pytest
from synthetic import PUBLISHED, raw_rows, report_config, write_results

from pipeline.data.tables import read_metadata, read_table, write_table
from pipeline.presentation.published import read_published
from pipeline.reporting.report import load, make_table
from pipeline.reporting.topics.seeding import adjusted, seed_effects


def pair(poses=200):
    home = raw_rows("panda", "placo", poses).assign(iterations=20, time_per_pose_us=300.0)
    seeded = home.assign(
        seeded_by="cycleik", iterations=4, time_per_pose_us=70.0, seed_time_us=40.0, found=True
    )
    seeded = seeded.assign(answered=True, position_error_mm=0.01, rotation_error_deg=0.01)
    return home, seeded


def test_effects_by_hand():
    home, seeded = pair()
    home.loc[:19, ["position_error_mm", "rotation_error_deg"]] = 50.0
    home.loc[20:, ["position_error_mm", "rotation_error_deg"]] = 0.01
    home["answered"] = True
    (line,) = seed_effects(home, seeded, report_config()).to_dict("records")
    assert (line["robot"], line["solver"], line["seeded_by"]) == ("panda", "placo", "cycleik")
    assert line["success_home"] == pytest.approx(0.9)
    assert line["success_seeded"] == 1.0
    assert line["success_difference"] == pytest.approx(0.1)
    assert line["success_p"] == pytest.approx(2 / 2**20)
    assert (line["iterations_home"], line["iterations_seeded"]) == (20, 4)
    assert line["time_difference_us"] == pytest.approx(-230.0)
    assert line["seed_time_us"] == pytest.approx(40.0)


def test_only_the_same_poses_are_paired_and_batch_sizes_stay_apart():
    home, seeded = pair()
    large = seeded.head(100).assign(batch_size=100, time_per_pose_us=1.0)
    seeded = pd.concat([seeded.head(150), large])
    home = pd.concat([home, home.head(100).assign(batch_size=100)])
    effects = seed_effects(home, seeded, report_config()).set_index("batch_size")
    assert effects.poses.to_dict() == {1: 150, 100: 100}
    assert effects.success_p.notna().to_dict() == {1: True, 100: False}
    other = seeded.assign(target_x_m=seeded.target_x_m + 0.1)
    assert seed_effects(home, other, report_config()).empty
    assert adjusted(pd.DataFrame()).empty


@pytest.fixture
def results(tmp_path):
    root = write_results(tmp_path / "quick", ("panda",), ("cycleik", "lm", "placo"), 60)
    for solver in ("lm", "placo"):
        path = root / "evaluate" / "panda" / f"{solver}.parquet"
        rows = read_table(path).assign(seeded_by="cycleik", seed_time_us=9.0)
        write_table(path.parent / "seeded_by_cycleik" / path.name, rows, read_metadata(path))
    return root


def test_the_report_pairs_what_lies_in_the_folder_of_the_seeds(results):
    table = make_table(results, PUBLISHED, report_config(resamples=5), "neural_seeds")
    assert [row[:4] for row in table.rows] == [
        ["Panda", "LM, compiled", "CycleIK", 1],
        ["Panda", "LM, compiled", "CycleIK", 100],
        ["Panda", "LM, compiled", "CycleIK", 1000],
        ["Panda", "placo", "CycleIK", 1],
    ]


def test_rows_with_another_budget_are_not_paired_but_told(results):
    path = results / "evaluate" / "panda" / "seeded_by_cycleik" / "lm.parquet"
    facts = {**read_metadata(path), "solver_budget": {"time_s": 9.0, "iterations": None}}
    write_table(path, read_table(path), facts)
    published = read_published(PUBLISHED)
    data = load(results, published, report_config(resamples=5))
    assert set(data.effects.solver) == {"placo"}
    assert any("another budget" in note for note in data.results.notes)
