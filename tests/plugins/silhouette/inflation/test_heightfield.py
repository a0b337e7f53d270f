"""The relief: swollen solids as functions of space, against closed forms and dense samples."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from bozzetto_silhouette.implicit.implicit_solid import Placed
from bozzetto_silhouette.solids.body import Body
from tests.plugins.silhouette import bodies as b
from tests.plugins.silhouette import outlines as o

RANDOM = np.random.default_rng(5)


@pytest.fixture(scope="module")
def ball() -> Body:
    return b.ball(resolution=64)


@pytest.fixture(scope="module")
def hand() -> Body:
    return b.body(o.outline("hand-paper"), 64)


def around(body: Body, count: int, margin: float = 0.3) -> np.ndarray:
    low, high = body.bounds
    wide = margin * np.ptp(body.bounds, axis=0).max()
    return RANDOM.uniform(low - wide, high + wide, (count, 3))


def spread(body: Body, count: int) -> np.ndarray:
    """Points strewn evenly over the surface of a body."""
    corners = body.vertices[body.faces]
    sides = corners[:, 1:] - corners[:, :1]
    areas = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    face = RANDOM.choice(len(areas), count, p=areas / areas.sum())
    weights = RANDOM.dirichlet(np.ones(3), count)
    return np.einsum("nk,nkd->nd", weights, corners[face])


def test_a_ball_has_the_distance_of_a_ball(ball: Body) -> None:
    points = around(ball, 4000, 0.1)
    exact = 50.0 - np.linalg.norm(points, axis=1)
    near = np.abs(exact) < 15.0
    assert ball.implicit.value(points[near]) == pytest.approx(exact[near], abs=0.75)
    inward = -points / np.linalg.norm(points, axis=1)[:, None]
    cosine = (ball.implicit.sample(points).gradient * inward).sum(axis=1)
    assert cosine[near].min() > 0.999


@pytest.mark.parametrize("name", ["hand-paper", "key", "horse_skimage"])
def test_zero_on_the_mesh_and_steep_across_it(name: str) -> None:
    body = b.body(o.outline(name), 64)
    value, gradient, _ = body.implicit.sample(body.vertices)
    size = np.ptp(body.vertices, axis=0).max()
    assert np.quantile(np.abs(value), 0.98) < 0.25 * body.step
    steep = -(gradient * body.normals).sum(axis=1)
    # The horse's outline is made of the stairs of pixels, which have no direction.
    assert name == "horse_skimage" or np.quantile(steep, 0.02) > 0.98
    step = 0.01 * size
    assert np.mean(body.implicit.value(body.vertices + step * body.normals) < 0.0) > 0.98


def test_close_to_the_distance_outside(hand: Body) -> None:
    points = around(hand, 4000)
    distance = cKDTree(spread(hand, 200_000)).query(points)[0]
    value = hand.implicit.value(points)
    size = np.ptp(hand.vertices, axis=0).max()
    outside = (value < 0.0) & (distance > 0.01 * size)
    ratio = -value[outside] / distance[outside]
    assert np.quantile(ratio, 0.01) > 0.5
    assert np.quantile(ratio, 0.99) < 2.5
    close = outside & (distance < 0.05 * size)
    assert np.median(-value[close] / distance[close]) == pytest.approx(1.0, abs=0.05)


def test_falls_on_the_way_to_infinity(hand: Body) -> None:
    way = np.array([0.3, -0.5, 0.8]) * np.geomspace(200.0, 1e9, 60)[:, None]
    value, gradient, _ = hand.implicit.sample(way)
    assert (np.diff(value) < 0.0).all()
    assert np.isfinite(gradient).all()
    assert -value[-1] == pytest.approx(np.linalg.norm(way[-1]), rel=0.5)


def test_placed_it_is_the_same_solid(hand: Body) -> None:
    placement = b.turn("y", 40.0, (10.0, -20.0, 5.0))
    moved = Placed(hand.implicit, placement)
    points = around(hand, 500)
    assert moved.value(placement.points(points)) == pytest.approx(hand.implicit.value(points))


def test_front_and_back_are_alike_where_they_are(hand: Body) -> None:
    points = around(hand, 500)
    mirrored = points * [1.0, 1.0, -1.0]
    assert np.array_equal(hand.implicit.value(points), hand.implicit.value(mirrored))
