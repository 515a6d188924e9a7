import numpy as np
import pybullet
import pytest
from numpy.testing import assert_allclose
from pybullet_utils.bullet_client import BulletClient

from pipeline.config import compose
from pipeline.grasping.config import BinConfig
from pipeline.grasping.scene import inside
from pipeline.grasping.shapes import extent, make_bin, make_object, make_table

GRASP = compose(["profile=smoke"]).grasp
LEFT = np.array([0.0, 1.0, 0.0])  # of the robot


@pytest.fixture
def client():
    connected = BulletClient(pybullet.DIRECT)
    yield connected
    connected.disconnect()


@pytest.mark.parametrize("name", GRASP.objects)
def test_an_object_is_as_high_as_it_says_and_stays_where_it_is_laid(client, name):
    obj, scene = GRASP.objects[name], GRASP.scenes["panda"]
    client.setGravity(0, 0, -9.81)
    client.setPhysicsEngineParameter(fixedTimeStep=1 / 240, numSolverIterations=100)
    make_table(client, scene.table)
    body = make_object(client, obj, (0.4, 0.1), 0.3, scene.table.height)
    low, high = (np.array(corner) for corner in client.getAABB(body))
    assert_allclose(high[2] - low[2], obj.height, atol=0.006)  # with Bullet's margin
    for _ in range(240):
        client.stepSimulation()
    position, _ = client.getBasePositionAndOrientation(body)
    assert np.linalg.norm(np.array(position[:2]) - [0.4, 0.1]) < 0.01
    assert_allclose(position[2], scene.table.height + obj.height / 2, atol=0.004)
    assert client.getDynamicsInfo(body, -1)[0] == obj.mass


@pytest.mark.parametrize(
    ("name", "grams", "millimetres"),
    [
        ("soup_can", 349, (66, 66, 101)),
        ("baseball", 148, (75, 75, 75)),
        ("banana", 66, (190, None, 36)),
        ("pear", 49, (100, 66, 66)),
        ("orange", 47, (73, 73, 73)),
    ],
)
def test_household_objects_have_their_published_size(client, name, grams, millimetres):
    obj = GRASP.objects[name]
    assert np.isclose(1e3 * obj.mass, grams)
    body = make_object(client, obj, (0.0, 0.0), 0.0, 0.0)
    low, high = client.getAABB(body)
    for axis, size in enumerate(millimetres):
        if size is not None:
            assert_allclose(1e3 * (high[axis] - low[axis]), size, atol=6)


def test_a_bin_holds_what_falls_into_it(client):
    box = BinConfig(centre=[0.3, -0.2], size=[0.2, 0.2, 0.1], floor=0.5, wall=0.01)
    client.setGravity(0, 0, -9.81)
    make_bin(client, box)
    body = make_object(client, GRASP.objects["tomato"], (0.33, -0.25), 0.0, 0.7)
    for _ in range(480):
        client.stepSimulation()
    assert inside(box, client.getBasePositionAndOrientation(body)[0])


def test_beside_above_and_below_a_bin_is_not_inside():
    box = BinConfig(centre=[0.3, -0.2], size=[0.2, 0.2, 0.1], floor=0.5, wall=0.01)
    assert inside(box, [0.3, -0.2, 0.55])
    for outside in ([0.3, -0.05, 0.55], [0.45, -0.2, 0.55], [0.3, -0.2, 0.65], [0.3, -0.2, 0.45]):
        assert not inside(box, outside)


def test_extents_of_primitives_by_hand() -> None:
    banana, can, pear = (GRASP.objects[name] for name in ("banana", "soup_can", "pear"))
    low, high = extent(banana, np.pi / 2, LEFT)
    # Two bent ends: 53.5 mm out, half of 50 mm at 25 deg, and the radius of 16 mm.
    assert_allclose(high - low, 2 * (0.0535 + 0.025 * np.cos(np.deg2rad(25)) + 0.016))
    assert_allclose(extent(can, 1.0, LEFT), (-0.033, 0.033))
    assert_allclose(extent(pear, np.pi / 2, LEFT), (-0.033, 0.034 + 0.015 + 0.018))
    assert_allclose(extent(pear, -np.pi / 2, LEFT)[0], -(0.034 + 0.015 + 0.018))
