"""Both rules of the skeleton: laws of circles, of balls, and of what is dropped."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import shapely

from bozzetto.errors import UserError
from bozzetto_silhouette.numerics.triangle_circles import circumcircles, covered_share, incircles
from bozzetto_silhouette.outline.medial_axis import Skeleton
from bozzetto_silhouette.outline.normalized import MOST_NODES, SkeletonRule, frame_of
from bozzetto_silhouette.outline.outline import Outline, outline_from_rings
from bozzetto_silhouette.outline.sketchco_skeleton import paper_skeleton
from tests.plugins.silhouette import outlines as o

RULES: list[SkeletonRule] = ["exact", "paper"]


def _triangles(count: int) -> np.ndarray:
    return np.random.default_rng(2).normal(size=(count, 3, 2))


def test_circumcircles_go_through_the_corners() -> None:
    corners = _triangles(200)
    centre, radius = circumcircles(corners)
    away = np.linalg.norm(corners - centre[:, None], axis=2)
    assert away == pytest.approx(np.tile(radius[:, None], 3), rel=1e-7)


def test_incircles_touch_the_sides_from_within() -> None:
    corners = _triangles(200)
    centre, radius = incircles(corners)
    for triangle, middle, r in zip(corners, centre, radius, strict=True):
        shape = shapely.Polygon(triangle)
        assert shapely.contains_xy(shape, *middle)
        for k in range(3):
            side = shapely.LineString([triangle[k], triangle[(k + 1) % 3]])
            assert side.distance(shapely.Point(middle)) == pytest.approx(r, rel=1e-7, abs=1e-9)


def test_triangles_without_area_do_no_harm() -> None:
    flat = np.array([[[0, 0], [1, 1], [3, 3]], [[2, 1], [2, 1], [2, 1]]], float)
    assert np.isinf(circumcircles(flat)[1]).all()
    centre, radius = incircles(flat)
    assert np.isfinite(centre).all()
    assert (radius == 0).all()


def test_covered_share_against_polygons() -> None:
    random = np.random.default_rng(8)
    gap, radius, other = random.uniform(0.01, 2.0, (3, 60))
    found = covered_share(gap, radius, other)
    for k in range(60):
        disc = shapely.Point(0, 0).buffer(radius[k], 400)
        cover = shapely.Point(gap[k], 0).buffer(other[k], 400)
        assert found[k] == pytest.approx(disc.intersection(cover).area / disc.area, abs=1e-4)


def _in_object_frame(name: str, rule: SkeletonRule, change: Callable = lambda r: r) -> Skeleton:
    rings = [change(ring) for ring in o.svg_rings(o.COMMITTED / f"{name}.svg")]
    frame = frame_of(outline_from_rings(rings), rule)
    return frame.skeleton.transformed(frame.scale, frame.origin)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", ["key", "spider", "leaf", "life-ring"])
def test_balls_touch_the_outline_and_stay_inside(name: str, rule: SkeletonRule) -> None:
    outline = o.outline(name)
    skeleton = _in_object_frame(name, rule)
    region = outline.polygon()
    at = shapely.points(skeleton.nodes[:, :2])
    assert shapely.contains(region, at).all()
    depth = shapely.distance(region.boundary, at)
    # The paper's circle goes through the samples, up to 0.8 radii apart: there an arc rises
    # over its chord by 0.8^2 / 8 of the radius.
    most = {"exact": 1.02, "paper": 1.0 / (1.0 - 0.08)}[rule]
    assert (skeleton.nodes[:, 2] < 1.15 * depth + 5e-3 * outline.size).all()
    assert (skeleton.nodes[:, 2] > 0.95 * depth - 5e-3 * outline.size).all()
    assert 0.98 < np.median(skeleton.nodes[:, 2] / depth) < most


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("name", ["key", "dice-five", "snowflake"])
def test_the_graph_has_the_holes_of_the_outline(name: str, rule: SkeletonRule) -> None:
    skeleton = _in_object_frame(name, rule)
    cycles = len(skeleton.edges) - len(skeleton.nodes) + o.outline(name).components
    assert cycles == o.outline(name).genus


@pytest.mark.parametrize("rule", RULES)
def test_a_disc_has_one_ball_and_a_bar_a_straight_axis(rule: SkeletonRule) -> None:
    disc = frame_of(outline_from_rings([o.circle(5, 7, 50, 300)]), rule)
    ball = disc.skeleton.transformed(disc.scale, disc.origin).nodes
    assert ball.mean(axis=0) == pytest.approx([5.0, 7.0, 50.0], rel=0.01)
    bar = np.array([[-80, -10], [80, -10], [80, 10], [-80, 10.0]])
    frame = frame_of(outline_from_rings([o.dense(bar, 1.0)]), rule)
    nodes = frame.skeleton.transformed(frame.scale, frame.origin).nodes
    middle = nodes[np.abs(nodes[:, 0]) < 60]
    assert len(middle) > 3
    assert middle[:, 1] == pytest.approx(np.zeros(len(middle)), abs=0.6)
    assert middle[:, 2] == pytest.approx(np.full(len(middle), 10.0), rel=0.05)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize(
    ("change", "back", "scale"),
    [
        (lambda r: r @ np.array([[0.8, -0.6], [0.6, 0.8]]), np.array([[0.8, 0.6], [-0.6, 0.8]]), 1),
        (lambda r: 1e-3 * r, 1e3 * np.eye(2), 1e-3),
        (lambda r: r[::-1], np.eye(2), 1),
        (lambda r: np.roll(r, 40, axis=0), np.eye(2), 1),
    ],
    ids=["rotated", "smaller", "reversed", "other start"],
)
def test_the_union_of_the_balls_is_the_same_however_drawn(
    rule: SkeletonRule, change: Callable, back: np.ndarray, scale: float
) -> None:
    def union(skeleton: Skeleton) -> shapely.Geometry:
        x, y, r = skeleton.nodes.T
        return shapely.union_all(shapely.buffer(shapely.points(x, y), r))

    here = union(_in_object_frame("key", rule))
    there = _in_object_frame("key", rule, change)
    nodes = np.column_stack([there.nodes[:, :2] @ back, there.nodes[:, 2] / scale])
    moved = union(Skeleton(nodes, there.edges))
    assert here.intersection(moved).area / here.union(moved).area > 0.97


@pytest.mark.parametrize("name", ["key", "hand-paper", "horse_skimage"])
def test_what_is_dropped_was_covered(name: str) -> None:
    skeleton = _in_object_frame(name, "paper")
    x, y, r = skeleton.nodes.T
    union = shapely.union_all(shapely.buffer(shapely.points(x, y), r))
    region = o.outline(name).polygon()
    assert union.intersection(region).area > 0.93 * region.area


def test_a_node_does_not_swallow_a_limb() -> None:
    # Radii that grow along the bar would let one contraction follow upon the other.
    wedge = o.dense(np.array([[-80, -9], [80, -11], [80, 11], [-80, 9.0]]), 1.0)
    frame = frame_of(outline_from_rings([wedge]), "paper")
    assert len(frame.skeleton.nodes) > 20


@pytest.mark.parametrize(
    "ring",
    [
        np.array([[0, 0], [100, 0], [100, 0.4], [0, 0.4]]),
        o.spiral(5, 2.0, 2.0),
    ],
    ids=["needle", "spiral"],
)
def test_a_thinned_skeleton_of_the_paper_describes_the_same_balls(ring: np.ndarray) -> None:
    frame = frame_of(outline_from_rings([ring]), "paper")
    whole = paper_skeleton(Outline(frame.rim.rings, frame.inner.parents))
    assert len(frame.skeleton.nodes) <= MOST_NODES < len(whole.nodes)
    a, b = frame.skeleton.nodes[frame.skeleton.edges].transpose(1, 0, 2)
    way, off = b - a, whole.nodes[:, None] - a
    t = np.clip((off * way).sum(axis=2) / (way * way).sum(axis=1), 0.0, 1.0)
    assert np.linalg.norm(off - t[..., None] * way, axis=2).min(axis=1).max() < 5e-3


@pytest.mark.slow
def test_too_many_nodes_of_the_papers_skeleton_are_refused() -> None:
    angle = np.arange(60) * np.pi / 30
    star = np.column_stack([np.cos(angle), np.sin(angle)]) * np.tile([[10.0], [50.0]], (30, 1))
    with pytest.raises(UserError, match="medial axis"):
        frame_of(outline_from_rings([star]), "paper")
