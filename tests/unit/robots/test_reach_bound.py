"""The bound of reach: exact where a hand can compute it, and never below what is reached."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.suites.singularity import smallest_singular_value
from robots import Robot, available_robots, load_robot
from robots.reach_bound import GRAIN_M, reach_bound

FIXTURES = Path(__file__).parents[2] / "fixtures"
LINKS = """<robot name="r"><link name="b"/><link name="l1"/><link name="l2"/><link name="tip"/>
<joint name="j1" type="{first}"><parent link="b"/><child link="l1"/><origin xyz="0 0 1"/>
<axis xyz="{axis}"/><limit lower="-0.5" upper="1.5" velocity="1" effort="1"/></joint>
<joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="{upper}"/>
<axis xyz="0 0 1"/><limit lower="1.5707963267948966" upper="2.5" velocity="1" effort="1"/></joint>
<joint name="j3" type="{last}"><parent link="l2"/><child link="tip"/><origin xyz="0.3 0 0"/>
<axis xyz="1 0 0"/><limit lower="0" upper="0.1" velocity="1" effort="1"/></joint></robot>"""


def arm(folder: Path, **changes: str) -> Robot:
    values = {"first": "revolute", "axis": "0 0 1", "upper": "0.4 0 0", "last": "fixed"}
    path = folder / "arm.urdf"
    path.write_text(LINKS.format(**{**values, **changes}), encoding="utf-8")
    return load_robot(urdf=path)


def test_an_elbow_that_cannot_straighten_is_known(tmp_path: Path) -> None:
    """Links of 0.4 and 0.3 m at a right angle at most: 0.5 m, not 0.7."""
    bound = reach_bound(arm(tmp_path))
    assert 0.5 <= bound.radius_m <= 0.5 + 2 * GRAIN_M
    np.testing.assert_allclose(bound.origin, [0, 0, 1])


def test_a_straight_arm_is_as_long_as_its_links() -> None:
    bound = reach_bound(load_robot(urdf=FIXTURES / "two_link.urdf"))
    assert 0.7 <= bound.radius_m <= 0.7 + 2 * GRAIN_M
    np.testing.assert_allclose(bound.origin, [0, 0, 0.1])


def test_a_shift_along_an_axis_costs_no_reach(tmp_path: Path) -> None:
    """An elbow 0.2 m up its own axis: the shoulder may be thought to be up there as well."""
    bound = reach_bound(arm(tmp_path, upper="0.4 0 0.2"))
    assert 0.5 <= bound.radius_m <= 0.5 + 3 * GRAIN_M
    np.testing.assert_allclose(bound.origin, [0, 0, 1.2], atol=2 * GRAIN_M)


def test_a_sliding_joint_stretches_the_link_that_it_is_in(tmp_path: Path) -> None:
    bound = reach_bound(arm(tmp_path, last="prismatic"))
    assert np.hypot(0.4, 0.4) <= bound.radius_m <= np.hypot(0.4, 0.4) + 2 * GRAIN_M


def test_a_sliding_joint_before_the_first_turn_carries_it(tmp_path: Path) -> None:
    """A rail from y = -0.5 to 1.5 m, then a single link of 0.3 m at its end."""
    bound = reach_bound(arm(tmp_path, first="prismatic", axis="0 1 0"))
    assert 0.3 <= bound.radius_m <= 0.3 + 2 * GRAIN_M
    ends = bound.farthest(np.array([[0.0, 1.0, 0.0], [0.0, -0.1, 1.0]]))
    np.testing.assert_allclose(ends, [[0.4, 1.5, 1], [0.4, -0.5, 1]])
    near = bound.nearest(np.array([[0.4, 9.0, 1.0], [0.9, 0.25, 1.0]]))
    np.testing.assert_allclose(near, [[0.4, 1.5, 1], [0.4, 0.25, 1]])


@pytest.mark.parametrize("name", [*available_robots(), "mixed"])
def test_no_tip_is_further_than_the_bound(name: str) -> None:
    mixed = {"urdf": FIXTURES / "mixed.urdf", "tip": "tool"}
    robot = load_robot(**mixed) if name == "mixed" else load_robot(name)
    bound = reach_bound(robot)
    joints = robot.sample(20_000, seed=5, collision_free=False)
    at_ends = np.random.default_rng(1).random(joints.shape) < 0.5
    corners = np.where(at_ends, robot.lower, robot.upper)
    points = robot.forward_kinematics(np.vstack([joints, corners]))[:, :3]
    distance = np.linalg.norm(points - bound.nearest(points), axis=1)
    assert distance.max() <= bound.radius_m
    assert distance.max() > 0.85 * bound.radius_m, "a bound that says little"


def test_singular_values_of_a_planar_arm_have_no_unit(tmp_path: Path) -> None:
    """Stretched, both columns of J point the same way: only their ratio to the turns differs."""
    robot = load_robot(urdf=FIXTURES / "two_link.urdf")
    # Columns (0, 0.7/L, 1) and (0, 0.3/L, 1) at L = 0.7 m.
    J = np.array([[1.0, 3.0 / 7.0], [1.0, 1.0]])
    wanted = np.linalg.svd(J, compute_uv=False)[-1]
    assert smallest_singular_value(robot, np.zeros((1, 2)), 0.7)[0] == pytest.approx(wanted)
    slider = arm(tmp_path, first="prismatic", axis="0 1 0")
    # Columns (0, 1, 0) of the rail, times L over L, and that of the turn by 0.3 m at q = 90 deg.
    J = np.array([[0.0, -0.3 / 0.6], [1.0, 0.0], [0.0, 1.0]])
    wanted = np.linalg.svd(J, compute_uv=False)[-1]
    joints = np.array([[0.0, np.pi / 2]])
    assert smallest_singular_value(slider, joints, 0.6)[0] == pytest.approx(wanted)
