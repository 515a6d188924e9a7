"""Curves as control points: fitted to poses, and between two others."""

from __future__ import annotations

import numpy as np
from numpy.testing import assert_allclose

from pipeline.planning.curve import between, fit
from pipeline.planning.path import tip_path
from robots.rotations import rotation_angle

RANDOM = np.random.default_rng(3)
QUATERNIONS = RANDOM.normal(size=(2, 4))
QUATERNIONS /= np.linalg.norm(QUATERNIONS, axis=1, keepdims=True)
START, TARGET = np.hstack([RANDOM.normal(size=(2, 3)), QUATERNIONS])
INNER = RANDOM.normal(size=(3, 3))


def test_a_curve_of_the_same_degree_is_found_again() -> None:
    curve = fit(tip_path(START, TARGET, INNER), 4, 1)
    assert_allclose(curve.points, [START[:3], *INNER, TARGET[:3]], atol=1e-9)
    assert_allclose(curve.poses(30)[:, :3], tip_path(START, TARGET, INNER, 30)[:, :3], atol=1e-9)
    assert rotation_angle(
        curve.poses(30)[:, 3:], tip_path(START, TARGET, None, 30)[:, 3:]
    ).max() < (1e-7)


def test_ends_are_met_whatever_lies_between() -> None:
    poses = tip_path(START, TARGET, INNER)
    poses[1:-1, :3] += RANDOM.normal(size=(48, 3))
    curve = fit(poses, 5, 6)
    assert (curve.degree, curve.stretches) == (5, 6)
    assert_allclose(curve.poses(50)[[0, -1], :3], poses[[0, -1], :3], atol=1e-12)
    assert rotation_angle(curve.poses(50)[[0, -1], 3:], poses[[0, -1], 3:]).max() < 1e-7


def test_between_two_curves_is_the_one_and_the_other_and_the_middle() -> None:
    bent, plain = fit(tip_path(START, TARGET, INNER), 5, 6), fit(tip_path(START, TARGET), 5, 6)
    assert_allclose(between(bent, plain, 0.0).poses(20), bent.poses(20), atol=1e-12)
    assert_allclose(between(bent, plain, 1.0).points, plain.points, atol=1e-12)
    middle = between(bent, plain, 0.5)
    assert_allclose(middle.points, 0.5 * (bent.points + plain.points), atol=1e-12)
    assert_allclose(middle.poses(20)[[0, -1], :3], [START[:3], TARGET[:3]], atol=1e-12)
