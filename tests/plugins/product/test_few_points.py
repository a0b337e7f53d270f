"""Curves of few points, as files give them, do not turn back between the points."""

import numpy as np
import pytest

from bozzetto.plugin import Job
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.hand_over.point_fit import closed_spline_through, spline_through
from bozzetto_product.modeler import ProductModeler
from tests.plugins.product.drawn_networks import DRAWN
from tests.plugins.product.figures_files import points_of
from tests.plugins.product.test_rough_files import facts


def norms(rows):
    return np.linalg.norm(rows, axis=1)


def length_of(spline):
    return norms(np.diff(spline.sampled(800), axis=0)).sum()


@pytest.mark.parametrize("scale", [1.0, 1000.0])
@pytest.mark.parametrize("name", ["mouse", "mug", "handset"])
def test_open_ones(name, scale):
    """A fit of nearly as many control points as points had hooks of up to 150° at its ends."""
    for curve in DRAWN[name]().built()[0]:
        if curve.spline.closed:
            continue
        row = scale * curve.spline.sampled(25)
        size = np.linalg.norm(np.ptp(row, axis=0))
        for order in (row, row[::-1]):
            spline = spline_through(order, 1e-4 * size, 1e-5 * size)
            slopes = spline.derivative(np.array((0.0, 1.0)))
            chords = np.array((order[1] - order[0], order[-1] - order[-2]))
            assert ((slopes * chords).sum(axis=1) > 0.8 * norms(slopes) * norms(chords)).all()
            assert length_of(spline) < 1.01 * scale * length_of(curve.spline)


@pytest.mark.parametrize("count", [9, 14, 25])
def test_closed_ones(count):
    angles = 2.0 * np.pi * np.arange(count) / count
    radii = 20.0 + np.cos(2 * angles) + 2.0 * np.cos(3 * angles)
    ring = np.column_stack((radii * np.cos(angles), radii * np.sin(angles), 2 * np.sin(2 * angles)))
    spline = closed_spline_through(ring, 1e-7)
    chords = norms(np.diff(np.vstack((ring, ring[:1])), axis=0)).sum()
    assert chords < length_of(spline) < 1.08 * chords


@pytest.mark.parametrize("seed", range(9400, 9412))
def test_rings_of_points_far_and_near(seed):
    """With knots at equal steps one grew to 10⁵ times its length, and others had hooks."""
    random = np.random.default_rng(seed)
    steps = random.exponential(size=random.integers(24, 90)) ** 2
    angles = 2.0 * np.pi * np.cumsum(steps) / steps.sum()
    waves = random.normal(size=(2, 3, 3)) / (1.0, 2.0, 4.0)

    def places(at):
        turns = np.outer(at, (1, 2, 3))
        return 100.0 * (np.cos(turns) @ waves[0].T + np.sin(turns) @ waves[1].T)

    ring = places(angles)
    spline = closed_spline_through(ring, 0.02, 0.002)
    fine = places(np.linspace(0.0, 2.0 * np.pi, 2000))
    assert length_of(spline) < 1.1 * norms(np.diff(fine, axis=0)).sum()
    assert spline.least_distances(ring).max() < 0.021


@pytest.mark.parametrize("share", [0.2, 0.5, 0.7])
@pytest.mark.parametrize("turn", [1e-3, 1.0, np.pi / 2, 2.5, 3.9])
@pytest.mark.parametrize("more", [0, 1, 2, 5])
def test_points_on_an_arc_are_that_arc(turn, share, more):
    axes = 40.0 * np.linalg.qr(np.random.default_rng(7).normal(size=(3, 3)))[0]
    middle = np.array((5.0, -300.0, 70.0))

    def places(at):
        return middle + np.outer(np.cos(at), axes[0]) + np.outer(np.sin(at), axes[1])

    between = np.random.default_rng(more).uniform(0.1, 0.9, more)
    points = places(turn * np.sort([0.0, share, *between, 1.0]))
    spline = spline_through(points, 1e-3)
    np.testing.assert_array_equal(spline.control_points[[0, -1]], points[[0, -1]])
    assert spline.least_distances(places(turn * np.linspace(0.0, 1.0, 100))).max() < 1.1e-3
    assert length_of(spline) == pytest.approx(40.0 * turn, rel=1e-3)


@pytest.mark.parametrize("back", [0.0, 1e-9, 0.5])
def test_three_points_in_line_or_turning_back_bulge_nowhere(back):
    straight = np.array([(0.0, 0.0, 0.0), (3.0, back, 0.0), (10.0, 0.0, 0.0)])
    hairpin = np.array([(0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (0.5, back, 0.0)])
    for points in (straight, hairpin):
        sampled = spline_through(points, 1e-3).sampled(200)
        assert np.abs(sampled[:, 1]).max() <= back + 0.1
        assert -0.5 < sampled[:, 0].min() <= sampled[:, 0].max() < 10.5


@pytest.mark.slow
def test_the_mouse_read_from_points_has_all_its_surfaces():
    state = product_of_network(facts(points_of(DRAWN["mouse"]())))
    result = ProductModeler().solve(state, Job())
    assert len(result.patches) == 15
    assert all(one.fill is not None and not one.creased for one in result.patches)
