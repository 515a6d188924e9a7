from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.errors import ConfigError
from pipeline.grasping.config import MOTIONS
from robots import load_robot

GRASP = compose(["profile=smoke"]).grasp


def test_every_scene_is_of_a_robot_with_a_hand_and_of_known_objects():
    for name, scene in GRASP.scenes.items():
        assert load_robot(name).description.hand is not None
        assert set(scene.objects) <= set(GRASP.objects)
        assert set(scene.bins) == {"left", "right"}


def test_motions_are_the_four_of_the_primitive():
    assert set(GRASP.motions) == set(MOTIONS)


@pytest.mark.parametrize(
    ("robot", "width", "depth", "row"), [("nico", 0.4, 0.1, 0.02), ("nicol", 0.8, 0.3, 0.05)]
)
def test_action_areas_are_the_papers(robot, width, depth, row):
    area = GRASP.scenes[robot].area
    assert np.isclose(area.y[1] - area.y[0], width)
    assert np.isclose(area.x[1] - area.x[0], depth)
    assert area.row_step == row


def test_bins_do_not_stand_in_the_action_area():
    for scene in GRASP.scenes.values():
        left, right = scene.bins["left"], scene.bins["right"]
        assert left.centre[1] - left.size[1] / 2 > scene.area.y[1]
        assert right.centre[1] + right.size[1] / 2 < scene.area.y[0]


def test_the_hand_lets_go_within_the_bin():
    for scene in GRASP.scenes.values():
        for box in scene.bins.values():
            drop = np.array(box.drop or box.centre)
            assert (np.abs(drop - box.centre) < np.array(box.size[:2]) / 2 - box.wall).all()


@pytest.mark.parametrize(
    ("override", "said"),
    [("grasp.trials=0", "grasp.trials"), ("grasp.scenes.nico.objects=[rock]", "rock")],
)
def test_what_cannot_be_is_refused_at_the_command_line(override, said):
    with pytest.raises(ConfigError, match=said):
        compose(["profile=smoke", override])


@pytest.mark.parametrize(
    ("part", "change", "said"),
    [
        (GRASP, {"position_error": -0.01}, "grasp.position_error"),
        (GRASP, {"video": "sometimes"}, "grasp.video"),
        (GRASP, {"motions": {}}, "grasp.motions"),
        (GRASP, {"placements": "guessed"}, "grasp.placements"),
        (GRASP, {"shake_after_lift": 0.1}, "needs a lift that ends: grasp.carry=two_motions"),
        (GRASP.protocol, {"widest_gap": 0.01}, "grasp.protocol.widest_gap"),
        (GRASP.physics, {"rate": 10.0}, "grasp.physics.rate"),
        (GRASP.physics, {"placement_noise": -1e-6}, "grasp.physics.placement_noise"),
        (GRASP.timing, {"speed": 1.5}, "timing.speed"),
        (GRASP.timing, {"swing": 0.0}, "timing.swing"),
        (GRASP.objects["pear"], {"mass": 0.0}, "mass"),
        (GRASP.objects["tomato"], {"damping": None}, "both, or neither"),
        (GRASP.objects["tomato"].parts[0], {"size": [0.1, 0.1]}, "1 numbers"),
        (GRASP.scenes["panda"].hand, {"tension": -1.0}, "tension"),
        (GRASP.scenes["panda"].bins["left"], {"wall": 0.5}, "wall"),
    ],
)
def test_what_cannot_be_is_refused(part, change, said):
    with pytest.raises(ValueError, match=said):
        replace(part, **change)
