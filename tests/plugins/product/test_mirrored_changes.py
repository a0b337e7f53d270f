"""A curve that is its own mirror image stays so when it is drawn over, and when drawn anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline
from bozzetto.ink import distances_to_polyline
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.meetings import splines_of
from bozzetto_product.operations.mirrored_changes import changed_on_both_sides
from bozzetto_product.operations.modify import modify
from bozzetto_product.operations.redraw import redraw_stretch
from bozzetto_product.projection.views import seen_at
from tests.plugins.product.drawn_curves import SHEET, one_stroke

PLANE = Plane((3.0, 0.0, 0.0), (1.0, 0.0, 0.0))
MIRROR = Reflection(PLANE)
SEEDS = (5001, 5002, 5003)


def arch(seed: int) -> Spline:
    """A curve across the plane that is its own image, with knots of its own."""
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 7))
    half = np.column_stack(
        (
            np.linspace(-70.0, -5.0, count),
            random.normal(0, 5.0, count),
            random.uniform(0, 50, count),
        )
    )
    half[:, 0] += 3.0
    points = np.vstack((half, MIRROR.points(half)[::-1]))
    inner = np.sort(random.uniform(0.1, 0.45, (len(points) - 4) // 2))
    middle = [0.5] if (len(points) - 4) % 2 else []
    knots = np.concatenate(([0] * 4, inner, middle, 1.0 - inner[::-1], [1] * 4))
    return Spline(knots, points)


def network(spline: Spline) -> ProductState:
    return ProductState(symmetry=PLANE, nodes=(Curve(id="a", name="a", spline=spline),))


def bulge(spline: Spline, low: float, high: float, way: tuple[float, float]) -> np.ndarray:
    """Ink beside a stretch of a curve, px."""
    at = np.linspace(*spline.range, 301)[int(300 * low) : int(300 * high) + 1]
    spots = seen_at(SHEET, spline.value(at))
    return spots + np.outer(np.sin(np.linspace(0.0, np.pi, len(spots))) ** 2, way)


@pytest.mark.parametrize("change", [modify, redraw_stretch])
@pytest.mark.parametrize("stretch", [(0.05, 0.4), (0.62, 0.92), (0.25, 0.7)])
@pytest.mark.parametrize("seed", SEEDS)
def test_what_one_half_does_the_other_does_as_well(change, stretch, seed) -> None:
    before = arch(seed)
    assert MIRROR.keeps(before)
    ink = bulge(before, *stretch, (4.0, -25.0))
    after = splines_of(change(network(before), [one_stroke(ink)]))["a"]
    assert after is not before
    assert MIRROR.keeps(after)
    points = after.control_points
    np.testing.assert_allclose(MIRROR.points(points)[::-1], points, atol=1e-9)


@pytest.mark.parametrize("change", [modify, redraw_stretch])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_change_of_one_half_is_as_it_would_be_without_the_other(change, seed) -> None:
    before = arch(seed)
    ink = [one_stroke(bulge(before, 0.05, 0.4, (4.0, -25.0)))]
    both = splines_of(change(network(before), ink))["a"]
    away = replace(network(before), symmetry=Plane((0.0, 0.0, 900.0), (0.0, 0.0, 1.0)))
    alone = splines_of(change(away, ink))["a"]
    at = np.linspace(*before.range, 401)
    change_there = np.linalg.norm(alone.value(at) - before.value(at), axis=1) > 1e-9
    # A control point acts over four spans.
    image_near = np.convolve(change_there[::-1], np.ones(41), "same") > 0
    own = change_there & ~image_near
    assert own.sum() > 60
    np.testing.assert_allclose(both.value(at[own]), alone.value(at[own]), atol=1e-9)
    still = ~change_there & ~change_there[::-1]
    np.testing.assert_allclose(both.value(at[still]), before.value(at[still]), atol=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_ink_over_the_middle_is_followed_by_both_halves(seed) -> None:
    """A bulge that is symmetric in space is drawn from the side along the plane's normal."""
    before = arch(seed)
    camera = replace(SHEET, eye=(3.0, -500.0, 20.0), target=(3.0, 0.0, 20.0), up=(0.0, 0.0, 1.0))
    at = np.linspace(0.3, 0.7, 121)
    spots = seen_at(camera, before.value(at))
    ink = spots + np.outer(np.sin(np.linspace(0.0, np.pi, len(at))) ** 2, (0.0, -30.0))
    stroke = replace_camera(one_stroke(ink), camera)
    after = splines_of(modify(network(before), [stroke]))["a"]
    assert MIRROR.keeps(after)
    seen = seen_at(camera, after.sampled(801))
    assert np.percentile(distances_to_polyline(ink[20:-20], seen), 95) < 4.0


def replace_camera(stroke, camera):
    return type(stroke)(stroke.points[:, 0], stroke.points[:, 1], camera)


def test_a_curve_that_is_not_its_own_image_changes_as_it_is_told() -> None:
    before = arch(5001)
    bent = Spline(before.knots, before.control_points + np.eye(len(before.control_points))[:, :3])
    after = Spline(before.knots, before.control_points + 1.0)
    assert changed_on_both_sides(bent, after, PLANE) is after
    assert changed_on_both_sides(before, before, PLANE) is before


def test_a_symmetric_change_stays_what_it_is() -> None:
    before = arch(5002).refined([0.2, 0.8, 0.35])
    shift = np.linspace(-1.0, 1.0, len(before.control_points)) ** 2
    moved = before.control_points + np.outer(1.0 - shift, (0.0, 3.0, 8.0))
    even = MIRROR.symmetric(Spline(arch(5002).knots, arch(5002).control_points * (1, 1, 1.2)))
    after = changed_on_both_sides(arch(5002), even, PLANE)
    np.testing.assert_allclose(after.control_points, even.control_points, atol=1e-9)
    twice = changed_on_both_sides(before, Spline(before.knots, moved), PLANE)
    assert MIRROR.keeps(twice)
