"""Studies of grasps: every combination on the same trials, one setting at a time changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pipeline.config import compose, group_choices
from pipeline.data.files import read_yaml
from pipeline.data.rows import RowCheckpoint
from pipeline.errors import ConfigError
from pipeline.grasping import series as module
from pipeline.grasping.ablation import HARDWARE, KEY, PHYSICS, Study, changed, variants
from pipeline.grasping.series import Series
from pipeline.grasping.trial import required_scene
from pipeline.locations import CONF_DIR

STUDIES = [
    name
    for name in group_choices("experiment")
    if "ablation" in (read_yaml(CONF_DIR / "experiment" / f"{name}.yaml").get("grasp") or {})
]
GRASP = compose(["profile=smoke"]).grasp


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_of_the_configuration_can_be_made(name: str) -> None:
    config = compose([f"experiment={name}", "profile=smoke"]).grasp
    settings = list(variants(config))
    assert len(settings) > 1
    for values in settings:
        varied = changed(config, values)
        assert varied.timing.rate == varied.physics.rate
        for axis, value in values.items():
            holder = varied.physics if axis in PHYSICS else varied
            holder = varied.hardware if axis in HARDWARE else holder
            assert getattr(holder, axis) == value


def test_without_a_study_there_are_no_variants() -> None:
    assert list(variants(GRASP)) == []


def test_the_hand_is_as_strong_and_rough_as_asked() -> None:
    hand = GRASP.scenes["nico"].hand
    scene = required_scene(replace(GRASP, tension_scale=0.5, friction_scale=2.0), "nico")
    assert scene.hand.tension == 0.5 * hand.tension
    assert scene.hand.friction == 2.0 * hand.friction
    assert scene.grip == GRASP.scenes["nico"].grip


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("grasp.ablation={study: x, vary: {colour: [1]}}", "grasp.ablation.vary"),
        ("grasp.ablation={study: x, vary: {rate: []}}", "at least one value"),
        ("grasp.tension_scale=-1", "grasp.tension_scale"),
    ],
)
def test_what_cannot_be_studied_is_refused(override: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        compose(["profile=smoke", override])


def test_a_study_runs_each_trial_of_each_variant_once_and_goes_on(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    ran: list[tuple[str, int]] = []

    def trial(config: Any, robot: Any, solver: Any, number: int, *rest: Any) -> dict[str, Any]:
        ran.append((solver, number))
        return {"trial": number, "class": "Success"}

    monkeypatch.setattr(module, "run_trial", trial)
    config = replace(compose(["experiment=grasp_solver", "profile=smoke"]).grasp, trials=2)
    series = Series(config, None, "given", None, 0)  # type: ignore[arg-type]
    study = Study(series, lambda name: name)  # type: ignore[arg-type,return-value]
    path = tmp_path / "rows.jsonl"
    kept = RowCheckpoint(path, KEY)
    kept.put({"variant": 1, "trial": 0, "study": "solver", "axes": "solver", "class": "Slipped"})
    rows = study.run(RowCheckpoint(path, KEY), lambda row: None)
    solvers = ["cycleik", "cycleik_refined", "placo", "lm"]
    assert ran == [(s, t) for s in solvers for t in range(2) if (s, t) != (solvers[1], 0)]
    assert study.trials == len(rows) == 8
    assert list(rows["class"]).count("Slipped") == 1
