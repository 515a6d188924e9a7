"""Compiled clearance of a configuration: how near links come to obstacles and to each other.

Obstacles stand in the rows after the shapes of the robot, so that what looks at two shapes knows no
difference. Nothing is allocated here but by `new_room`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.bodies import BodyTree
from robots.collision_kernel import ROOT, apart, carry, find_frames, turn
from robots.compiled import njit
from robots.contact import FREE, TOLERANCE, contact
from robots.gap import find_gap
from robots.rows import copy_row
from robots.shapes import CYLINDER, MESH, Shapes

Array = NDArray[np.float64]


class Scene(NamedTuple):
    """A robot's shapes for questions of clearance.

    Attributes:
        tree: Its driven joints.
        shapes: Its shapes, and the pairs that are checked for self-collision.
        moving: (M,) links that a joint moves, rows of `Shapes.link_frame`.
    """

    tree: BodyTree
    shapes: Shapes
    moving: NDArray[np.int64]


class Room(NamedTuple):
    """Arrays that one thread works in: the shapes of a robot, then the obstacles.

    Attributes:
        frames: (m + 1, 12) of the root and the driven joints.
        link_centres: (L, 3) of the spheres around links, m.
        centres: (S + K, 3) of shapes, m.
        poses: (S + K, 12) of those whose stamp is the serial number, and of all obstacles.
        stamps: (S,) serial number of the configuration that a pose is of.
        serial: (1,) number of the configuration.
        kind: (S + K,) and
        size: (S + K, 3) and
        radius: (S + K,) as in `Shapes`.
        last: (1,) row after the last obstacle.
    """

    frames: Array
    link_centres: Array
    centres: Array
    poses: Array
    stamps: NDArray[np.int64]
    serial: NDArray[np.int64]
    kind: NDArray[np.int64]
    size: Array
    radius: Array
    last: NDArray[np.int64]


def new_room(scene: Scene, most: int) -> Room:
    """Room for a scene with at most so many obstacles."""
    shapes = scene.shapes
    count = len(shapes.kind)
    room = Room(
        frames=np.empty((len(scene.tree.parent) + 1, 12)),
        link_centres=np.empty((len(shapes.link_radius), 3)),
        centres=np.empty((count + most, 3)),
        poses=np.empty((count + most, 12)),
        stamps=np.zeros(count, dtype=np.int64),
        serial=np.zeros(1, dtype=np.int64),
        kind=np.concatenate([shapes.kind, np.zeros(most, dtype=np.int64)]),
        size=np.concatenate([shapes.size, np.zeros((most, 3))]),
        radius=np.concatenate([shapes.radius, np.zeros(most)]),
        last=np.full(1, count, dtype=np.int64),
    )
    room.frames[0] = ROOT
    return room


@njit(_nrt=False)
def set_obstacles(scene, obstacles, row, room):  # type: ignore[no-untyped-def]
    """Put the obstacles of one configuration into the rows after the robot's shapes."""
    start = scene.shapes.kind.shape[0]
    for k in range(obstacles.number[row]):
        i, o = start + k, obstacles.first[row] + k
        room.kind[i], room.radius[i] = obstacles.kind[o], obstacles.radius[o]
        for column in range(3):
            room.size[i, column] = obstacles.size[o, column]
            room.centres[i, column] = obstacles.poses[o, 9 + column]
        copy_row(obstacles.poses[o], room.poses[i])
    room.last[0] = start + obstacles.number[row]


@njit(_nrt=False)
def place(scene, q, room):  # type: ignore[no-untyped-def]
    """Put the robot into a configuration (dof,)."""
    shapes = scene.shapes
    find_frames(scene.tree, q, room.frames)
    carry(room.frames, shapes.link_frame, shapes.link_centre, room.link_centres)
    carry(room.frames, shapes.frame, shapes.translations, room.centres)
    room.serial[0] += 1


@njit(no_cpython_wrapper=True, _nrt=False)
def _far(points, a, others, b, reach):  # type: ignore[no-untyped-def]
    return reach <= 0.0 or apart(points, a, others, b, reach)


@njit(no_cpython_wrapper=True, _nrt=False)
def _pose(scene, room, i):  # type: ignore[no-untyped-def]
    """Make sure that the pose of shape i of the robot is that of the configuration."""
    if room.stamps[i] != room.serial[0]:
        room.stamps[i] = room.serial[0]
        turn(room.frames, scene.shapes.frame, scene.shapes.rotations, room.centres, room.poses, i)


@njit(_nrt=False)
def nearest(scene, room, most):  # type: ignore[no-untyped-def]
    """Least distance of a link that moves from an obstacle, after `place`, at most `most` m."""
    shapes, robot_shapes = scene.shapes, scene.shapes.kind.shape[0]
    best = most
    for link in scene.moving:
        for o in range(robot_shapes, room.last[0]):
            beside = room.radius[o] + best
            if _far(room.link_centres, link, room.centres, o, shapes.link_radius[link] + beside):
                continue
            for s in range(shapes.link_start[link], shapes.link_start[link + 1]):
                beside = room.radius[o] + best
                if _far(room.centres, s, room.centres, o, room.radius[s] + beside):
                    continue
                _pose(scene, room, s)
                best = min(best, find_gap(room.kind, room.size, room.poses, s, o)[0])
    return best


@njit(_nrt=False)
def push_away(scene, room, clearance, margin, gradient):  # type: ignore[no-untyped-def]
    """Look at what is nearer than it should be, after `place`.

    Args:
        scene: The `Scene`.
        room: The `Room`, with obstacles and a configuration.
        clearance: Least distance from obstacles that counts as free [m]; pairs of the robot's own
            links need not touch.
        margin: Distances below that by less than this are pushed as well [m].
        gradient: (dof,) receives the derivative of -½ Σ (what is missing of clearance and margin)²
            with respect to the joints: the direction that leads away.

    Returns:
        That sum of squares [m²], and whether the configuration is free. Pairs with a mesh count as
        free of self-collision: only an exact library knows.
    """
    shapes, robot_shapes = scene.shapes, scene.shapes.kind.shape[0]
    gradient[:] = 0.0
    squared, free = 0.0, True
    wanted = clearance + margin
    for link in scene.moving:
        for o in range(robot_shapes, room.last[0]):
            reach = shapes.link_radius[link] + room.radius[o] + wanted
            if _far(room.link_centres, link, room.centres, o, reach):
                continue
            for s in range(shapes.link_start[link], shapes.link_start[link + 1]):
                if _far(room.centres, s, room.centres, o, room.radius[s] + room.radius[o] + wanted):
                    continue
                _pose(scene, room, s)
                gap, n, point = find_gap(room.kind, room.size, room.poses, s, o)
                if gap < wanted:
                    squared += (wanted - gap) ** 2
                    free = free and gap >= clearance
                    _move(scene, room, shapes.frame[s], n, point, gap - wanted, gradient)
    for p in range(shapes.pair_links.shape[0]):
        a, b = shapes.pair_links[p, 0], shapes.pair_links[p, 1]
        reach = shapes.link_radius[a] + shapes.link_radius[b] + margin
        if _far(room.link_centres, a, room.link_centres, b, reach):
            continue
        for k in range(shapes.pair_start[p], shapes.pair_start[p + 1]):
            a, b = shapes.pair_shapes[k, 0], shapes.pair_shapes[k, 1]
            if _far(room.centres, a, room.centres, b, room.radius[a] + room.radius[b] + margin):
                continue
            _pose(scene, room, a)
            _pose(scene, room, b)
            gap, n, point = find_gap(room.kind, room.size, room.poses, a, b)
            if gap >= margin or not _counts(room, a, b, gap):
                continue
            squared += (margin - gap) ** 2
            free = free and gap > TOLERANCE
            _move(scene, room, shapes.frame[a], n, point, gap - margin, gradient)
            _move(scene, room, shapes.frame[b], n, point, margin - gap, gradient)
    return squared, free


@njit(no_cpython_wrapper=True, _nrt=False)
def _counts(room, a, b, gap):  # type: ignore[no-untyped-def]
    """Whether a gap of two shapes of the robot says something: a lower bound may not."""
    if room.kind[a] == MESH or room.kind[b] == MESH:
        return False
    if gap > TOLERANCE or (room.kind[a] != CYLINDER and room.kind[b] != CYLINDER):
        return True
    return contact(room.kind, room.size, room.poses, a, b) != FREE


@njit(no_cpython_wrapper=True, _nrt=False)
def _move(scene, room, frame, n, point, weight, gradient):  # type: ignore[no-untyped-def]
    """Add weight times the speed, along n, of a point of a frame to the gradient."""
    driven = scene.tree.driven
    while frame >= 0:
        row = frame + 1
        zx, zy, zz = room.frames[row, 2], room.frames[row, 5], room.frames[row, 8]
        if driven.prismatic[frame]:
            speed = n[0] * zx + n[1] * zy + n[2] * zz
        else:
            x = point[0] - room.frames[row, 9]
            y = point[1] - room.frames[row, 10]
            z = point[2] - room.frames[row, 11]
            speed = n[0] * (zy * z - zz * y) + n[1] * (zz * x - zx * z) + n[2] * (zx * y - zy * x)
        gradient[driven.variable[frame]] += weight * driven.multiplier[frame] * speed
        frame = scene.tree.parent[frame]


@njit(nogil=True, _nrt=False)
def measure(scene, obstacles, joints, most, room, distances):  # type: ignore[no-untyped-def]
    """Write how far configurations are from their obstacles.

    Args:
        scene: `Scene` of the robot.
        obstacles: `ObstacleRows` of N configurations.
        joints: (N, dof), rad or m.
        most: Distances beyond are written as this [m].
        room: `Room` for the largest set.
        distances: (N,) receives them [m].
    """
    for row in range(joints.shape[0]):
        set_obstacles(scene, obstacles, row, room)
        place(scene, joints[row], room)
        distances[row] = nearest(scene, room, most)
