"""ONNX and TorchScript beside the network: any number of poses, both precisions, the card."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.special import erf
from torch import Tensor

from pipeline.config import compose
from pipeline.exporting.answering import OUTPUTS
from pipeline.exporting.comparison import compare
from pipeline.exporting.config import ExportConfig
from pipeline.exporting.functions import arc_sine, exact_gelu, smooth_gelu
from pipeline.exporting.kinematics import tip_frames
from pipeline.exporting.source import Source, card_of
from pipeline.exporting.targets import TARGETS
from robots import Robot, load_robot
from robots.rotations import matrix_from_quaternion
from tests.exporting import make_source

MIXED = Path(__file__).parents[2] / "fixtures" / "mixed.urdf"
LARGEST = {"float64": 1e-12, "float32": 2e-5}


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot(urdf=MIXED, base="bench", tip="tool")


@pytest.fixture(scope="module")
def sources(robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Source]:
    kinds = ("experts", "mlp")
    return {kind: make_source(robot, kind, tmp_path_factory.mktemp(kind)) for kind in kinds}


def config(precision: str) -> ExportConfig:
    return compose([f"export.precision={precision}"]).export


@pytest.mark.parametrize(
    ("kind", "precision"), [("experts", "float64"), ("experts", "float32"), ("mlp", "float64")]
)
@pytest.mark.parametrize("to", ["onnx", "torchscript"])
def test_a_file_answers_as_the_network(
    to: str, kind: str, precision: str, sources: dict[str, Source], tmp_path: Path
) -> None:
    if to == "onnx":
        pytest.importorskip("onnx", reason="the extra export is not installed")
        pytest.importorskip("onnxruntime", reason="the extra export is not installed")
    source, target = sources[kind], TARGETS[to]
    path = tmp_path / f"file{target.suffix}"
    target.write(path, source, config(precision), card_of(source, "a test"))
    answer = target.read(source, path, config(precision))
    joints = source.robot.sample(500, seed=6, collision_free=False)
    poses = source.robot.forward_kinematics(joints)
    whole = answer(poses)
    for count in (1, 32, 33):  # few poses gather their experts' weights, many share a grid
        np.testing.assert_allclose(answer(poses[:count]), whole[:count], atol=LARGEST[precision])
    found = compare(source, poses, whole, tie=1e-3)
    assert found.largest <= LARGEST[precision]
    assert found.other == 0
    assert found.ties < 5
    assert source.robot.within_limits(whole, 1e-6).all()
    doubled = poses * np.array([1, 1, 1, -2, -2, -2, -2])
    if kind == "experts":  # which see a rotation matrix: a quaternion's length and sign are none
        np.testing.assert_allclose(answer(doubled), whole, atol=LARGEST[precision])


def test_a_file_of_onnx_says_what_it_is(sources: dict[str, Source], tmp_path: Path) -> None:
    onnx = pytest.importorskip("onnx", reason="the extra export is not installed")
    source, path = sources["experts"], tmp_path / "file.onnx"
    card = card_of(source, "a test")
    TARGETS["onnx"].write(path, source, config("float64"), card)
    model = onnx.load(path)
    assert {entry.key: entry.value for entry in model.metadata_props} == card
    assert [entry.version for entry in model.opset_import if not entry.domain] == [20]
    assert [output.name for output in model.graph.output] == list(OUTPUTS)
    batch = model.graph.input[0].type.tensor_type.shape.dim[0].dim_param
    assert batch == "batch"
    assert json.loads(card["upper"]) == source.robot.upper.tolist()
    assert len(card["weights_sha256"]) == 64


def test_a_file_of_torchscript_says_what_it_is(sources: dict[str, Source], tmp_path: Path) -> None:
    source, path = sources["mlp"], tmp_path / "file.pt"
    card = card_of(source, "a test")
    TARGETS["torchscript"].write(path, source, config("float64"), card)
    files = {"card.json": ""}
    torch.jit.load(str(path), _extra_files=files)
    assert json.loads(files["card.json"]) == card


def test_errors_of_all_heads_are_those_of_their_joints(
    sources: dict[str, Source], tmp_path: Path
) -> None:
    source, path = sources["experts"], tmp_path / "file.pt"
    TARGETS["torchscript"].write(path, source, config("float64"), {})
    joints = source.robot.sample(60, seed=7, collision_free=False)
    poses = source.robot.forward_kinematics(joints)
    with torch.inference_mode():
        best, heads, distance, angle = torch.jit.load(str(path))(torch.as_tensor(poses))
    truth = source.precise_hypotheses(poses)
    np.testing.assert_allclose(heads, truth.joints, atol=1e-12)
    np.testing.assert_allclose(distance, truth.position_mm / 1e3, atol=1e-12)
    np.testing.assert_allclose(angle, np.radians(truth.rotation_deg), atol=1e-7)
    weighed = source.ranking[0] * distance + source.ranking[1] * angle
    rows = torch.arange(60)
    torch.testing.assert_close(best, heads[rows, weighed.argmin(1)], rtol=0, atol=0)


def test_functions_without_float64_elsewhere_are_exact() -> None:
    x = torch.linspace(-12, 12, 4001, dtype=torch.float64)
    exact = 0.5 * x * (1 + torch.as_tensor(erf(x.numpy() / np.sqrt(2))))
    torch.testing.assert_close(exact_gelu(x), exact, rtol=0, atol=1e-14)
    theirs: Tensor = torch.nn.functional.gelu(x, approximate="tanh")
    torch.testing.assert_close(smooth_gelu(x), theirs, rtol=0, atol=1e-14)
    sines = torch.linspace(0, 1, 4001, dtype=torch.float64)
    torch.testing.assert_close(arc_sine(sines), torch.asin(sines), rtol=0, atol=1e-14)


def test_frames_by_columns_are_those_of_the_robot(robot: Robot) -> None:
    joints = robot.sample(50, seed=8, collision_free=False)
    *axes, origin = tip_frames(robot.chain, torch.as_tensor(joints))
    poses = robot.forward_kinematics(joints)
    np.testing.assert_allclose(origin, poses[:, :3], atol=1e-13)
    matrix = np.stack([axis.numpy() for axis in axes], axis=2)
    np.testing.assert_allclose(matrix, matrix_from_quaternion(poses[:, 3:]), atol=1e-13)
