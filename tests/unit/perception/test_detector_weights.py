"""Weights of the detector on disk: half precision, a checksum, and what does not fit is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import torch

from pipeline.config import compose
from pipeline.errors import PerceptionError
from pipeline.perception.config import NetworkConfig, PerceptionConfig
from pipeline.perception.loading import load_detector
from pipeline.perception.network import CentreNetwork
from pipeline.perception.weights import CARD, WEIGHTS, halved, load_centre_network, save_detector
from robots import load_robot

NAMES = ("grapes", "tomato", "lemon_half")
SMALL = NetworkConfig(width=64, height=48, channels=[4, 4, 8, 8])


def saved(folder: Path, network: CentreNetwork | None = None, **card: Any) -> Path:
    torch.manual_seed(0)
    network = network or CentreNetwork(NAMES, SMALL)
    facts = {"width": 64, "height": 48, "channels": [4, 4, 8, 8]}
    facts_of_card = {"robot": "nico", "names": NAMES, "config": {"detector": {"network": facts}}}
    save_detector(folder, network, {**facts_of_card, **card})
    return folder


def test_what_is_loaded_is_what_was_saved_to_half_precision(tmp_path: Path) -> None:
    torch.manual_seed(0)
    network = CentreNetwork(NAMES, SMALL)
    saved(tmp_path, network)
    loaded = load_centre_network(tmp_path, "nico", reversed(NAMES))
    assert loaded.names == NAMES and not loaded.training
    images = torch.rand(2, 3, 48, 64)
    with torch.inference_mode():
        for ours, theirs in zip(halved(network).eval()(images), loaded(images), strict=True):
            assert torch.equal(ours, theirs)


def test_other_robots_and_classes_are_refused_by_name(tmp_path: Path) -> None:
    saved(tmp_path)
    with pytest.raises(PerceptionError, match=r"for the robot 'nico', not for 'nicol'"):
        load_centre_network(tmp_path, "nicol", NAMES)
    with pytest.raises(PerceptionError, match=r"knows grapes, tomato, lemon_half, expected pear"):
        load_centre_network(tmp_path, "nico", ["pear"])
    with pytest.raises(PerceptionError, match="there is no trained detector in"):
        load_centre_network(tmp_path / "none", "nico")


def test_another_shape_is_refused_by_the_name_of_its_tensor(tmp_path: Path) -> None:
    larger = NetworkConfig(width=64, height=48, channels=[4, 4, 8, 16])
    saved(tmp_path, CentreNetwork(NAMES, larger))
    with pytest.raises(PerceptionError, match=r"coarse\.0\.0\.weight has shape \(16, 8, 3, 3\)"):
        load_centre_network(tmp_path, "nico", NAMES)


def test_damaged_and_exchanged_files_are_refused(tmp_path: Path) -> None:
    path = saved(tmp_path) / WEIGHTS
    whole = path.read_bytes()
    path.write_bytes(whole[:-10])
    with pytest.raises(PerceptionError, match="not the file that its card speaks of"):
        load_centre_network(tmp_path, "nico")
    path.unlink()
    with pytest.raises(PerceptionError, match="is missing or not the file"):
        load_centre_network(tmp_path, "nico")
    card = tmp_path / CARD
    card.write_text(json.dumps({"robot": "nico"}))
    with pytest.raises(PerceptionError):
        load_centre_network(tmp_path, "nico")


def test_a_folder_of_the_users_is_taken(tmp_path: Path) -> None:
    saved(tmp_path)
    config: PerceptionConfig = compose([f"perception.weights={tmp_path}"]).perception
    assert load_detector(config, load_robot("nico"), NAMES).names == NAMES
    with pytest.raises(PerceptionError, match="not for 'nicol'"):
        load_detector(config, load_robot("nicol"))
