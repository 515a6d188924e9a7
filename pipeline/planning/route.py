"""Another curve between the same two ends, for a path that no branch of solutions covers.

A straight line between joints can always be driven: it keeps to the limits, which are a box, and it
cannot flip. So the curve that the tip draws on such a line has a solution without a flip. A Bezier
curve is fitted to its positions and its rotation becomes key rotations, which makes control points
like any others (equations 10 to 12 of the paper); then these are drawn back towards the requested
path, as far as the joints still follow. Joints are solved along the curve and not along the
candidate that it was derived from, so the tip's errors are those of the curve.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.lm_kernel import LmOptions
from baselines.refine import refine
from pipeline.planning.continuity import Ends, branch_flips, joint_steps
from pipeline.planning.curve import Curve, between, fit
from pipeline.planning.follow_kernel import follow_until_complete
from pipeline.planning.joint_space_candidates import joint_space_candidates
from pipeline.planning.search import QUICK

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

TRIES = 8  # candidates that a curve is fitted to, unless none of these can be driven
DETAILS = ((5, 6), (8, 12), (12, 24))  # degree and stretches of rotation of a curve, plainest first
WIDEST = 0.25  # rad or m, joint step that drawing a curve back may lead to
HALVINGS = 5  # of the share by which a curve may be drawn back


class Route(NamedTuple):
    """A curve and the joints that follow it.

    Attributes:
        poses: Waypoints of the curve, base frame [m, unit quaternion], shape (S, 7).
        joints: Joints that reach them [rad or m], shape (S, dof).
        control_points: Inner control points, base frame [m], shape (n, 3).
        control_rotations: Inner key rotations, unit quaternions, shape (m, 4).
        collisions: Waypoints at which the robot touches itself.
    """

    poses: Array
    joints: Array
    control_points: Array
    control_rotations: Array
    collisions: int


def find_route(robot: Robot, requested: Array, ends: Ends, options: LmOptions) -> Route | None:
    """Find a curve between the ends of a path that can be followed without a flip.

    Args:
        robot: The robot.
        requested: Waypoints that could not be followed, base frame, shape (S, 7).
        ends: Joints that the path has to start and end with.
        options: Tolerances and damping.

    Returns:
        The first route that can be driven free of collisions, else that with the fewest waypoints
        in collision, else None: an end is out of reach, or no curve could be followed.
    """
    best: tuple[Curve, Route] | None = None
    for tried, candidate in enumerate(joint_space_candidates(robot, requested, ends, options)):
        if best is not None and tried >= TRIES:
            break
        driven = _fitted(robot, requested, candidate, ends, options)
        if driven is None:
            continue
        if best is None or driven[1].collisions < best[1].collisions:
            best = driven
        if best[1].collisions == 0:
            break
    return None if best is None else _drawn_back(robot, requested, *best, ends, options)


def _fitted(
    robot: Robot, requested: Array, candidate: Array, ends: Ends, options: LmOptions
) -> tuple[Curve, Route] | None:
    """Fit a curve to a joint-space candidate (S, dof) and solve it, None where that fails."""
    tips = robot.forward_kinematics(candidate)
    tips[[0, -1]] = requested[[0, -1]]
    for degree, stretches in DETAILS:
        curve = fit(tips, degree, stretches)
        poses = curve.poses(len(requested))
        solved = refine(robot, poses, candidate[:, None], options._replace(starts=1))
        if solved.found.all():
            route = _checked(robot, curve, poses, solved.joints, ends)
            if route is not None:
                return curve, route
    return None


def _drawn_back(
    robot: Robot, requested: Array, curve: Curve, route: Route, ends: Ends, options: LmOptions
) -> Route:
    """Draw a curve towards the requested path as far as the joints follow, by halving.

    The branch is followed from the start, so it has to arrive by itself where the joints at the
    target are given; neither collisions nor wide joint steps may be added.
    """
    goal = fit(requested, curve.degree, curve.stretches)
    share, step = 0.0, 0.5
    for _ in range(HALVINGS):
        drawn = between(curve, goal, share + step)
        poses = drawn.poses(len(requested))
        joints = _follow(robot, poses, route.joints[0], options)
        closer = None if joints is None else _checked(robot, drawn, poses, joints, ends)
        if closer is not None and _no_worse(closer, route):
            route, share = closer, share + step
        step *= 0.5
    return route


def _no_worse(closer: Route, route: Route) -> bool:
    """Whether a route has no more collisions than another, and no wider steps if they are wide."""
    widest = max(WIDEST, joint_steps(route.joints).max())
    return closer.collisions <= route.collisions and joint_steps(closer.joints).max() <= widest


def _follow(robot: Robot, poses: Array, first: Array, options: LmOptions) -> Array | None:
    """Follow the branch of the first joints (dof,) along a path, None where it is lost."""
    paths = np.empty((1, len(poses), robot.dof))
    origin, seed = np.zeros(1, np.int64), np.ascontiguousarray(first[None])
    winner = follow_until_complete(
        robot.chain, poses, origin, seed, options, QUICK.drift(robot.dof), QUICK.gap, paths
    )
    return None if winner < 0 else paths[0]


def _checked(robot: Robot, curve: Curve, poses: Array, joints: Array, ends: Ends) -> Route | None:
    """Make a route of joints that reach all poses, None if they flip once the ends are put on."""
    joints, _ = ends.pin(joints, np.ones(len(joints), dtype=bool))
    if branch_flips(robot, joints, poses).any():
        return None
    collisions = int(robot.in_collision(joints).sum())
    return Route(poses, joints, curve.points[1:-1], curve.rotations[1:-1], collisions)
