import coal
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robots import Robot, UrdfError, available_robots, load_robot
from robots.contact import FREE, TOUCHING, UNSURE, contact
from robots.rotations import matrix_from_quaternion, normalised
from robots.shapes import BOX, CYLINDER, SPHERE

COAL = {
    SPHERE: lambda s: coal.Sphere(s[0]),
    CYLINDER: lambda s: coal.Cylinder(s[0], 2 * s[1]),
    BOX: lambda s: coal.Box(*(2 * s)),
}


def _distance(kinds: tuple, sizes: np.ndarray, poses: np.ndarray) -> float:
    objects = [
        (COAL[k](s), coal.Transform3s(p[:9].reshape(3, 3), p[9:]))
        for k, s, p in zip(kinds, sizes, poses, strict=True)
    ]
    (a, at), (b, bt) = objects
    return coal.distance(a, at, b, bt, coal.DistanceRequest(), coal.DistanceResult())


@pytest.mark.parametrize("first", [SPHERE, CYLINDER, BOX])
@pytest.mark.parametrize("second", [SPHERE, CYLINDER, BOX])
def test_contact_agrees_with_coal(first: int, second: int) -> None:
    generator = np.random.default_rng(10 * first + second)
    kind, unsure, answers = np.array([first, second]), 0, set()
    for _ in range(1500):
        sizes = generator.uniform(0.02, 0.3, (2, 3))
        rotations = matrix_from_quaternion(normalised(generator.normal(size=(2, 4))))
        if generator.random() < 0.3:
            rotations[1] = rotations[0][:, [1, 2, 0]]  # aligned edges, the degenerate case
        origins = generator.uniform(-0.4, 0.4, (2, 3))
        poses = np.concatenate([rotations.reshape(2, 9), origins], axis=1)
        state = contact(kind, sizes, poses, 0, 1)
        distance = _distance((first, second), sizes, poses)
        answers.add(state)
        unsure += state == UNSURE
        if state == FREE:
            assert distance > -1e-6
        elif state == TOUCHING:
            assert distance < 1e-6
    assert {FREE, TOUCHING} <= answers
    assert unsure <= 3


@settings(max_examples=200, deadline=None)
@given(st.floats(-1.0, 1.0), st.sampled_from([CYLINDER, BOX]), st.sampled_from([CYLINDER, BOX]))
def test_stacked_shapes_touch_where_they_must(gap_mm: float, first: int, second: int) -> None:
    sizes = np.full((2, 3), 0.1)
    poses = np.tile([1.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0], (2, 1))
    poses[1, 11] = 0.2 + gap_mm / 1000
    state = contact(np.array([first, second]), sizes, poses, 0, 1)
    if abs(gap_mm) > 0.002:
        assert state in ((FREE, UNSURE) if gap_mm > 0 else (TOUCHING, UNSURE))
    else:
        assert state != (TOUCHING if gap_mm > 0.001 else FREE if gap_mm < -0.001 else None)


@pytest.mark.parametrize("name", [*available_robots(), "mixed", "two_link"])
def test_robot_agrees_with_pinocchio(name: str, request: pytest.FixtureRequest) -> None:
    fixture = name in ("mixed", "two_link")
    robot: Robot = request.getfixturevalue(name) if fixture else load_robot(name)
    joints = robot.sample(400, seed=9, collision_free=False)
    found = robot.in_collision(joints)
    assert np.array_equal(found, robot.collision.exact.in_collision(joints))
    assert np.array_equal(found, robot.collision.touching(joints).any(axis=1))
    assert 0 < found.sum() < len(found)


def test_post_is_hit_by_the_forearm_only(two_link: Robot) -> None:
    # The upper arm passes the post at 3 rad; the elbow then turns the forearm into it or away.
    into, away = [3.0, 0.15], [3.0, -0.5]
    assert two_link.collision.pairs == [("base", "forearm")]
    assert two_link.in_collision([into, away, [0.0, 0.0]]).tolist() == [True, False, False]


def test_adjacent_pairs_are_found(mixed: Robot, two_link: Robot) -> None:
    assert two_link.find_allowed_collisions() == [
        ("base", "upper_arm", "adjacent"),
        ("forearm", "upper_arm", "adjacent"),
    ]
    # The bracket has no shape, so carriage and forearm are neighbours.
    assert ("carriage", "forearm", "adjacent") in mixed.find_allowed_collisions()
    # The finger stands still against the wrist: nothing to check, nothing to allow.
    assert not any({"wrist", "finger_link"} <= set(p) for p in mixed.collision.pairs)


def test_pair_that_always_touches_is_found(tmp_path, two_link_urdf) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "fat.urdf"
    text = two_link_urdf.read_text().replace('radius="0.05" length="0.4"', 'radius="2" length="2"')
    path.write_text(text)
    robot = load_robot(urdf=path, base="base", tip="tip")
    assert ("base", "forearm", "always") in robot.find_allowed_collisions()
    assert not robot.in_collision(robot.sample(100, collision_free=False)).any()


def test_mesh_is_checked_exactly_and_a_broken_one_is_named(tmp_path, two_link_urdf) -> None:  # type: ignore[no-untyped-def]
    # A tetrahedron in place of the post, its corner towards the arm.
    corners = np.array([[0.1, 0, 0], [-0.1, 0.1, -0.2], [-0.1, -0.1, -0.2], [-0.1, 0, 0.2]])
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    loops = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corners[i]) for i in face)
        + "endloop\nendfacet\n"
        for face in faces
    )
    (tmp_path / "post.stl").write_text(f"solid post\n{loops}endsolid post\n")
    (tmp_path / "bad.stl").write_text("neither solid nor fluid")
    for mesh in ("post.stl", "bad.stl"):
        text = two_link_urdf.read_text()
        text = text.replace('<cylinder radius="0.05" length="0.4"/>', f'<mesh filename="{mesh}"/>')
        (tmp_path / f"{mesh}.urdf").write_text(text)
    robot = load_robot(urdf=tmp_path / "post.stl.urdf", base="base", tip="tip")
    joints = robot.sample(500, collision_free=False)
    found = robot.in_collision(joints)
    assert np.array_equal(found, robot.collision.exact.in_collision(joints))
    assert 0 < found.sum() < 500
    broken = load_robot(urdf=tmp_path / "bad.stl.urdf", base="base", tip="tip")
    with pytest.raises(UrdfError, match="mesh"):
        broken.in_collision([0.0, 0.0])
