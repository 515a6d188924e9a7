"""Composition: every choice composes, and what cannot be is refused with the valid choices."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.config import chosen, compose, group_choices, sweep, to_yaml
from pipeline.errors import ConfigError
from pipeline.locations import CONF_DIR
from robots.locations import FOLDER
from tests.groups import runs


@pytest.mark.parametrize("run", runs(), ids=" ".join)
def test_every_choice_of_every_group_composes(run: list[str]) -> None:
    shown = to_yaml(compose(run))
    groups = {override.partition("=")[0] for override in run}
    assert all(f"\n{group}:" in shown for group in groups - {"experiment"})


def test_profiles_set_the_scale_and_the_command_line_has_the_last_word() -> None:
    smoke = compose(["profile=smoke"])
    assert (smoke.model.name, smoke.dataset.train, smoke.results_dir) == (
        "tiny",
        2000,
        str(FOLDER / "results" / "smoke"),
    )
    assert compose(["profile=smoke", "model=compact"]).model.name == "compact"
    paper = compose(["profile=paper", "robot=nico"])
    assert paper.train.batch_size == 300
    assert paper.model.hidden == [2270, 560, 1100, 1990, 2590, 870]
    assert paper.dataset.test == 200_000


def test_a_model_brings_its_recipe_and_another_may_be_named() -> None:
    for model in group_choices("model"):
        assert chosen([f"model={model}"])["train"] == model
    assert chosen(["model=flow", "train=compact"])["train"] == "compact"
    assert chosen(["experiment=losses", "profile=paper"])["train"] == "small_mlp"
    assert compose(["profile=paper", "model=flow"]).train == replace(
        compose(["model=flow"]).train, epochs=10
    ), "a profile sets the scale, not another model's recipe"


def test_a_model_without_a_recipe_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copytree(CONF_DIR, tmp_path / "conf")
    tiny = tmp_path / "conf" / "model" / "tiny.yaml"
    tiny.with_name("mine.yaml").write_text(tiny.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr("pipeline.config.CONF_DIR", tmp_path / "conf")
    with pytest.raises(ConfigError, match=r"no recipe conf/train/mine.yaml.* compact, "):
        compose(["model=mine"])
    assert compose(["model=mine", "train=tiny"]).train.batch_size == 512


def test_table_one_is_trained_as_published_or_so_that_it_stands() -> None:
    published = compose(["model=paper", "train=table_one"]).train
    assert (published.warm_up_steps, published.gradient_clip) == (0, None)
    paper = compose(["profile=paper"])
    assert paper.train == compose(["profile=paper", "train=table_one_stable"]).train
    assert (paper.train.warm_up_steps, paper.train.gradient_clip) == (500, None)
    searched = compose(["profile=paper", "train=table_one"])
    assert (searched.train, searched.model) == (replace(published, epochs=10), paper.model)


def test_from_is_a_key_although_python_reserves_the_word() -> None:
    assert compose(["train.from=best"]).train.source == "best"
    assert "from: best" in to_yaml(compose(["train.from=best"]))


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("robot=pandaa", ["'pandaa'", "did you mean 'panda'", "nico"]),
        ("model=huge", ["no model 'huge'", "compact"]),
        ("robot=null", ["no robot 'None'", "nico"]),
        ("profile=", ["profile"]),
        ("train.learning_rat=1", ["learning_rat", "did you mean 'learning_rate'", "epochs"]),
        ("trian.epochs=1", ["did you mean 'train'"]),
        ("+train.speed=1", ["speed"]),
        ("~train.epochs", ["cannot be removed"]),
        ("train.batch_size=-1", ["train.batch_size", "greater than 0", "-1"]),
        ("train.batch_size=abc", ["train.batch_size", "abc"]),
        ("train.batch_size=1.5", ["train.batch_size", "1.5"]),
        ("train.epochs=0", ["train.epochs", "greater than 0"]),
        ("train.learning_rate=nan", ["train.learning_rate"]),
        ("train.loss=l2", ["smooth", "former", "l2"]),
        ("train.device=tpu", ["auto, cpu, cuda"]),
        ("dataset.train=0", ["dataset.train"]),
        ("model.hidden=[]", ["model.hidden", "empty"]),
        ("model.hidden=[64,-3]", ["model.hidden", "-3"]),
        ("model.tanh_layers=9", ["model.tanh_layers"]),
        ("seed=-1", ["seed"]),
        ("evaluate.not_found=maybe", ["idle", "nan", "maybe"]),
        ("grasp.trials=-5", ["grasp.trials", "-5"]),
        ("plan.pairs=0", ["plan.pairs"]),
        ("tune.space.hidden.low=9", ["low", "high"]),
        ("tune.space.learning_rate.low=0", ["log: true", "greater than 0"]),
        ("tune.space.learning_rate.step=0.1", ["no key", "step", "log"]),
        ("tune.space.learning_rate.kind=choice", ["choices"]),
        ("tune.space.hidden.kind=int", ["tune.space.hidden", "layers"]),
        ("tune.storage=mysql://host/db", ["journal", "postgresql://"]),
        ("+tune.space.foo={kind:int,low:1,high:2}", ["'foo'", "learning_rate"]),
        ("tune.objective_position=-1", ["tune.objective_position", "-1"]),
        ("grasp.recording.width=0", ["grasp.recording.width", "greater than 0"]),
        ("grasp.recording.rate=-5", ["grasp.recording.rate", "greater than 0"]),
        ("grasp.scenes.panda.area.x=[2,1]", ["area.x", "low 2.0 is above high 1.0"]),
        ("grasp.scenes.panda.area.y=[1]", ["area.y", "two numbers"]),
        ("grasp.scenes.panda.objects=[]", ["at least one object"]),
        ("perception=radar", ["'radar'", "camera", "perfect"]),
        ("perception.detector=yolo", ["perception.detector", "embedded, open_vocabulary"]),
        ("perception.perturbation.tilt=[1]", ["perception.perturbation.tilt", "three numbers"]),
        ("perception.vocabulary.prompt=thing", ["{name}", "'thing'"]),
        ("detector.network.width=100", ["detector.network.width", "multiple of 16", "100"]),
        ("detector.training.tilt=[2,1]", ["tilt", "low 2.0 is above high 1.0"]),
        ("detector.held_out.textures=[marble]", ["textures", "waves", "'marble'"]),
        ("suite=near", ["no suite 'near'", "near_singular"]),
        ("suite.poses=0", ["suite.poses", "greater than 0"]),
        ("suite.margin=0.1", ["margin"]),
        ("results_dir=", ["results_dir must name a folder"]),
        ("results_dir=.", ["results_dir must name a folder"]),
        ("train.epochs", ["key=value"]),
        ("train.epochs=1,2", ["-m"]),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(override: str, words: list[str]) -> None:
    with pytest.raises(ConfigError) as caught:
        compose([override])
    message = str(caught.value)
    assert all(word in message for word in words), message
    assert message.count("\n") <= 1


def test_a_sweep_is_the_product_of_its_lists_in_order() -> None:
    runs = sweep(["train.loss=former,smooth", "robot=panda,nico", "profile=smoke"])
    assert runs == [
        ["train.loss=former", "robot=panda", "profile=smoke"],
        ["train.loss=former", "robot=nico", "profile=smoke"],
        ["train.loss=smooth", "robot=panda", "profile=smoke"],
        ["train.loss=smooth", "robot=nico", "profile=smoke"],
    ]
    assert sweep(["seed=range(0,3)"]) == [["seed=0"], ["seed=1"], ["seed=2"]]
    assert sweep(["model.hidden=[64,64]"]) == [["model.hidden=[64,64]"]]
    assert sweep(["robot=glob(ni*)"]) == [["robot=nico"], ["robot=nicol"]]
    with pytest.raises(ConfigError, match="matches no robot"):
        sweep(["robot=glob(x*)"])
    with pytest.raises(ConfigError, match="list the values of seed"):
        sweep(["seed=glob(*)"])
    with pytest.raises(ConfigError, match="open interval"):
        sweep(["train.learning_rate=interval(0,1)"])


def test_a_new_axis_of_the_search_is_a_number_of_train_or_model() -> None:
    axis = compose(["+tune.space.weight_decay={kind:float,low:0,high:0.1}"]).tune.space
    assert axis["weight_decay"].high == 0.1


MUG = "{mass: 0.3, friction: 1.0, rolling_friction: 0.001, spinning_friction: 0.001, height: 0.1, "


def test_a_run_may_bring_an_object_of_its_own() -> None:
    part = "{shape: box, size: [0.05, 0.05, 0.1], position: [0, 0, 0], rotation: [0, 0, 0]}"
    coloured = part.replace("}", ", colour: [1, 0, 0, 1]}")
    mug = f"+grasp.objects.mug={MUG}parts: [{coloured}]}}"
    grasp = compose([mug, "grasp.scenes.panda.objects=[mug]"]).grasp
    assert grasp.objects["mug"].mass == 0.3
    assert grasp.scenes["panda"].objects == ["mug"]
    assert "banana" in grasp.objects
    with pytest.raises(ConfigError, match="colour"):
        compose([f"+grasp.objects.mug={MUG}parts: [{part}]}}"])
    with pytest.raises(ConfigError, match="weight"):
        compose(["+grasp.objects.mug={weight: 1}"])
    with pytest.raises(ConfigError, match="mugg"):
        compose([mug, "grasp.scenes.panda.objects=[mugg]"])
