import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from pipeline.config import compose
from pipeline.errors import GraspError
from pipeline.grasping.grip import tip_pose, tip_yaw
from pipeline.grasping.outcome import NOT_GRASPED, SLIPPED, SUCCESS, GraspReport, classify
from pipeline.grasping.trial import trial_setup

GRASP = compose(["profile=smoke"]).grasp


def test_a_trial_is_fixed_by_its_number_and_seed():
    first, again = (trial_setup(GRASP, "nico", 7, seed=3) for _ in range(2))
    assert first.place == again.place
    assert first.yaw == again.yaw
    assert first.place != trial_setup(GRASP, "nico", 7, seed=4).place
    assert first.place != trial_setup(GRASP, "nico", 8, seed=3).place


@pytest.mark.parametrize("robot", GRASP.scenes)
def test_every_row_has_every_object_once_spread_over_the_width(robot):
    scene = GRASP.scenes[robot]
    count = len(scene.objects)
    rows = round((scene.area.x[1] - scene.area.x[0]) / scene.area.row_step) + 1
    setups = [trial_setup(GRASP, robot, number, seed=0) for number in range(count * rows)]
    assert {setup.row for setup in setups} == set(range(rows))
    for start in range(0, len(setups), count):
        row = setups[start : start + count]
        assert sorted(setup.name for setup in row) == sorted(scene.objects)
        across = [setup.place[1] for setup in row]
        assert across == sorted(across)
        assert scene.area.y[0] < across[0] < across[-1] < scene.area.y[1]
        assert_allclose(
            [s.place[0] for s in row], scene.area.x[0] + row[0].row * scene.area.row_step
        )


def test_an_injected_error_has_the_wanted_size():
    config = compose(["profile=smoke", "grasp.position_error=0.03"]).grasp
    for number in range(5):
        assert_allclose(np.linalg.norm(trial_setup(config, "nico", number, 0).error), 0.03)


def test_a_robot_without_scene_is_named():
    with pytest.raises(GraspError, match=r"no grasp scene for robot 'fetch'; there are panda"):
        trial_setup(GRASP, "fetch", 0, 0)


@pytest.mark.parametrize("robot", GRASP.scenes)
def test_the_grip_puts_the_object_at_its_offset_from_above(robot):
    scene = GRASP.scenes[robot]
    place = np.array([0.4, -0.1, scene.table.height + 0.2])
    pose = tip_pose(scene, place, 0.0, 0.0)
    rotation = Rotation.from_quat(pose[[4, 5, 6, 3]])
    assert_allclose(pose[:3] + rotation.apply(scene.grip.offset), place, atol=1e-12)
    approach = {"nicol": [1, 0, 0]}.get(robot, [0, 0, 1])
    assert_allclose(rotation.apply(approach), [0, 0, -1], atol=1e-12)


def test_the_tip_keeps_off_the_table_and_turns_with_the_place():
    scene = GRASP.scenes["nico"]
    pose = tip_pose(scene, [0.3, -0.2, scene.table.height], 0.0, 0.0)
    assert_allclose(pose[2], scene.table.height + scene.grip.floor)
    pivot = scene.grip.pivot
    assert_allclose(tip_yaw(scene, [pivot[0] + 0.2, pivot[1] - 0.2, 0.0]), -45.0)
    assert tip_yaw(GRASP.scenes["panda"], [0.4, 0.2, 0.0]) == 0.0


@pytest.mark.parametrize(
    ("report", "expected", "reason"),
    [
        (GraspReport(lifted=True, bin="left", kept=True), SUCCESS, "left bin"),
        (GraspReport(lifted=True, kept=True), SLIPPED, "beside the bin"),
        (GraspReport(lifted=True), SLIPPED, "on the way"),
        (GraspReport(lifted=True, kept=True, clinging=True), SLIPPED, "stuck to the open hand"),
        (GraspReport(lifted=True, stopped="there is no left bin"), SLIPPED, "no left bin"),
        (GraspReport(stopped="out of reach: best tip error 90 mm"), NOT_GRASPED, "out of reach"),
        (GraspReport(pushed=0.08, touching=[0, 0]), NOT_GRASPED, "moved 80 mm"),
        (GraspReport(pushed=9.0, touching=[0, 0]), NOT_GRASPED, "fell from the table"),
        (GraspReport(pushed=0.0, touching=[0, 0]), NOT_GRASPED, "closed on nothing"),
        (GraspReport(pushed=0.0, touching=[3, 0]), NOT_GRASPED, "left behind"),
    ],
)
def test_classes_are_those_of_the_paper(report, expected, reason):
    outcome, said = classify(report)
    assert outcome == expected
    assert reason in said
