"""One graph: dvc.yaml is generated from it, and `all` runs the same stages."""

from __future__ import annotations

import shlex
import shutil
from importlib import import_module
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.closure import source_tree
from pipeline.commands import whole
from pipeline.commands.dvc import set_profile
from pipeline.config import bench_lists, compose, group_choices
from pipeline.errors import ConfigError
from pipeline.stages import parameters
from pipeline.stages.code_files import code_files
from pipeline.stages.dvc_file import dvc_yaml
from pipeline.stages.graph import STAGES, STEPS, Step, runs
from robots.locations import FOLDER

Run = tuple[str, ...]  # a stage and its overrides in alphabetical order


def content() -> dict[str, Any]:
    return yaml.safe_load((FOLDER / "dvc.yaml").read_text(encoding="utf-8"))


def run_by_dvc(text: str = "") -> list[Run]:
    """Commands of dvc.yaml with matrices and variables filled in, without the run's own network."""
    made = yaml.safe_load(text) if text else content()
    bench, found = bench_lists(), []
    for name, stage in made["stages"].items():
        axes = {axis: bench[text[2:-1]] for axis, text in stage.get("matrix", {}).items()}
        for values in product(*axes.values()) if name != "code" else ():
            command = stage["cmd"].replace(" model=${model}", "").replace(" tune=${tune}", "")
            command = command.replace("${profile}", bench["profile"])
            command = command.replace("${networks}", bench["networks"])
            command = command.replace(" evaluate.side_by_side=${processes}", "")
            for axis, value in zip(axes, values, strict=True):
                command = command.replace(f"${{item.{axis}}}", value)
            words = shlex.split(command)
            found.append((words[3], *sorted(words[4:])))
    return found


class ListedError(Exception):
    """All that would be run is known."""


@pytest.fixture
def run_by_all(monkeypatch: pytest.MonkeyPatch) -> list[Run]:
    """What `all` would run: stages with the overrides of their commands."""
    ran: list[Run] = []

    def listed(lists: Any, overrides: Any, compose: Any) -> None:
        ran.extend((step.stage, *sorted(overrides(step, axes))) for step, axes in runs(lists))
        raise ListedError

    monkeypatch.setattr(whole, "units", listed)
    return ran


def run_all(*words: str) -> None:
    with pytest.raises(ListedError):
        whole.everything([*words])


def test_the_committed_file_is_the_generated_one() -> None:
    made = (FOLDER / "dvc.yaml").read_text(encoding="utf-8")
    assert made == dvc_yaml(), "run: python -m pipeline dvc"


def test_all_runs_what_dvc_runs(run_by_all: list[Run]) -> None:
    run_all(f"profile={bench_lists()['profile']}")
    assert sorted(run_by_all) == sorted(run_by_dvc())
    assert len(run_by_all) == len({*run_by_all})
    assert run_by_all[-1][0] == "report"
    stages = {name for name, *_ in run_by_all}
    assert stages == {stage.name for stage in STAGES.values() if not stage.on_demand}


def test_fewer_robots_and_solvers(run_by_all: list[Run]) -> None:
    run_all("profile=smoke", "robots=[panda]", "evaluate.solvers=[lm,pink]")
    evaluated = [overrides for name, *overrides in run_by_all if name == "evaluate"]
    assert sorted(evaluated) == [
        ["evaluate.seeded_by=cycleik", "evaluate.solvers=[lm]", "profile=smoke", "robot=panda"],
        ["evaluate.solvers=[lm]", "profile=smoke", "robot=panda"],
        ["evaluate.solvers=[pink]", "profile=smoke", "robot=panda"],
    ]
    assert all("robot=panda" in overrides for name, *overrides in run_by_all if name != "report")


def test_what_is_typed_replaces_a_choice_but_not_a_network_of_its_own(
    run_by_all: list[Run],
) -> None:
    run_all("robots=[nico]", "agent=endpoint")
    grasps = [overrides for name, *overrides in run_by_all if name == "grasp"]
    assert grasps == [
        ["agent=none", "perception=perfect", "robot=nico"],
        ["agent=endpoint", "perception=camera", "robot=nico"],
    ], "the plain series stays plain"
    run_by_all.clear()
    run_all("robots=[panda]", "model=tiny")
    trained = [overrides for name, *overrides in run_by_all if name == "train"]
    shipped = "train.from=shipped"
    assert trained == [["model=tiny", "robot=panda", shipped], ["model=flow", "robot=panda"]]


def test_all_trains_what_the_project_has_where_that_is_typed(run_by_all: list[Run]) -> None:
    run_all("robots=[nico]", "train.from=default", "detector.from=default")
    assert ("train", "detector.from=default", "robot=nico", "train.from=default") in run_by_all
    assert not [overrides for _, *overrides in run_by_all if "train.from=shipped" in overrides]


def test_only_networks_that_come_with_the_project_can_be_shipped(run_by_all: list[Run]) -> None:
    """A step whose command has the key, and the file that makes it stale when one is replaced."""
    stages = {name: stage for name, stage in content()["stages"].items() if name != "code"}
    taking = {name for name, stage in stages.items() if "${networks}" in stage["cmd"]}
    assert taking == {"train", "detector"}
    made = code_files(source_tree())
    assert {name for name, content in made.items() if "networks" in content} == {
        "train.json",
        "detector.json",
    }
    cards = made["train.json"]["networks"]
    assert {"panda/weights/card.json", "nico/detector/card.json"} <= set(cards)


@pytest.fixture
def paper_in_bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The lists after `python -m pipeline dvc profile=paper`, in a copy of conf/."""
    shutil.copytree(FOLDER / "conf", tmp_path / "conf")
    for module in ("pipeline.commands.dvc", "pipeline.config"):
        monkeypatch.setattr(import_module(module), "CONF_DIR", tmp_path / "conf")
    set_profile("paper")
    return bench_lists()


def test_the_paper_by_dvc_is_the_paper(
    paper_in_bench: dict[str, Any], run_by_all: list[Run]
) -> None:
    assert {key: paper_in_bench[key] for key in ("profile", "model", "tune")} == {
        "profile": "paper",
        "model": "paper",
        "tune": "paper",
    }
    text = dvc_yaml()
    made = yaml.safe_load(text)
    assert made["vars"][0]["numerical"] == ["bio_ik", "trac_ik"]
    assert "evaluate_seeded" not in made["stages"], "an empty list is no matrix"
    assert not [item for item in made["stages"]["report"]["deps"] if "seeded" in item]
    tuned = made["stages"]["tune"]
    assert tuned["cmd"].endswith("model=${model} tune=${tune}")
    assert {"conf/tune/${tune}.yaml": None} in tuned["params"]
    assert {"conf/profile/${profile}.yaml": ["plan", "defaults"]} in made["stages"]["plan"][
        "params"
    ], "the profile chooses the motion"
    run_all("profile=paper")
    assert sorted(run_by_all) == sorted(run_by_dvc(text))
    evaluated = {
        item for name, *items in run_by_all for item in items if item.startswith("evaluate.solvers")
    }
    assert evaluated == {
        f"evaluate.solvers=[{name}]" for name in ("cycleik", "bio_ik", "trac_ik", "flow")
    }


def test_a_robot_that_is_none(run_by_all: list[Run]) -> None:
    with pytest.raises(ConfigError, match="did you mean 'panda'"):
        whole.everything(["robots=[pandaa]"])
    assert run_by_all == []


def test_the_evaluate_stage_by_itself_takes_the_solvers_of_the_whole_run() -> None:
    for profile in ("quick", "paper"):
        bench = bench_lists(profile)
        solvers = compose([f"profile={profile}"]).evaluate.solvers
        assert solvers == [*bench["neural"], *bench["numerical"]]


def test_steps_come_after_what_they_read() -> None:
    before: set[str] = set()
    for step in STEPS.values():
        assert {*step.inputs} <= before
        assert {STEPS[name].stage for name in step.inputs} <= {*STAGES[step.stage].inputs}
        before.add(step.name)


def test_every_stage_depends_on_code_and_libraries_and_no_source_is_listed() -> None:
    for name, stage in content()["stages"].items():
        if name == "code":
            assert stage["always_changed"]
            continue
        assert stage["deps"][0].startswith("results/code/")
        assert "requirements.lock" in stage["deps"]
        assert not [path for path in stage["deps"] if path.endswith(".py")]


def files(step: str, robot: str = "nico", solver: str = "lm") -> set[str]:
    bench = bench_lists()
    fill = {"item.robot": robot, "item.solver": solver, "profile": "quick"}
    fill |= {key: bench[key] for key in ("model", "tune")}
    names = set()
    for file in parameters.parameters(STEPS[step]):
        for key, value in fill.items():
            file = file.replace(f"${{{key}}}", value)
        names.add(file)
    return names


def test_parameters_are_files_and_follow_the_defaults_lists() -> None:
    for step in STEPS.values():
        for name in files(step.name):
            assert (FOLDER / name).is_file(), name
    assert {"conf/grasp/scene/nico.yaml", "conf/motion/lift.yaml"} <= files("grasp")
    assert "conf/agent/vocabulary/default.yaml" in files("grasp_agent")
    assert "conf/agent/vocabulary/default.yaml" not in files("grasp")
    assert "conf/solver/cycleik.yaml" in files("evaluate_seeded")
    assert not [name for name in files("evaluate_numerical") if "model" in name]


def test_a_group_that_the_profiles_set_counts_by_profile() -> None:
    keys = parameters.parameters(STEPS["detector"])["conf/profile/${profile}.yaml"]
    assert keys == ("detector",)  # of grasp it reads parts that no profile sets


def test_every_group_of_a_stage_is_a_folder_of_conf() -> None:
    for stage in STAGES.values():
        for group in stage.groups:
            assert group_choices(group.partition(".")[0]), (stage.name, group)


def test_a_command_names_each_axis_of_its_step() -> None:
    step = Step("s", "evaluate", {"robot": "robots", "solver": "flow"}, (), model="flow")
    assert step.command({"robot": "nico", "solver": "flow"}) == ["robot=nico", "model=flow"]


def test_the_scale_is_set_without_touching_anything_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (FOLDER / "conf" / "bench.yaml").read_text(encoding="utf-8")
    (tmp_path / "bench.yaml").write_text(before, encoding="utf-8")
    monkeypatch.setattr(import_module("pipeline.commands.dvc"), "CONF_DIR", tmp_path)
    set_profile("smoke")
    after = (tmp_path / "bench.yaml").read_text(encoding="utf-8")
    values = yaml.safe_load(after)
    assert (values["profile"], values["model"], values["tune"]) == ("smoke", "tiny", "default")
    pairs = zip(before.splitlines(), after.splitlines(), strict=True)
    assert sum(old != new for old, new in pairs) == 2
    with pytest.raises(ConfigError, match="did you mean 'smoke'"):
        set_profile("smok")
