"""Styling curves between their places, and as splines for other programs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import BSpline

from bozzetto.geometry import Curve
from bozzetto.geometry.patches.patch import points_at
from bozzetto_car.body.body import Body
from bozzetto_car.body.build import body_of
from bozzetto_car.state import CarState, StylingCurve
from bozzetto_car.styling.curve_fit import as_curves, spline_of
from bozzetto_car.template.loader import PAPER_TEMPLATES
from tests.plugins.car.styled_body import (
    ABOVE,
    curve_points,
    dense,
    off_surface,
    styled,
    template_body,
    whole,
)
from tests.plugins.car.traced_car import view

Array = NDArray[np.float64]


def curves_of(body: Body) -> list[StylingCurve]:
    """Along the side; over the middle; over the crease below the windscreen."""
    return [
        styled(body),
        styled(body, ABOVE, [[700, 600, 900], [500, 0, 900], [700, -600, 900]]),
        styled(body, ABOVE, [[500, 550, 800], [900, 300, 900], [1500, 250, 1000]]),
    ]


def on(curve: Curve, count: int = 400) -> Array:
    """Places of a curve that was handed over, by scipy."""
    spline = BSpline(curve.knots, curve.control_points, curve.degree)
    ends = curve.knots[curve.degree], curve.knots[-curve.degree - 1]
    return np.asarray(spline(np.linspace(*ends, count)))


def test_it_goes_through_its_places() -> None:
    body = template_body()
    for curve in curves_of(body):
        course = whole(curve, body)
        places = course.places(course.along)
        own = curve_points(curve, body.nets, body.template)
        assert np.abs(points_at(body.nets, places) - own).max() < 1e-6


def test_it_has_no_kinks_between_its_places() -> None:
    body = template_body()
    points = dense(styled(body), body, 800)
    way = np.diff(points, axis=0)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    turn = np.degrees(np.arccos(np.clip((way[1:] * way[:-1]).sum(axis=1), -1.0, 1.0)))
    assert turn.max() < 0.3


@pytest.mark.parametrize("name", PAPER_TEMPLATES)
def test_the_spline_is_on_the_body(name: str) -> None:
    body = template_body(name)
    for curve in curves_of(body):
        handed = as_curves(curve, body.nets, body.template)[0]
        assert off_surface(on(handed), body).max() < 0.01
        assert np.abs(on(handed)[[0, -1]] - dense(curve, body, 2)).max() < 1e-6
        knots = np.unique(handed.knots)
        spline = BSpline(handed.knots, handed.control_points, 3)
        # Not-a-knot ends leave the second and the last but one place without a knot.
        assert off_surface(spline(knots), body).max() < 1e-6


def test_few_control_points_tell_a_smooth_line() -> None:
    body = template_body()
    curve = styled(body)
    (one, _) = as_curves(curve, body.nets, body.template)
    assert len(one.control_points) < 80 < len(curve.on)


def test_curvature_is_continuous_but_for_corners_on_creases() -> None:
    body = template_body()
    smooth, _, bent = (spline_of(body.nets, whole(c, body)) for c in curves_of(body))
    inner = [np.unique(s.knots[4:-4], return_counts=True)[1].max() for s in (smooth, bent)]
    assert inner == [1, 3]


def test_the_mirror_image_comes_with_it_where_it_is_on_both_sides() -> None:
    body = template_body()
    curve = replace(styled(body), name="Shoulder", color=(10, 20, 30))
    one, other = as_curves(curve, body.nets, body.template)
    assert (one.name, other.name) == ("Shoulder", "Shoulder mirrored")
    assert one.color == other.color == (10, 20, 30)
    assert np.array_equal(one.control_points * [1.0, -1.0, 1.0], other.control_points)
    assert np.array_equal(one.knots, other.knots)
    assert len(as_curves(replace(curve, both=False), body.nets, body.template)) == 1


def test_it_is_handed_over_in_parts_where_the_body_lacks_patches() -> None:
    sedan, hatchback = template_body(), template_body("hatchback")
    curve = styled(sedan, view(40.0, 45.0), [[700, 300, 900], [2200, 350, 1440], [3900, 400, 1050]])
    handed = as_curves(curve, hatchback.nets, hatchback.template)
    assert handed
    for part in handed:
        assert off_surface(on(part, 60), hatchback).max() < 0.01
    assert as_curves(StylingCurve("n2", "Empty"), sedan.nets, sedan.template) == ()


def test_it_is_on_a_body_of_other_dimensions() -> None:
    curve = styled(template_body())
    body = body_of(CarState(length=5300.0, height=1350.0))
    assert off_surface(on(as_curves(curve, body.nets, body.template)[0]), body).max() < 0.01
