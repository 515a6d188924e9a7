"""Tiny untrained networks to export, and sources made of them."""

from __future__ import annotations

from pathlib import Path

import torch

from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.exporting.source import Source, load_source
from pipeline.learning.card import chain_facts
from pipeline.learning.factory import build_network
from pipeline.learning.weights import save_weights
from robots import Robot

MODELS = {
    "experts": ["model=compact", "model.hidden=[16,8]", "model.experts=5", "model.heads=3"],
    "expert": ["model=compact", "model.hidden=[16]", "model.experts=1", "model.heads=2"],
    "mlp": ["model=tiny", "model.hidden=[24,16,8]", "model.tanh_layers=2"],
}


def make_weights(robot: Robot, kind: str, folder: Path) -> Path:
    """Write untrained weights; the experts' in half precision, as those of the project are."""
    config = compose(MODELS[kind])
    torch.manual_seed(0)
    network = build_network(robot, config.model)
    joints = robot.sample(2000, seed=1, collision_free=False)
    poses = robot.forward_kinematics(joints)
    network.prepare(torch.as_tensor(poses, dtype=torch.float32))
    card = {**chain_facts(robot), "config": {"model": to_dict(config.model)}}
    save_weights(folder, network, card, half=kind != "mlp")
    return folder


def make_source(robot: Robot, kind: str, folder: Path) -> Source:
    """Return what is exported of a robot with an untrained network."""
    return load_source(robot, make_weights(robot, kind, folder))
