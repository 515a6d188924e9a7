"""Distances from obstacles: by hand, by finite differences, and by coal and PyBullet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.suites.verdicts import MOST_MM, TOLERANCE_MM, BulletJudge, CoalJudge
from robots import Box, ObstacleError, Obstacles, Robot, Sphere, load_robot
from robots.clearance_kernel import new_room, place, push_away, set_obstacles

HIGH = 0.1
CUBE = {"position": [0, 0, 0], "size": [1, 1, 1]}
QUARTER = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5))  # about z


def scene(rng: np.random.Generator) -> Obstacles:
    """Six obstacles about an arm's reach."""
    turns = rng.standard_normal((3, 4))
    turns /= np.linalg.norm(turns, axis=1, keepdims=True)
    centres = rng.uniform([-0.7, -0.7, -0.1], [0.7, 0.7, 1.0], (6, 3))
    boxes = [
        Box(tuple(centre), tuple(rng.uniform(0.05, 0.2, 3)), tuple(turn))
        for centre, turn in zip(centres[:3], turns, strict=True)
    ]
    return Obstacles(boxes, [Sphere(tuple(each), rng.uniform(0.03, 0.1)) for each in centres[3:]])


# Of the two-link arm stretched along x the upper arm is a box from 0.02 to 0.38 m, 50 mm wide, the
# forearm one from 0.42 to 0.68 m, 40 mm wide, both 0.1 m above the base.
@pytest.mark.parametrize(
    ("obstacles", "expected"),
    [
        (Obstacles(spheres=[Sphere((0.84, 0.0, HIGH), 0.1)]), 0.06),
        (Obstacles(spheres=[Sphere((0.5, 0.02 + 0.03 + 0.1, HIGH), 0.1)]), 0.03),
        (Obstacles(spheres=[Sphere((0.68 + 0.03, 0.02 + 0.04, HIGH), 0.01)]), 0.04),
        (Obstacles(spheres=[Sphere((0.5, 0.0, HIGH), 0.1)]), -0.12),
        (Obstacles([Box((0.2, 0.0, HIGH + 0.175), (0.1, 0.1, 0.1))]), 0.1),
        (Obstacles([Box((0.2, 0.14, HIGH), (0.02, 0.2, 0.02), QUARTER)]), 0.105),
        (Obstacles([Box((0.68 + 0.053, 0.02 + 0.054, HIGH), (0.1, 0.1, 0.1))]), 0.005),
        (Obstacles([Box((0.68 + 0.04, 0.0, HIGH), (0.1, 0.2, 0.2))]), -0.01),
        (Obstacles(), 1.0),
    ],
)
def test_distances_by_hand(two_link: Robot, obstacles: Obstacles, expected: float) -> None:
    found = two_link.clearance.distances(np.zeros(2), obstacles)
    np.testing.assert_allclose(found, [expected], atol=1e-12)


def test_an_obstacle_turns_with_the_arm(two_link: Robot) -> None:
    above = Obstacles(spheres=[Sphere((0.0, 0.84, HIGH), 0.1)])
    found = two_link.clearance.distances([[np.pi / 2, 0.0], [0.0, 0.0]], above)
    np.testing.assert_allclose(found[0], 0.06, atol=1e-12)
    np.testing.assert_allclose(found[1], np.hypot(0.02, 0.84 - 0.025) - 0.1, atol=1e-12)


def test_each_configuration_has_its_own_obstacles(two_link: Robot) -> None:
    near, far = Sphere((0.84, 0.0, HIGH), 0.1), Sphere((0.94, 0.0, HIGH), 0.1)
    sets = [Obstacles(spheres=[near]), Obstacles(), Obstacles(spheres=[far], clearance_m=0.2)]
    joints = np.zeros((3, 2))
    np.testing.assert_allclose(
        two_link.clearance.distances(joints, sets), [0.06, 1.0, 0.16], atol=1e-12
    )
    assert two_link.clearance.free(joints, sets).tolist() == [True, True, False]


@pytest.mark.parametrize("name", ["panda", "nicol"])
def test_two_other_libraries_measure_the_same(name: str) -> None:
    robot, rng = load_robot(name), np.random.default_rng(4)
    coal = CoalJudge(robot)
    with BulletJudge(robot) as bullet:
        for joints in robot.sample(30, seed=3):
            obstacles = scene(rng)
            ours = 1e3 * robot.clearance.distances(joints, obstacles, MOST_MM / 1e3)[0]
            first = coal.distance_mm(joints, obstacles)
            second = bullet.distance_mm(joints, obstacles)
            assert (ours > 0.0) == (first > 0.0)
            if ours > 0.0:
                assert ours == pytest.approx(first, abs=1e-4)
                assert ours == pytest.approx(second, abs=TOLERANCE_MM)
            else:
                assert second < TOLERANCE_MM


def test_the_gradient_is_that_of_finite_differences() -> None:
    robot, rng = load_robot("panda"), np.random.default_rng(5)
    scene_of, most = robot.clearance.scene, 6
    room, gradient, checked = new_room(scene_of, most), np.empty(robot.dof), 0

    def squared(joints: np.ndarray) -> float:
        place(scene_of, joints, room)
        return float(push_away(scene_of, room, 0.02, 0.005, gradient)[0])

    for joints in robot.sample(40, seed=6):
        rows = robot.clearance.rows(scene(rng), 1)
        set_obstacles(scene_of, rows, 0, room)
        if squared(joints) == 0.0:
            continue
        own = gradient.copy()
        steps = 1e-6 * np.eye(robot.dof)
        slope = [(squared(joints + step) - squared(joints - step)) / 2e-6 for step in steps]
        np.testing.assert_allclose(own, -0.5 * np.array(slope), rtol=1e-3, atol=2e-5)
        checked += 1
    assert checked > 5


def test_plain_forms_say_the_same(tmp_path: Path) -> None:
    obstacles = Obstacles([Box((1, 2, 3), (0.1, 0.2, 0.3), QUARTER)], [Sphere((0, 1, 0), 2)], 0.01)
    assert Obstacles.from_json(obstacles.to_json()) == obstacles
    (tmp_path / "table.yaml").write_text(
        "clearance_m: 0.02\nboxes:\n  - {position: [0.5, 0, -0.1], size: [1, 1, 0.1]}\n"
    )
    read = Obstacles.from_yaml(tmp_path / "table.yaml")
    assert read == Obstacles([Box((0.5, 0.0, -0.1), (1.0, 1.0, 0.1))], clearance_m=0.02)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"box": []}, "no key 'box'"),
        ({"boxes": 5}, "boxes: expected a list, got 5"),
        ({"boxes": [{"position": [0, 0, 0]}]}, "size"),
        ({"boxes": [{"position": [0, 0, 0], "size": [1, 1, 0]}]}, "edges above 0"),
        ({"boxes": [{"position": [0, 0], "size": [1, 1, 1]}]}, "position as 3 finite"),
        (
            {"boxes": [{"position": [0, 0, 0], "size": [1, 1, 1], "orientation": [1, 1, 0, 0]}]},
            "unit",
        ),
        ({"spheres": [{"position": [0, 0, 0], "radius": -1}]}, "radius above 0"),
        ({"clearance_m": -0.1}, "0 m or more"),
        ([], "expected a mapping"),
    ],
)
def test_what_is_no_obstacle_is_refused(values: dict[str, object], words: str) -> None:
    with pytest.raises(ObstacleError, match=words):
        Obstacles.from_dict(values)
