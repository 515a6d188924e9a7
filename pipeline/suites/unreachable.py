"""Suite of poses that no configuration reaches, and how that is known of each.

`beyond_<d>mm`: further by d than the proven bound of the reach (`robots.reach_bound`), in
the direction and with the orientation of a uniform configuration's tip.

`orientation`: at a place at the edge of reach, which a known configuration reaches, with a random
orientation for which a search finds nothing: the compiled Levenberg-Marquardt descends from so many
random configurations, and even the nearest that it meets is outside a tolerance that is wider than
that of any success. A search is no proof; what it tried stands in columns of evidence.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

import baselines
from baselines.lm import UNLIMITED, LevenbergMarquardt
from baselines.refine import refine
from baselines.registry import using
from pipeline.evaluation.metrics import pose_errors
from pipeline.seeding import derive_seed
from pipeline.suites.config import UnreachableConfig
from pipeline.suites.drawing import draw, uniform_joints
from pipeline.suites.postures import stretched_joints
from pipeline.suites.problems import EVIDENCE, Problems, in_turns, reached
from pipeline.suites.singularity import scale
from robots.rounding import rounded

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

ORIENTATION = "orientation"
MM_PER_M = 1e3


def beyond(distance_mm: float) -> str:
    """Return the stratum of poses that lie so far beyond reach."""
    return f"beyond_{distance_mm:g}mm"


def unreachable(robot: Robot, config: UnreachableConfig, seed: int) -> Problems:
    """Poses beyond reach by each distance, and orientations that no configuration has, in turns."""
    kinds = len(config.beyond_mm) + 1
    counts = [len(range(kind, config.poses, kinds)) for kind in range(kinds)]
    parts = [
        _too_far(robot, distance, count, derive_seed(seed, beyond(distance)))
        for distance, count in zip(config.beyond_mm, counts[:-1], strict=True)
        if count
    ]
    if counts[-1]:
        parts.append(_impossible_orientations(robot, config, counts[-1], seed))
    return in_turns(parts)


def _too_far(robot: Robot, distance_mm: float, count: int, seed: int) -> Problems:
    bound, _ = scale(robot)
    known = draw(robot, count, seed, lambda rng: reached(robot, uniform_joints(robot, rng)))
    offset = known.poses[:, :3] - bound.nearest(known.poses[:, :3])
    length = np.linalg.norm(offset, axis=1, keepdims=True)
    outward = np.where(length > 0.0, offset / np.maximum(length, 1e-12), [0.0, 0.0, 1.0])
    far = bound.radius_m + distance_mm / MM_PER_M
    poses = known.poses.copy()
    poses[:, :3] = rounded(bound.farthest(outward) + far * outward)
    nothing = np.full((count, robot.dof), np.nan)
    evidence = _evidence(nothing, bound_m=bound.radius_m)
    return Problems(poses, np.full(count, beyond(distance_mm)), nothing, None, evidence)


def _impossible_orientations(
    robot: Robot, config: UnreachableConfig, count: int, seed: int
) -> Problems:
    seed = derive_seed(seed, ORIENTATION)
    stretched = stretched_joints(robot, config, seed)

    def propose(rng: np.random.Generator) -> Problems:
        places = reached(robot, stretched(rng), ORIENTATION)
        turned = rng.standard_normal((len(places), 4))
        if len(places) == 0:
            return places
        turned /= np.linalg.norm(turned, axis=1, keepdims=True)
        turned *= np.where(turned[:, :1] < 0.0, -1.0, 1.0)
        poses = np.hstack([places.poses[:, :3], rounded(turned)])
        return _not_found(robot, config, poses, places.joints)

    found = draw(robot, count, seed, propose)
    return replace(found, joints=np.full(found.joints.shape, np.nan))


def _not_found(robot: Robot, config: UnreachableConfig, poses: Array, places: Array) -> Problems:
    """Those of the poses (N, 7) that the search does not find, with what it met.

    Args:
        robot: The robot.
        config: How much is searched, and what would have been found.
        poses: (N, 7) targets.
        places: (N, dof) configurations whose tip is at the same place.
    """
    with using({}):  # whatever settings a run evaluates lm with
        kernel = baselines.load("lm", robot)
    assert isinstance(kernel, LevenbergMarquardt)
    options = kernel.options(None)._replace(
        position_tolerance_m=config.search_position_mm / MM_PER_M,
        rotation_tolerance_rad=float(np.deg2rad(config.search_rotation_deg)),
        iterations=UNLIMITED,
        starts=config.search_starts,
        nearest_starts=0,  # a search is wanted, not a proof
    )
    met = refine(robot, poses, np.empty((len(poses), 0, robot.dof)), options)
    errors = pose_errors(poses, robot.forward_kinematics(met.joints))
    evidence = _evidence(
        places,
        starts=met.starts,
        nearest_position_mm=errors.position_mm,
        nearest_rotation_deg=errors.rotation_deg,
    )
    stratum = np.full(len(poses), ORIENTATION)
    return Problems(poses, stratum, places, None, evidence).at(~met.found)


def _evidence(places: Array, **known: ArrayLike) -> dict[str, Array]:
    """Columns of evidence, NaN where a kind of problem has none.

    Args:
        places: (N, dof) configurations that reach the place, if not the pose.
        **known: What else is known, by name.
    """
    values = {f"place_q{joint}": column for joint, column in enumerate(places.T)}
    for name in ("bound_m", "starts", "nearest_position_mm", "nearest_rotation_deg"):
        value = np.asarray(known.get(name, np.nan), dtype=np.float64)
        values[name] = np.broadcast_to(value, len(places)).copy()
    return {f"{EVIDENCE}{name}": value for name, value in values.items()}
