"""Knots that are idle, taken out of what goes to CAD: the shape stays, corners stay."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline, insert

from bozzetto.exchange.cad.knot_removal import without_idle_knots
from bozzetto.exchange.cad.step import write_shapes as step
from bozzetto.geometry import Brep, BSplineSurface, Shapes
from tests.core.exchange.curve_kit import Step


def refined(knots, points, degree):
    """A curve with every inner knot as often as the degree, by SciPy: the same curve."""
    spline = BSpline(knots, points, degree)
    for x in np.unique(knots)[1:-1]:
        times = degree - int((spline.t == x).sum())
        if times:
            spline = insert(x, spline, m=times)
    return spline.t, spline.c[: len(spline.t) - degree - 1]


def sheet(seed, degree=3, spans=4):
    """A wavy sheet in pieces, of a random spline whose inner knots are simple; its own knots."""
    random = np.random.default_rng(seed)
    inner = np.sort(random.uniform(0.1, 0.9, spans - 1))
    knots = np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])
    count = len(knots) - degree - 1
    x, y = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    net = np.stack([10.0 * x, 10.0 * y, random.normal(scale=4.0, size=x.shape)], axis=2)
    fine_u, rows = refined(knots, net, degree)
    fine_v, columns = refined(knots, np.swapaxes(rows, 0, 1), degree)
    return BSplineSurface((degree, degree), fine_u, fine_v, np.swapaxes(columns, 0, 1)), knots


def body(surface):
    """A brep of one face within its own border."""
    return Brep.of_surface(surface, "sheet")


@pytest.mark.parametrize("degree", [2, 3, 5])
@pytest.mark.parametrize("seed", range(3))
def test_a_smooth_sheet_in_pieces_is_the_same_sheet_without_corners(seed, degree):
    surface, _ = sheet(seed, degree)
    brep = body(surface)
    found = without_idle_knots(brep)
    smooth = found.faces[0].surface
    for knots in smooth.knots:
        _, count = np.unique(knots[degree + 1 : -degree - 1], return_counts=True)
        assert (count == degree - 1).all()
    u, v = np.random.default_rng(9).uniform(size=(2, 300))
    np.testing.assert_allclose(smooth.value(u, v), surface.value(u, v), atol=1e-8)
    for one, other in zip(found.edges, brep.edges, strict=True):
        assert len(one.control_points) <= len(other.control_points)


def test_a_corner_stays():
    surface, _ = sheet(1)
    net = np.array(surface.control_points)
    net[3] += (0.0, 0.0, 1e-4)  # the row on the first inner knot
    bent = BSplineSurface(surface.degrees, *surface.knots, net)
    smooth = without_idle_knots(body(bent)).faces[0].surface
    _, count = np.unique(smooth.knots_u[4:-4], return_counts=True)
    assert count.tolist() == [3, 2, 2]
    u, v = np.random.default_rng(9).uniform(size=(2, 300))
    np.testing.assert_allclose(smooth.value(u, v), bent.value(u, v), atol=1e-8)


def test_what_has_no_idle_knot_is_the_very_same():
    flat = BSplineSurface((1, 1), [0, 0, 1, 1], [0, 0, 1, 1], [[[0, 0, 0], [0, 9, 0]],
                                                               [[9, 0, 0], [9, 9, 0]]])  # fmt: skip
    brep = body(flat)
    assert without_idle_knots(brep) is brep


def test_the_file_has_them_no_more():
    surface, _ = sheet(2)
    text = step(Shapes(breps=(body(surface),)))
    assert b"B_SPLINE_SURFACE_WITH_KNOTS" in text
    assert b"(4,3,3,3,4)" not in text
    assert b"(4,2,2,2,4)" in text
    assert Step(text) is not None
