"""A loop that lies in a plane is that plane, exactly, whatever its shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.fill.plane_fill import PlaneFill
from bozzetto_product.loops.finding import find_loops
from bozzetto_product.network.net import Edge, Net
from bozzetto_product.shaping.pressure import inflated
from tests.plugins.product.known_surfaces import fitted, net_of_splines
from tests.plugins.product.plane_outlines import LETTERS, gear, star, trembling, turned

OUTLINES = {
    **LETTERS,
    "star of 5": star(5, 0.4),
    "star of 9": star(9, 0.25),
    "gear of 12": gear(12),
}


def area_of(net, loop):
    """Area within the curves of a loop, by Green's theorem over its chords."""
    ring = np.concatenate([net.edges[edge].spline.sampled(257)[:-1] for edge, _ in loop])
    ring = ring - ring.mean(axis=0)
    return 0.5 * np.linalg.norm(np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0))


@pytest.mark.parametrize("seed", [9101, 9102])
@pytest.mark.parametrize("name", list(OUTLINES))
def test_an_outline_drawn_in_pieces_is_found_and_is_its_plane(name, seed):
    net, loop = trembling(OUTLINES[name], seed)
    (found,) = find_loops(net).loops
    assert {edge for edge, _ in found} == {edge for edge, _ in loop}
    (fill,) = fill_net(net, [found])
    assert isinstance(fill, PlaneFill)
    assert not fill.folded
    (face,) = fill.brep.faces
    assert face.surface.degrees == (1, 1)
    assert fill.deviation <= 1e-8 * fill.size
    assert fill.area == pytest.approx(area_of(net, loop), rel=5e-3)
    corners = fill.mesh.vertices.astype(float)[fill.mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (across @ fill.normal > 0.0).all()
    assert fill.quality_p5 > 0.1


@pytest.mark.parametrize("seed", [9111, 9112, 9113])
def test_border_vertices_are_those_of_a_neighbour_and_places_are_found_within(seed):
    net, loop = trembling(LETTERS["C"], seed)
    fill = fill_net(net, [loop])[0]
    random = np.random.default_rng(seed)
    low, high = fill.mesh.bounds
    points = random.uniform(low, high, (200, 3)) + random.normal(scale=0.2, size=(200, 3))
    places = fill.plane.value(*fill.nearest_within(points).T)
    own = fill.mesh.vertices.astype(float)
    by_vertices = np.linalg.norm(own[None] - points[:, None], axis=2).min(axis=1)
    found = np.linalg.norm(places - points, axis=1)
    assert (found <= by_vertices + 1e-6 * fill.size).all()
    off = np.linalg.norm(own[None] - places[:, None], axis=2).min(axis=1)
    assert off.max() <= 2.0 * fill.spacing  # of what is beside the loop no place is off it


def test_a_thousand_times_as_large_and_anywhere_is_the_same_plane():
    net, loop = trembling(LETTERS["S"], 9121)
    (one,) = fill_net(net, [loop])
    big = Net(
        1000.0 * net.nodes,
        tuple(
            replace(e, spline=replace(e.spline, control_points=1000.0 * e.spline.control_points))
            for e in net.edges
        ),
    )
    (two,) = fill_net(big, [loop])
    assert isinstance(two, PlaneFill)
    assert np.allclose(two.plane.control_points, 1000.0 * one.plane.control_points, rtol=1e-9)


def test_what_leaves_its_plane_or_crosses_itself_is_no_plane():
    net, loop = trembling(LETTERS["L"], 9131)
    middle = net.edges[0].spline.control_points.copy()
    middle[3] += (0.01, 0.02, 0.03)
    bent = replace(net.edges[0], spline=replace(net.edges[0].spline, control_points=middle))
    (fill,) = fill_net(Net(net.nodes, (bent, *net.edges[1:])), [loop])
    assert isinstance(fill, PatchFill)
    bow = np.array([(0, 0), (2, 2), (2, 0), (0, 2)], float)
    share = np.linspace(0.0, 1.0, 33)[:, None]
    chains = [
        np.column_stack((a + share * (b - a), 0.0 * share))
        for a, b in zip(bow, np.roll(bow, -1, axis=0), strict=True)
    ]
    crossing, loop = net_of_splines([fitted(chain) for chain in chains])
    (fill,) = fill_net(crossing, [loop])
    assert not isinstance(fill, PlaneFill)


def folded_sheet(height):
    """A square in a plane, and one beside it that rises by a height: a net and their loops."""
    corners = np.array(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, height), (2, 1, height)], float
    )
    pairs = [(0, 1), (1, 2), (2, 3), (3, 0), (1, 4), (4, 5), (5, 2)]
    share = np.linspace(0, 1, 33)[:, None]
    edges = tuple(
        Edge(fitted(corners[a] + share * (corners[b] - corners[a])), a, b, f"c{k}")
        for k, (a, b) in enumerate(pairs)
    )
    one = ((0, True), (1, True), (2, True), (3, True))
    two = ((1, False), (4, True), (5, True), (6, True))
    return Net(corners, edges), (one, two)


@pytest.mark.parametrize(
    ("height", "crease", "kind"),
    [
        (0.0, np.nan, PlaneFill),
        (0.4, np.nan, PlaneFill),
        (0.4, 0.0, PatchFill),
        (1.5, np.nan, PlaneFill),
    ],
)
def test_smooth_to_what_is_bent_it_bends_and_at_creases_it_is_plane(height, crease, kind):
    """In one plane, at 22° (two planes; told smooth, both give way), and at 56°."""
    net, loops = folded_sheet(height)
    edges = list(net.edges)
    edges[1] = replace(edges[1], crease=crease)
    fill, _ = fill_net(replace(net, edges=tuple(edges)), loops)
    assert isinstance(fill, kind)
    assert np.nanmax([0.0, *fill.g1_degrees]) <= 0.05


def test_pressure_bends_a_plane_and_a_shape_that_would_fold_says_that_it_holds_none():
    square, loops = folded_sheet(0.0)
    (fill,) = fill_net(square, loops[:1])
    out = inflated(fill, 0.05)
    assert isinstance(out.fill, PatchFill)
    assert out.volume == pytest.approx(0.05)
    letter, loop = trembling(LETTERS["S"], 9141)
    (fill,) = fill_net(letter, [loop])
    held = inflated(fill, 0.01)
    assert held.limited
    assert held.fill is fill


def test_a_plane_turned_in_space_is_as_exact():
    for seed in (9151, 9152, 9153):
        net, loop = trembling(turned(OUTLINES["star of 5"], seed), seed)
        (fill,) = fill_net(net, [loop])
        assert isinstance(fill, PlaneFill)
        assert fill.deviation <= 1e-8 * fill.size
