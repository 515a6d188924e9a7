"""Why a pose has no solution: what is out of the way of it, found by searches that lift one thing.

Only "out of reach" beyond the bound of `robots.reach_bound` is proven. The others rest on searches:
what a search has found, it has found; what it has not found may exist.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines.freedom import Freedom
from baselines.lm_kernel import LmOptions
from baselines.refine import Refined, refine_freely
from robots import rotations
from robots.chain import Chain
from robots.limits import FULL_TURN
from robots.reach_bound import reach_bound

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

REACHABLE, OUT_OF_REACH, LIMITS = "reachable", "out of reach", "limits"
ORIENTATION, UNKNOWN = "orientation", "unknown within the search"
DESCENTS, LIFTED_DESCENTS = 400, 40  # of a search, and of each of those with limits lifted
LIFTED_SEARCHES = 8  # whose answers may exceed the limits by different amounts
NEAR = 10.0  # tolerances within which an answer is too near for a "no"


@dataclass(frozen=True)
class Explanation:
    """Why a pose has no solution, and what that is known from.

    Attributes:
        reason: "reachable" where the search found a solution after all; "out of reach" where no
            configuration has its tip there; "limits" where one has it beyond joint limits;
            "orientation" where the place is reached, but not so turned; or "unknown within the
            search".
        joints: (dof,) the nearest answer inside the limits [rad or m].
        distance_m: From its tip to the target [m].
        angle_rad: The same of the rotation [rad].
        position_distance_m: Of the answer that is nearest in position alone [m].
        beyond_reach_m: How far the target is beyond a proven bound of the reach; below 0 inside.
        position_alone: Whether a configuration inside the limits has its tip at the place.
        limits_lifted: Whether one has the whole pose, or its place where that alone is not reached,
            if joints may be anywhere.
        excess: (dof,) how far the joints of that are outside their limits [rad or m]; zeros
            where there is none.
        descents: Of each search.
        sentence: All of it in one sentence.
    """

    reason: str
    joints: Array
    distance_m: float
    angle_rad: float
    position_distance_m: float
    beyond_reach_m: float
    position_alone: bool
    limits_lifted: bool
    excess: Array
    descents: int
    sentence: str


def explain(robot: Robot, pose: Array, seeds: Array, options: LmOptions) -> Explanation:
    """Search for a pose, for its place alone, and for both with the limits lifted.

    Args:
        robot: The robot.
        pose: (7,) checked target in the base frame.
        seeds: (1, K, dof) where the searches start before random configurations.
        options: Tolerances and damping.
    """
    thorough = options._replace(starts=DESCENTS, time_ns=0)
    target, whole = pose[None], Freedom()
    place = Freedom.position_only()
    met = refine_freely(robot.chain, target, seeds, whole.widths[None], thorough)
    joints = robot.nearest_turns(met.joints)
    reached = robot.forward_kinematics(joints)
    distance = float(np.linalg.norm(reached[0, :3] - pose[:3]))
    angle = float(rotations.rotation_angle(reached[0, 3:], pose[3:]))
    also = np.concatenate([joints[:, None], seeds], axis=1)
    at_place = refine_freely(robot.chain, target, also, place.widths[None], thorough)
    nearest = robot.forward_kinematics(robot.nearest_turns(at_place.joints))[0, :3]
    there = bool(at_place.found[0])
    found = bool(met.found[0])
    excess: Array | None = np.zeros(robot.dof)  # what is found inside the limits exceeds none
    if not found:
        excess = _lifted(robot, pose, also, whole if there else place, options)
    lifted = excess is not None
    beyond = float(reach_bound(robot).beyond(target[:, :3])[0])
    close = distance <= NEAR * options.position_tolerance_m
    close = close and angle <= NEAR * options.rotation_tolerance_rad
    reason = _reason(found, beyond, close, there, lifted)
    over = np.zeros(robot.dof) if excess is None else excess
    missing = float(np.linalg.norm(nearest - pose[:3]))
    return Explanation(
        reason,
        joints[0],
        distance,
        angle,
        missing,
        beyond,
        there,
        lifted,
        over,
        DESCENTS,
        _sentence(robot, reason, distance, angle, missing, beyond, over),
    )


def _reason(found: bool, beyond: float, close: bool, there: bool, lifted: bool) -> str:
    if found:
        return REACHABLE
    if beyond > 0.0:
        return OUT_OF_REACH
    if close:
        return UNKNOWN
    if lifted:
        return LIMITS
    return ORIENTATION if there else OUT_OF_REACH


def _lifted(
    robot: Robot, pose: Array, seeds: Array, freedom: Freedom, options: LmOptions
) -> Array | None:
    """How far outside their limits the joints of a solution are, the least that was found.

    Returns:
        (dof,) [rad or m], or None where there is no solution without limits either.
    """
    chain = _without_limits(robot)
    generator = np.random.default_rng(LIFTED_SEARCHES)
    starts = generator.uniform(chain.lower, chain.upper, (LIFTED_SEARCHES, 1, robot.dof))
    starts[0, 0] = seeds[0, 0]  # the nearest answer inside the limits is the likeliest to be near
    once = options._replace(starts=LIFTED_DESCENTS, time_ns=0)
    poses = np.tile(pose, (LIFTED_SEARCHES, 1))
    widths = np.tile(freedom.widths, (LIFTED_SEARCHES, 1))
    met = refine_freely(chain, poses, starts, widths, once)
    if not met.found.any():
        return None
    excess = _excess(robot, met)
    return excess[np.argmin(excess.max(axis=1))]


def _without_limits(robot: Robot) -> Chain:
    """The chain with a full turn for every joint, and twice its range on for one that slides."""
    chain = robot.chain
    middle, half = (robot.lower + robot.upper) / 2, (robot.upper - robot.lower) / 2
    free = np.where(_turning(robot), np.maximum(half, FULL_TURN / 2), 3.0 * half)
    return chain._replace(lower=middle - free, upper=middle + free)


def _excess(robot: Robot, met: Refined) -> Array:
    """How far joints are outside their limits, (N, dof), turned into them where a turn does it."""
    joints, plain = met.joints[met.found], _turning(robot)
    middle = (robot.lower + robot.upper) / 2
    turned = joints - FULL_TURN * np.round((joints - middle) / FULL_TURN)
    joints = np.where(plain, turned, joints)
    outside = np.maximum(np.maximum(robot.lower - joints, joints - robot.upper), 0.0)
    return np.where(robot.endless, 0.0, outside)


def _turning(robot: Robot) -> NDArray[np.bool_]:
    """Which variables turn one joint each, as far as they go themselves, (dof,)."""
    chain, dof = robot.chain, robot.dof
    driven = np.bincount(chain.variable, minlength=dof)
    plain = ~chain.prismatic & (np.abs(chain.multiplier) == 1.0)
    return np.asarray((driven == 1) & (np.bincount(chain.variable[plain], minlength=dof) == 1))


def _sentence(
    robot: Robot,
    reason: str,
    distance: float,
    angle: float,
    missing: float,
    beyond: float,
    excess: Array,
) -> str:
    nearest = f"the nearest answer is {1e3 * distance:.3g} mm and {np.rad2deg(angle):.3g} deg away"
    if reason == REACHABLE:
        return "The pose has a solution: the search found one."
    if reason == OUT_OF_REACH and beyond > 0.0:
        return (
            f"The place is {1e3 * beyond:.3g} mm beyond a proven bound of the reach of "
            f"{robot.name}; {nearest}."
        )
    if reason == OUT_OF_REACH:
        return (
            f"No search reached the place, which was missed by {1e3 * missing:.3g} mm, "
            "inside the joint limits or beyond them."
        )
    if reason == LIMITS:
        return f"A solution is beyond the limits of {_over(robot, excess)}; {nearest}."
    if reason == ORIENTATION:
        return f"The place is reached, but no search found this orientation there; {nearest}."
    return f"No solution was found, yet {nearest}: the search is too short for a reason."


def _over(robot: Robot, excess: Array) -> str:
    """Joints beyond their limits, and by how much."""
    texts = [
        f"{name} by {1e3 * over:.3g} mm" if slides else f"{name} by {np.rad2deg(over):.3g} deg"
        for name, over, slides in zip(robot.joint_names, excess, robot.sliding, strict=True)
        if over > 0.0
    ]
    return " and ".join(texts)
