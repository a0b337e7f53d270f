"""Rubbing along an outline: what goes, what stays, and how strongly."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.ink.curves.closing import signed_area
from bozzetto.ink.curves.resample import resample
from bozzetto.plugin import Context, Ink
from bozzetto.testing import Pen
from bozzetto.view import Camera
from bozzetto_silhouette.ink.ring_smoothing import rubbed, rubbed_ring, softened
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.placements import drawn_rings
from bozzetto_silhouette.tools.outline_edits import Smooth
from tests.plugins.silhouette import outlines
from tests.previews import preview_of

TURN = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
SQUARE = np.array([(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)])


def wavy(waves: int, share: float, radius: float = 50.0) -> np.ndarray:
    return radius * (1 + share * np.sin(waves * TURN))[:, None] * unit(TURN)


def unit(angle) -> np.ndarray:
    return np.column_stack([np.cos(angle), np.sin(angle)])


def ripple(ring, waves: int, where) -> float:
    """Amplitude of a ripple over a stretch, as a share of the radius, by least squares."""
    angle = np.arctan2(ring[:, 1], ring[:, 0]) % (2 * np.pi)
    inside = (angle > where[0]) & (angle < where[1])
    angle, radius = angle[inside], np.hypot(*ring[inside].T) / 50.0
    design = np.column_stack([np.ones_like(angle), angle, np.sin(waves * angle),
                              np.cos(waves * angle)])  # fmt: skip
    return float(np.hypot(*np.linalg.lstsq(design, radius, rcond=None)[0][2:]))


def sharpest(ring, about, within) -> float:
    """Largest turn over a step of 2 near a place, degrees."""
    fine = resample(ring, spacing=2.0, closed=True)
    step = np.roll(fine, -1, axis=0) - fine
    before = np.roll(step, 1, axis=0)
    turn = np.arctan2(before[:, 0] * step[:, 1] - before[:, 1] * step[:, 0],
                      (before * step).sum(axis=1))  # fmt: skip
    near = np.hypot(*(fine - about).T) < within
    return float(np.degrees(np.abs(turn[near]).max()))


def test_a_circle_does_not_shrink_however_often_it_is_rubbed() -> None:
    ring = wavy(0, 0.0)
    for _ in range(20):
        ring = rubbed(ring, 50.0 * unit(np.linspace(0, 2 * np.pi, 300)), 100.0)
    assert np.hypot(*ring.T) == pytest.approx(np.full(len(ring), 50.0), rel=1e-3)


def test_ripples_go_under_the_stroke_and_only_there() -> None:
    ring = wavy(60, 0.02)
    rub = 50.0 * unit(np.linspace(0.4, 2.4, 200))
    soft = rubbed(ring, rub, 100.0)
    assert ripple(soft, 60, (0.7, 2.1)) < 0.25 * 0.02
    assert ripple(soft, 60, (3.0, 6.0)) == pytest.approx(0.02, rel=0.01)
    away = shapely.distance(shapely.LineString(rub), shapely.points(ring)) > 15.0
    kept = {tuple(point) for point in soft.tolist()}
    assert all(tuple(point) in kept for point in ring[away].tolist())
    assert shapely.Polygon(soft).is_valid


def test_a_corner_goes_the_others_stay_and_the_area_with_them() -> None:
    rub = np.array([(30.0, 50.0), (50.0, 50.0), (50.0, 30.0)])
    soft = rubbed(SQUARE, rub, 100.0)
    assert sharpest(soft, (50, 50), 12) < 45.0
    for corner in [(-50, 50), (-50, -50), (50, -50)]:
        assert sharpest(soft, corner, 6) > 60.0
        assert np.hypot(*(soft - corner).T).min() < 1e-9
    assert signed_area(soft) == pytest.approx(100.0**2, rel=5e-3)


def test_broader_and_more_often_is_more() -> None:
    ring = wavy(30, 0.03)
    angle = np.linspace(0.4, 2.4, 600)
    once = 50.0 * unit(angle)
    thrice = np.concatenate([once, once[::-1], once])
    broad = (50.0 + 4.0 * np.sin(40 * angle))[:, None] * unit(angle)
    left = [ripple(rubbed(ring, line, 100.0), 30, (0.7, 2.1)) for line in (once, thrice, broad)]
    assert left[1] < 0.8 * left[0]
    assert left[2] < 0.8 * left[0]
    again = rubbed(rubbed(ring, once, 100.0), once, 100.0)
    assert ripple(again, 30, (0.7, 2.1)) < 0.9 * left[0]


def test_direction_start_and_scale_do_not_matter() -> None:
    ring, line = wavy(60, 0.02), 50.0 * unit(np.linspace(0.4, 2.4, 200))
    expected = shapely.Polygon(rubbed(ring, line, 100.0))

    def differ(other) -> float:
        return float(expected.symmetric_difference(shapely.Polygon(other)).area / expected.area)

    assert differ(rubbed(ring, line[::-1], 100.0)) < 1e-3
    assert differ(rubbed(ring[::-1], line, 100.0)) < 1e-3
    assert differ(rubbed(np.roll(ring, 200, axis=0), line, 100.0)) < 1e-3
    far = rubbed(1e3 * (ring + 1e3), 1e3 * (line + 1e3), 1e5)
    assert differ(far / 1e3 - 1e3) < 1e-5


def test_the_wall_that_is_rubbed_is_smoothed_not_the_one_behind_it() -> None:
    x = np.linspace(-50.0, 50.0, 400)
    wall = 1.5 + 0.3 * np.sin(2.0 * x)
    ring = np.vstack([np.column_stack([x, -wall]), np.column_stack([x, wall])[::-1]])
    soft = rubbed(ring, np.array([(-30.0, 2.0), (30.0, 2.0)]), 100.0)
    middle = soft[np.abs(soft[:, 0]) < 20.0]
    upper, lower = middle[middle[:, 1] > 0.0], middle[middle[:, 1] < 0.0]
    assert upper[:, 1].std() < 0.1
    assert lower[:, 1].std() > 0.19


def test_the_whole_ring_filtered_is_the_filter() -> None:
    """Against the transfer function of 2 G - G² on a single wave, known in closed form."""
    count, radius, sigma, waves = 4096, 50.0, 2.0, 20
    angle = 2 * np.pi * np.arange(count) / count
    ring = (radius + 1e-3 * np.sin(waves * angle))[:, None] * unit(angle)
    soft = softened(ring, np.ones(count, bool), sigma)
    # A radial wave of m periods is waves of m - 1 and m + 1 periods in x and y.
    gauss = [np.exp(-0.5 * (sigma * m / radius) ** 2) for m in (waves - 1, waves + 1, 1)]
    passed = [g * (2 - g) for g in gauss]
    expected = 1e-3 * 0.5 * (passed[0] + passed[1])
    heights = np.hypot(*soft.T) - radius * passed[2]
    assert 2 * np.mean(heights * np.sin(waves * angle)) == pytest.approx(expected, rel=1e-3)


def test_the_ring_that_is_meant_and_none() -> None:
    rings = (wavy(0, 0.0), outlines.circle(0, 0, 20), None)
    assert rubbed_ring(rings, 49.0 * unit(np.linspace(0, 1, 50)), 100.0) == 0
    assert rubbed_ring(rings, 21.0 * unit(np.linspace(0, 1, 50)), 100.0) == 1
    with pytest.raises(UserError, match="no outline under the stroke"):
        rubbed_ring(rings, 35.0 * unit(np.linspace(0, 1, 50)), 100.0)
    with pytest.raises(UserError, match="no outline under the stroke"):
        rubbed_ring((None,), 35.0 * unit(np.linspace(0, 1, 50)), 100.0)


def test_the_tool_smooths_a_part_where_it_stands() -> None:
    pose = Placement((-1.0, 0, 0, 0, 1, 0, 0, 0, 1), 1.3, (10.0, 0.0, 5.0))
    ink = Pen().polygon((400, 300), (800, 300), (800, 600), (400, 600))
    state = SilhouetteState(nodes=(Part(id="n1", strokes=Strokes([ink]), pose=pose),))
    camera = Camera()
    corners, _ = camera.project(drawn_rings(state, state.parts[0])[0])
    corner = corners[np.argmin(corners.sum(axis=1))]
    rub = Pen(camera).along(corner + np.array([(80, 0), (0, 0), (0, 80)]))
    after = Smooth().apply(state, Ink((rub,), True), Context())
    ring, _ = camera.project(drawn_rings(after, after.parts[0])[0])
    assert np.hypot(*(ring - corner).T).min() > 3.0
    gaps = [np.hypot(*(ring - other).T).min() for other in corners]
    assert sorted(gap < 1.0 for gap in gaps).count(False) <= len(corners) // 4 + 1
    assert outline_of(after.parts[0]).area == pytest.approx(
        outline_of(state.parts[0]).area, rel=5e-3
    )
    (lines,) = [item for _, item in preview_of(Smooth(), state, Ink((rub,)), Context()).items()]
    assert np.isfinite(lines.points).all()


@pytest.mark.parametrize("name", ["snowflake", "hand-paper", "spider", "mosquito", "key"])
def test_real_outlines_stay_sound_when_all_of_them_is_rubbed(name: str) -> None:
    outline = outlines.outline(name)
    size = outline.size
    for ring in outline.rings:
        line = np.vstack([ring, ring[:1]])
        soft = rubbed(ring, line, size)
        assert np.isfinite(soft).all()
        assert abs(signed_area(soft)) == pytest.approx(abs(signed_area(ring)), rel=0.06)
