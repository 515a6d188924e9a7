import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pipeline.planning.bezier import bernstein, bezier_curve, bezier_derivative, path_parameter

number = st.floats(-2.0, 2.0, allow_nan=False)
points_3d = st.lists(st.tuples(number, number, number), min_size=1, max_size=9)


def de_casteljau(points, k):
    level = np.array(points, dtype=float)
    while len(level) > 1:
        level = (1 - k) * level[:-1] + k * level[1:]
    return level[0]


def test_fifty_steps_are_fifty_parameters_with_both_ends():
    k = path_parameter(50)
    assert k.shape == (50,)
    assert k[0] == 0.0
    assert k[-1] == 1.0
    assert_allclose(np.diff(k), 1 / 49, atol=1e-15)


def test_fewer_than_two_steps_are_refused():
    with pytest.raises(ValueError, match="at least 2 steps"):
        path_parameter(1)


def test_line_and_quadratic_have_their_closed_forms():
    k = path_parameter(50)[:, None]
    a, b, c = np.array([[0.1, -0.4, 0.9], [0.5, 0.2, 1.4], [0.3, 0.6, 0.8]])
    assert_allclose(bezier_curve([a, b], k[:, 0]), a + k * (b - a), atol=1e-15)
    quadratic = (1 - k) ** 2 * a + 2 * k * (1 - k) * b + k**2 * c
    assert_allclose(bezier_curve([a, b, c], k[:, 0]), quadratic, atol=1e-15)


@given(points_3d)
def test_any_degree_agrees_with_de_casteljau_and_meets_its_ends(points):
    k = path_parameter(11)
    curve = bezier_curve(points, k)
    assert_allclose(curve, [de_casteljau(points, x) for x in k], atol=1e-12)
    assert_allclose(curve[[0, -1]], [points[0], points[-1]], atol=1e-12)


@given(points_3d)
def test_curve_stays_in_the_box_of_its_control_points(points):
    curve = bezier_curve(points, path_parameter(20))
    assert (curve >= np.min(points, axis=0) - 1e-12).all()
    assert (curve <= np.max(points, axis=0) + 1e-12).all()


def test_weights_sum_to_one():
    assert_allclose(bernstein(12, path_parameter(30)).sum(axis=1), 1.0, atol=1e-14)


@pytest.mark.parametrize("degree", [0, 1, 4])
def test_derivative_is_the_finite_difference(degree):
    points = np.random.default_rng(degree).normal(size=(degree + 1, 3))
    k, h = np.linspace(0.1, 0.9, 7), 1e-6
    slope = (bezier_curve(points, k + h) - bezier_curve(points, k - h)) / (2 * h)
    assert_allclose(bezier_derivative(points, k), slope, atol=1e-8)


def test_unusable_control_points_are_refused():
    with pytest.raises(ValueError, match="finite"):
        bezier_curve([[0.0, 0.0, np.nan]], [0.5])
    with pytest.raises(ValueError, match="shape"):
        bezier_curve([0.0, 1.0, 2.0], [0.5])
