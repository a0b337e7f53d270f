"""No ripples: laws of the fairing and of the normals, and the measure on outlines."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_silhouette.inflation.closed_surface import shell_normals
from bozzetto_silhouette.inflation.height_fairing import faired
from bozzetto_silhouette.inflation.solidify import SilhouetteSolid, solidify
from bozzetto_silhouette.outline.boundary_sampling import sample_rim
from bozzetto_silhouette.outline.domain_mesh import Plan, plan_of
from bozzetto_silhouette.outline.fem import Elements
from bozzetto_silhouette.outline.outline import outline_from_rings
from bozzetto_silhouette.outline.signed_distance import RimDistance
from tests.plugins.silhouette import outlines as o
from tests.plugins.silhouette.fairness import front, unfairness

BALL = 0.0185
"""Unfairness of a ball, with a tenth to spare for another mesh."""


def _plan(*rings: np.ndarray, step: float = 0.02) -> Plan:
    rim = sample_rim(rings, step, 0.2 * step)
    return plan_of(rim, np.zeros((0, 2)), step)


@pytest.fixture(scope="module")
def disc() -> Plan:
    return _plan(o.circle(0, 0, 0.5, 240))


@pytest.fixture(scope="module")
def bar() -> Plan:
    return _plan(np.array([[-0.5, -0.12], [0.5, -0.12], [0.5, 0.12], [-0.5, 0.12]]))


def _depth(plan: Plan) -> np.ndarray:
    """Distance of the inner points from the outline."""
    rim = len(plan.after)
    return RimDistance(plan.points[:rim], plan.after)(plan.points[rim:]).distance


def _finger(half: float) -> np.ndarray:
    """A strip of half width 1 with round ends, along x."""
    angle = np.linspace(-0.5, 0.5, 40) * np.pi
    cap = np.column_stack([half + np.cos(angle), np.sin(angle)])
    return np.concatenate([cap, -cap])


def test_stiffness_and_mass_integrate_exactly(bar: Plan) -> None:
    elements = Elements.of(bar)
    x, y = bar.points.T
    assert elements.mass.sum() == pytest.approx(0.24, rel=1e-9)
    energy = (2 * x + 3 * y) @ (elements.stiffness() @ (2 * x + 3 * y))
    assert energy == pytest.approx(13 * 0.24, rel=1e-9)
    assert np.abs(elements.stiffness() @ np.ones(len(x))).max() < 1e-9


def test_a_ball_passes_unchanged(disc: Plan) -> None:
    square = np.maximum(0.25 - (disc.points**2).sum(axis=1), 0.0)
    square[: len(disc.after)] = 0.0
    inner = np.arange(len(square)) >= len(disc.after)
    calm = faired(disc, square, _depth(disc))
    assert np.sqrt(calm[inner]) == pytest.approx(np.sqrt(square[inner]), rel=0.01)
    assert (calm[~inner] == 0.0).all()


def test_a_tube_with_round_ends_passes_unchanged() -> None:
    plan = _plan(0.12 * _finger(3.0))
    x, y = plan.points.T / 0.12
    square = 0.12**2 * np.maximum(1.0 - np.maximum(np.abs(x) - 3.0, 0.0) ** 2 - y**2, 0.0)
    square[: len(plan.after)] = 0.0
    inner = np.arange(len(square)) >= len(plan.after)
    assert np.sqrt(faired(plan, square, _depth(plan))[inner]) == pytest.approx(
        np.sqrt(square[inner]), rel=0.025
    )


def test_ripples_go_and_the_height_stays(disc: Plan) -> None:
    x, y = disc.points.T
    ball = np.maximum(0.25 - x**2 - y**2, 0.0)
    ripple = 1.0 + 0.02 * np.sin(90.0 * x) * np.sin(90.0 * y)
    inner = np.hypot(x, y) < 0.4
    before = np.sqrt(ball * ripple)[inner] / np.sqrt(ball[inner]) - 1.0
    after = np.sqrt(faired(disc, ball * ripple, _depth(disc)))[inner] / np.sqrt(ball[inner]) - 1.0
    assert np.abs(before).max() > 0.009
    assert np.abs(after).max() < 0.25 * np.abs(before).max()


def test_heights_stay_positive_whatever_the_pressure(disc: Plan) -> None:
    random = np.random.default_rng(7)
    square = np.where(np.arange(len(disc.points)) < len(disc.after), 0.0, 0.01)
    calm = faired(disc, square * random.uniform(1e-3, 100.0, len(square)), _depth(disc))
    assert np.isfinite(calm).all()
    assert (calm[len(disc.after) :] > 0).all()


def test_normals_are_exact_on_any_quadric_height(bar: Plan) -> None:
    x, y = bar.points.T
    square = 0.3 + 0.2 * x - 0.1 * y - 0.4 * x * x + 0.3 * x * y - 0.2 * y * y
    exact = np.stack(
        [0.4 * 2 * x - 0.2 - 0.3 * y, 0.1 - 0.3 * x + 0.2 * 2 * y, 2 * np.sqrt(square)], axis=1
    )
    exact /= np.linalg.norm(exact, axis=1)[:, None]
    found = shell_normals(bar, square, square)
    inner = np.flatnonzero(np.arange(len(x)) >= len(bar.after))
    assert found[inner] == pytest.approx(exact[inner], abs=2e-3)
    assert np.median(np.abs(found[inner] - exact[inner])) < 1e-4
    assert found[len(x) :] == pytest.approx(found[inner] * [1, 1, -1])


def test_normals_follow_the_inflation(disc: Plan) -> None:
    square = np.maximum(0.25 - (disc.points**2).sum(axis=1), 0.0)
    square[: len(disc.after)] = 0.0
    inner = np.arange(len(square)) >= len(disc.after)
    # An ellipsoid of depth k r: its normal is (x, y, z / k^2) of its points (x, y, z).
    for k in (0.4, 2.5):
        exact = np.column_stack([disc.points, np.sqrt(square) / k])
        exact /= np.linalg.norm(exact, axis=1)[:, None]
        found = shell_normals(disc, square * k**2, square * k**2)[: len(square)]
        assert found[inner] == pytest.approx(exact[inner], abs=0.02)


def test_a_ball_is_as_calm_as_can_be() -> None:
    assert unfairness(solidify(outline_from_rings([o.circle(0, 0, 50, 300)]))) < BALL


@pytest.mark.parametrize(
    ("name", "most"),
    [("heart", 1.3), ("key", 1.3), ("spider", 1.9)],
)
def test_no_ripples(name: str, most: float) -> None:
    assert unfairness(solidify(o.outline(name))) < most * BALL


def test_fingers_have_no_beads() -> None:
    finger = 10.0 * _finger(9.0)
    for turn in (0.0, 0.7):
        c, s = np.cos(turn), np.sin(turn)
        solid = solidify(outline_from_rings([finger @ np.array([[c, s], [-s, c]])]))
        axis = np.linspace(-80.0, 80.0, 200)[:, None] * np.array([c, s])
        height = front(solid)(axis)[:, 0]
        assert height == pytest.approx(np.full(200, 10.0), rel=0.02)
        assert height.std() < 0.05


def _mirrored(solid: SilhouetteSolid, twin: SilhouetteSolid) -> tuple[float, float]:
    """Root mean squares of the differences of heights (over the largest) and normals."""
    import shapely

    low, high = solid.outline.bounds
    place = np.random.default_rng(1).uniform(low, high, (2000, 2))
    inside = solid.outline.polygon().buffer(-0.03 * solid.outline.size)
    place = place[shapely.contains_xy(inside, place[:, 0], place[:, 1])]
    here = front(solid)
    there = here if twin is solid else front(twin)
    apart = here(place) - there(place * [-1, 1]) * [1, -1, 1, 1]
    square = np.nanmean(apart**2, axis=0)
    return (
        float(np.sqrt(square[0]) / np.abs(solid.vertices[:, 2]).max()),
        float(np.sqrt(square[1:].sum())),
    )


@pytest.mark.parametrize("name", ["heart", "hand-paper"])
def test_a_mirrored_drawing_gives_the_mirrored_shape(name: str) -> None:
    drawn = o.outline(name)
    twin = outline_from_rings([ring * [-1, 1] for ring in drawn.rings])
    height, normal = _mirrored(solidify(drawn), solidify(twin))
    assert height < 2e-3
    assert normal < 8e-3


def test_a_symmetric_drawing_gives_a_symmetric_shape() -> None:
    rings = o.svg_rings(o.COMMITTED / "heart.svg")
    middle = 0.5 * (rings[0][:, 0].min() + rings[0][:, 0].max())
    solid = solidify(outline_from_rings([ring - [middle, 0.0] for ring in rings]))
    height, normal = _mirrored(solid, solid)
    assert height < 2e-3
    assert normal < 8e-3
