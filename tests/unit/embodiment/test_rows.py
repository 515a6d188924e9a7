"""Rows of the protocol: reproducible by number, apart from each other, in the action area."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pipeline.config import compose
from pipeline.embodiment.row import ACROSS, row_setup
from pipeline.errors import GraspError
from pipeline.grasping.shapes import extent

GRASP = compose(["profile=smoke"]).grasp


@pytest.mark.parametrize("robot", GRASP.scenes)
def test_every_row_has_every_object_apart_from_its_neighbours(robot: str) -> None:
    scene = GRASP.scenes[robot]
    for number in range(25):
        row = row_setup(GRASP, robot, number, seed=0)
        assert sorted(each.name for each in row) == sorted(scene.objects)
        assert [each.number for each in row] == [number * len(row) + k for k in range(len(row))]
        ends = []
        for each in row:
            low, high = extent(GRASP.objects[each.name], each.yaw, ACROSS)
            ends.append((each.place[1] + low, each.place[1] + high))
        gaps = [after[0] - before[1] for before, after in pairwise(ends)]
        assert min(gaps) > GRASP.protocol.gap - 0.005  # a yaw that follows the place moves it a bit
        assert ends[0][0] > scene.area.y[0] - 0.005
        assert ends[-1][1] < scene.area.y[1] + 0.005


@pytest.mark.parametrize("robot", ["nico", "nicol"])
def test_in_clutter_neighbours_stand_one_to_four_centimetres_apart(robot: str) -> None:
    grasp = compose(["profile=smoke", "experiment=clutter"]).grasp
    scene, gaps = grasp.scenes[robot], []
    for number in range(60):
        row = row_setup(grasp, robot, number, seed=0)
        ends = [
            (each.place[1] + low, each.place[1] + high)
            for each in row
            for low, high in [extent(grasp.objects[each.name], each.yaw, ACROSS)]
        ]
        gaps += [after[0] - before[1] for before, after in pairwise(ends)]
        assert ends[0][0] > scene.area.y[0] - 0.005
        assert ends[-1][1] < scene.area.y[1] + 0.005
    assert 0.005 < min(gaps) < 0.015  # a yaw that follows the place moves it a bit
    assert 0.035 < max(gaps) < 0.045
    assert_allclose(np.quantile(gaps, [0.25, 0.5, 0.75]), [0.0175, 0.025, 0.0325], atol=0.006)


def test_a_row_is_fixed_by_its_number_and_seed() -> None:
    first, again = (row_setup(GRASP, "nico", 4, seed=3) for _ in range(2))
    assert [each.place for each in first] == [each.place for each in again]
    assert first[0].place != row_setup(GRASP, "nico", 4, seed=4)[0].place
    depths = {row_setup(GRASP, "nico", number, 0)[0].place[0] for number in range(12)}
    assert_allclose(sorted(depths), [0.27, 0.29, 0.31, 0.33, 0.35, 0.37])


def test_objects_that_do_not_fit_are_named() -> None:
    wide = replace(GRASP, protocol=replace(GRASP.protocol, gap=0.2))
    with pytest.raises(GraspError, match="do not fit on a row"):
        row_setup(wide, "nicol", 0, 0)
