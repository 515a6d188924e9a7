"""Planar arms as URDFs, whose solutions can be counted by hand."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from robots import Robot, load_robot
from tests.small_arms import save


def planar(
    folder: Path, lengths: Sequence[float], limit: float = 3.0, kind: str = "revolute"
) -> Robot:
    """Links of some lengths in a row along x, their joints turning about z [m, rad]."""
    parts = ['<robot name="planar"><link name="l0"/>']
    places = [0.0, *lengths]
    for k, place in enumerate(places):
        fixed = k == len(lengths)
        parts.append(
            f'<link name="l{k + 1}"/><joint name="j{k + 1}" type="{"fixed" if fixed else kind}">'
            f'<origin xyz="{place} 0 0"/><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<axis xyz="0 0 1"/><limit lower="-{limit}" upper="{limit}" velocity="1" effort="1"/>'
            "</joint>"
        )
    return load_robot(urdf=save(folder, "".join([*parts, "</robot>"]), "planar.urdf"))
