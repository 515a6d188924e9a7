"""Rank of Table I among drawn configurations, and the best of each number of layers."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pipeline.config import chosen, compose
from pipeline.reporting.results import read_results
from pipeline.reporting.topics.tuning import studies


def line(folder: Path, **columns: list[object]) -> dict[str, object]:
    place = folder / "tune" / "nico"
    place.mkdir(parents=True)
    trials = pd.DataFrame({"position_error_mm": 1.0, "rotation_error_deg": 1.0, **columns})
    trials.to_csv(place / "trials.csv", index=False)
    (place / "best.yaml").write_text("of: {model: paper}\n", encoding="utf-8")
    table = studies(read_results(folder))
    return dict(zip([column.name for column in table.columns], table.rows[0], strict=True))


def test_the_rank_of_the_start_counts_complete_trials(tmp_path: Path) -> None:
    found = line(
        tmp_path,
        number=[0, 1, 2, 3],
        state=["COMPLETE", "COMPLETE", "FAIL", "COMPLETE"],
        objective=[0.3, 0.2, None, 0.4],
        drawn=[False, True, True, True],
        hidden_layers=[6, 5, 7, 5],
    )
    assert (found["first_rank"], found["first"]) == (2, 0.3)
    assert found["by_layers"] == "5: 0.2 of 2, 6: 0.3 of 1"


def test_a_search_without_a_start_or_without_layers_has_neither(tmp_path: Path) -> None:
    found = line(tmp_path, number=[0], state=["COMPLETE"], objective=[0.3], drawn=[True])
    assert found["first_rank"] is None
    assert found["by_layers"] is None


def test_the_experiment_draws_forty_beside_table_one_at_equal_poses() -> None:
    for profile in ("quick", "smoke", "paper"):
        run = ["experiment=search", f"profile={profile}", "robot=nico"]
        config = compose(run)
        assert chosen(run)["tune"] == "paper"
        assert (config.model.name, config.tune.sampler) == ("paper", "random")
        assert (config.tune.trials, config.tune.epochs, config.tune.poses) == (41, 1, 200_000)
        assert config.tune.start[0]["hidden"] == [2270, 560, 1100, 1990, 2590, 870]
        assert config.tune.pruner.kind == "none", "every trial sees all poses"
