"""Neural methods are folders: what each declares exists, and a new folder is all a method needs."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
import torch
import yaml

import pipeline.learning
from baselines import SettingError, SkippedSolver, skip
from pipeline.config import compose, group_choices
from pipeline.learning.config import ModelConfig
from pipeline.learning.factory import build_network, make_objective, model_config
from pipeline.learning.networks import IkNetwork
from pipeline.learning.refined import RefinedSolver
from pipeline.learning.registry import declared_modules, kinds, method_of, methods
from pipeline.loading import load_solver
from pipeline.solvers import models_of
from robots import load_robot

# What weights on disk are named by: a change here makes every trained file unreadable.
STATE_KEYS = {
    "mlp": {"layers.0.weight", "layers.0.bias", "layers.1.weight", "layers.1.bias"},
    "experts": {
        "metric", "centres", "mean", "scale",
        "weights.0", "weights.1", "biases.0", "biases.1",
    },
    "null_space_mlp": {"layers.0.weight", "layers.0.bias", "layers.1.weight", "layers.1.bias"},
}  # fmt: skip
SCALINGS = {"position_centre", "position_scale", "joint_centre", "joint_scale"}
STREAM = {
    f"{part}.{value}"
    for part in ("entry", "norm", "blocks.0.0", "blocks.0.1", "blocks.0.3")
    for value in ("weight", "bias")
}
NEW = """
from torch import nn
from pipeline.learning.networks import IkNetwork

class Constant(IkNetwork):
    def __init__(self, robot, model):
        super().__init__(robot, heads=1)
        self.output = nn.Parameter(model.level * self.joint_scale.new_ones(self.dof))

    def normalised(self, position, quaternion):
        return self.output.expand(len(position), -1)
"""
LEVEL = 0.25
CONFIG = f"""
from dataclasses import dataclass
from pipeline.learning.config import ModelConfig

@dataclass
class ConstantModel(ModelConfig):
    level: float = {LEVEL}
"""
DECLARED = """
from pipeline.learning.method import Method
METHOD = Method(
    networks={"constant": "pipeline.learning.constant.network.Constant"},
    objective="pipeline.learning.cycleik.objective.CycleObjective",
    model="tiny",
    config="pipeline.learning.constant.config.ConstantModel",
)
"""


def model_of(kind: str) -> ModelConfig:
    """The model of a kind's method in conf/model, made small."""
    values = {"hidden": [8], "tanh_layers": 1, "width": 8, "heads": 1}
    usual = method_of(kind).model if kind in kinds() else "compact"
    path = Path(pipeline.learning.__path__[0]).parents[1] / "conf" / "model" / f"{usual}.yaml"
    known = yaml.safe_load(path.read_text(encoding="utf-8"))
    sizes = {"encoder": [8], "couplings": 1, "components": 2, "experts": 2}
    return model_config({**known, **sizes, **values, "kind": kind})


@pytest.mark.parametrize("kind", kinds())
def test_a_kind_builds_its_network_and_its_objective(kind: str) -> None:
    robot = load_robot("nico")
    network = build_network(robot, model_of(kind))
    declared = method_of(kind)
    assert f"{type(network).__module__}.{type(network).__qualname__}" == declared.networks[kind]
    objective = make_objective(robot, network, compose().train, torch.device("cpu"))
    assert f"{type(objective).__module__}.{type(objective).__qualname__}" == declared.objective
    assert all(import_module(name) for name in declared_modules(kind))


@pytest.mark.parametrize("folder", list(methods()))
def test_a_method_names_a_model_of_its_own_kind_and_the_paper_it_follows(folder: str) -> None:
    method = methods()[folder]
    assert method.model in group_choices("model")
    assert compose([f"model={method.model}"]).model.kind in method.kinds
    text = Path(pipeline.learning.__path__[0], folder, "README.md").read_text(encoding="utf-8")
    assert "Paper" in text


@pytest.mark.parametrize("kind", [*STATE_KEYS, "null_space", "flow"])
def test_tensors_keep_the_names_that_weights_on_disk_have(kind: str) -> None:
    network = build_network(load_robot("nico"), model_of(kind))
    keys = set(network.state_dict()) - SCALINGS
    if kind in STATE_KEYS:
        assert keys == STATE_KEYS[kind]
    elif kind == "null_space":
        assert keys == STREAM | {"exit.weight", "exit.bias"}
    else:
        assert {key for key in keys if not key.startswith("flow.")} == STREAM
        assert {"flow.base.hyper.0.weight", "flow.transform.transforms.0.mask"} <= keys


@pytest.fixture
def new_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    folder = tmp_path / "constant"
    folder.mkdir()
    (folder / "__init__.py").write_text(DECLARED)
    (folder / "network.py").write_text(NEW)
    (folder / "config.py").write_text(CONFIG)
    monkeypatch.setattr(pipeline.learning, "__path__", [*pipeline.learning.__path__, str(tmp_path)])
    methods.cache_clear()
    yield
    methods.cache_clear()


@pytest.mark.usefixtures("new_folder")
def test_a_folder_is_all_that_a_method_needs() -> None:
    assert "constant" in kinds()
    config = compose(["model=tiny", "model.kind=constant"])
    robot = load_robot("nico")
    network = build_network(robot, config.model)
    assert isinstance(network, IkNetwork)
    wanted = network.joint_centre + LEVEL * network.joint_scale
    torch.testing.assert_close(network(torch.zeros(1, 7))[0, 0], wanted)
    objective = make_objective(robot, network, config.train, torch.device("cpu"))
    poses = torch.as_tensor(robot.forward_kinematics(robot.sample(5)), dtype=torch.float32)
    assert objective.errors(poses)[0].shape == (5,)


def test_a_kind_that_no_folder_declares_is_refused_with_those_there_are() -> None:
    with pytest.raises(ValueError, match=r"model.kind must be one of mlp, .*, got 'constant'"):
        model_of("constant")


def test_a_refined_solver_takes_the_models_of_its_proposer() -> None:
    for name in ("cycleik", "flow", "iknet", "null_space"):
        assert models_of(f"{name}_refined") == models_of(name)
    with pytest.raises(SettingError, match="'lm' has no network"):
        load_solver("cycleik_refined", load_robot("nico"), proposer="lm")


def test_a_refined_solver_takes_any_neural_solver_as_its_proposer(tmp_path: Path) -> None:
    robot = load_robot("nico")
    with pytest.raises(
        SettingError, match=r"no neural solver 'lm'.* Valid: cycleik, .*flow, .*null_s"
    ):
        load_solver("cycleik_refined", robot, tmp_path, proposer="lm")
    with pytest.raises(
        SettingError, match=r"'cycleik_refined'.* Valid: cycleik, .*flow, .*null_space"
    ):
        load_solver("flow_refined", robot, tmp_path, proposer="cycleik_refined")
    solver = load_solver("cycleik_refined", robot)
    assert isinstance(solver, RefinedSolver)
    solver.threads = 2
    assert solver.proposer.threads == 2
    assert solver.proposer.name == "cycleik"


def test_a_refined_solver_is_skipped_with_its_proposer(monkeypatch: pytest.MonkeyPatch) -> None:
    from pipeline.learning.flow.solver import FlowIk

    monkeypatch.setattr(FlowIk, "requires", ("nowhere",))
    assert skip("flow_refined") == skip("flow") == "not installed: nowhere"
    assert skip("cycleik_refined") is None
    with pytest.raises(SkippedSolver):
        load_solver("flow_refined", load_robot("nico"), Path("nowhere"))
