"""Write a file and check it before it is put in place."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.data.files import replacing, write_text
from pipeline.evaluation.metrics import pose_errors
from pipeline.evaluation.verification import tip_poses
from pipeline.exporting.c_compiler import CompiledHeader
from pipeline.exporting.c_header import descent_settings, example_text, identifier
from pipeline.exporting.comparison import compare
from pipeline.exporting.config import ExportConfig
from pipeline.exporting.source import Source, card_of
from pipeline.exporting.targets import TARGETS, ExportError, Target

FK_LARGEST = 1e-12  # m, and of a quaternion's numbers
CLAIM_SLACK = 1e-6  # mm or deg, rounding of an error that is just within the tolerance


def default_path(source: Source, to: str) -> Path:
    """Return where a file goes that nobody named: `<robot>_ik.<suffix>`, where the user stands."""
    return Path(f"{identifier(source.robot.name)}_ik{TARGETS[to].suffix}")


def export_source(
    source: Source, to: str, path: Path, config: ExportConfig, command: str, seed: int
) -> list[str]:
    """Write a file, and for C a program beside it that times and checks it.

    Args:
        source: The robot and its network, if any.
        to: A key of `TARGETS`.
        path: The file.
        config: How it is written and checked.
        command: That wrote it, for its card.
        seed: Of the poses that it is checked on.

    Returns:
        Sentences on what was written and found.

    Raises:
        ExportError: The file's answers are not those of the network, or there is no network.
        OSError: The file cannot be written.
    """
    if source.solver is None and to != "c":
        raise ExportError(f"to={to} holds a network alone, and model=none has none: take to=c")
    card = {"file": path.name, **card_of(source, command)}
    if to != "c":
        card["precision"] = config.precision
    target, said = TARGETS[to], []
    with replacing(path) as partial:
        target.write(partial, source, config, card)
        said.append(f"{path}: {partial.stat().st_size:,} bytes")
        said.append(_checked(source, target, partial, config, seed))
    if to == "c":
        example = path.with_name(f"{path.stem}_example.c")
        write_text(example, example_text(source, path.name, example.name))
        said.append(f"{example}: gcc -std=c99 -O3 {example.name} -lm && ./a.out 10000")
    return said


def _checked(source: Source, target: Target, path: Path, config: ExportConfig, seed: int) -> str:
    """Check a file on random poses and say what came of it."""
    if reason := target.unreadable() or ("export.poses=0" if config.poses == 0 else ""):
        return f"not checked: {reason}"
    robot = source.robot
    joints = robot.sample(config.poses, seed=seed, collision_free=False)
    poses = robot.forward_kinematics(joints)
    said, in_c = [], target.suffix == TARGETS["c"].suffix
    if in_c:
        said.append(_checked_solve(source, path, joints))
    if source.solver is not None:
        answers = target.read(source, path, config)(poses)
        found = compare(source, poses, answers, config.tie)
        said.append(found.sentence())
        exact = in_c or config.precision == "float64"  # C computes in double, whatever it is
        near = found.largest <= config.largest_rad and not found.other
        if not (near if exact else np.isfinite(found.largest)):  # of nan no comparison holds
            raise ExportError(
                f"the file does not answer as the network does: {found.sentence()}; expected "
                f"at most export.largest_rad={config.largest_rad:g}; please report it"
            )
    return "; ".join(said)


def _checked_solve(source: Source, path: Path, joints: np.ndarray) -> str:
    """Check forward kinematics and descent of a header."""
    poses = source.robot.forward_kinematics(joints)
    header = CompiledHeader(source, path)
    off = np.abs(header.forward_kinematics(joints) - poses).max()
    if not off <= FK_LARGEST:
        raise ExportError(f"forward kinematics of the header are {off:.1e} off; please report it")
    answers, found = header.solve(poses)
    errors = pose_errors(poses[found], tip_poses(source.robot, answers[found]))
    tolerances = descent_settings(source.robot)
    for name, error, most in (
        ("mm", errors.position_mm, 1e3 * tolerances["position_tolerance_m"]),
        ("deg", errors.rotation_deg, np.degrees(tolerances["rotation_tolerance_rad"])),
    ):
        if not (error <= most + CLAIM_SLACK).all():
            raise ExportError(
                f"the header calls poses found that are {error.max():.1e} {name} off, more than "
                f"{most:.1e}; please report it"
            )
    return f"forward kinematics to {off:.1e}, {found.sum()} of {len(found)} poses found"
