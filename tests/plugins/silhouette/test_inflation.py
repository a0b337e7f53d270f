"""Membranes: closed forms, bodies of different size, and the shape under the pen."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_silhouette.analysis.fidelity import measure
from bozzetto_silhouette.inflation.live_preview import inflate
from bozzetto_silhouette.inflation.membrane import Membrane, MembraneHeights
from bozzetto_silhouette.inflation.solidify import solidify
from bozzetto_silhouette.outline.boundary_sampling import sample_rim
from bozzetto_silhouette.outline.domain_mesh import plan_of
from bozzetto_silhouette.outline.outline import outline_from_rings
from bozzetto_silhouette.outline.signed_distance import RimDistance
from tests.plugins.silhouette import outlines as o

INFLATION = MembraneHeights()


def test_an_ellipse_becomes_an_ellipsoid_in_closed_form() -> None:
    # -laplace(u) = 1 on x^2/a^2 + y^2/b^2 < 1 is solved by a multiple of 1 - x^2/a^2 - y^2/b^2.
    ring = o.circle(0, 0, 1, 400) * [50.0, 20.0]
    solid = solidify(outline_from_rings([ring]), height_model=INFLATION)
    x, y, z = solid.vertices.T
    exact = np.maximum(20.0**2 * (1.0 - (x / 50) ** 2 - (y / 20) ** 2), 0.0)
    assert z**2 == pytest.approx(exact, abs=0.01 * 20.0**2)


def test_every_body_is_as_thick_as_its_own_inscribed_ball() -> None:
    rings = [o.circle(-50, 0, 40, 200), o.circle(50, 0, 10, 100), o.circle(90, 0, 3, 80)]
    solid = solidify(outline_from_rings(rings), height_model=INFLATION)
    assert solid.soundness.ok
    # The smallest is five cells wide: its mesh is a polyhedron.
    for x, radius, coarse in ((-50, 40.0, 0.01), (50, 10.0, 0.01), (90, 3.0, 0.04)):
        near = np.abs(solid.vertices[:, 0] - x) < radius
        assert solid.vertices[near, 2].max() == pytest.approx(radius, rel=coarse)


@pytest.mark.parametrize("name", ["key", "spider", "dice-five", "spiral", "mosquito"])
def test_it_keeps_the_outline(name: str) -> None:
    found = measure(solidify(o.outline(name), height_model=INFLATION, resolution=64))
    assert found.topology_ok
    assert found.iou > 0.997
    assert 0.85 < found.thickness_ratio < 1.1


def _round(ring: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    rim = sample_rim((ring,), step, 0.3 * step)
    plan = plan_of(rim, np.zeros((0, 2)), step)
    closest = RimDistance(rim.points, rim.after)(plan.points[len(plan.after) :])
    square = Membrane.of(plan).round(closest.distance, rim.radius[closest.segment])
    return plan.points, np.sqrt(square)


def test_the_shape_under_the_pen_is_round_on_balls_and_on_tubes() -> None:
    points, height = _round(o.circle(0, 0, 0.5, 200), 0.04)
    middle = np.hypot(*points.T) < 0.3
    exact = np.sqrt(0.25 - (points[middle] ** 2).sum(axis=1))
    assert height[middle] == pytest.approx(exact, rel=0.05)
    bar = np.array([[-0.5, -0.08], [0.5, -0.08], [0.5, 0.08], [-0.5, 0.08]])
    points, height = _round(bar, 0.04)
    middle = (np.abs(points[:, 0]) < 0.25) & (np.abs(points[:, 1]) < 0.05)
    exact = np.sqrt(0.08**2 - points[middle, 1] ** 2)
    assert height[middle] == pytest.approx(exact, rel=0.05)


@pytest.mark.parametrize("scale", [2.0**-10, 2.0**13])
def test_the_shape_under_the_pen_scales_with_the_drawing(scale: float) -> None:
    ring = o.svg_rings(o.COMMITTED / "hand-paper.svg")[0]
    here, there = inflate(ring), inflate(scale * ring)
    assert here is not None
    assert there is not None
    assert there.vertices == pytest.approx(scale * here.vertices, rel=1e-6, abs=1e-6 * scale)
    assert np.isfinite(there.normals).all()


def test_the_shape_under_the_pen_is_near_the_final_one() -> None:
    ring = o.svg_rings(o.COMMITTED / "leaf.svg")[0]
    shown = inflate(ring)
    assert shown is not None
    solid = solidify(outline_from_rings([ring]), resolution=64)
    assert shown.vertices[:, 2].max() == pytest.approx(solid.vertices[:, 2].max(), rel=0.1)
