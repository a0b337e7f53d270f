"""Patchworks: their topology, placements and triangles."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Curve, Patchwork, Placement, Shapes
from bozzetto.geometry.patches.closest_points import foot_points
from bozzetto.geometry.patches.coons import boundaries, coons_nets, sides_of
from bozzetto.geometry.patches.patch import extent, grid, grid_normals, points_at
from bozzetto.geometry.patches.tessellation import shaded, tessellated
from tests.core.geometry.body_kit import body, network
from tests.core.geometry.patches.test_patch import paraboloid

TURN = Placement((0.6, -0.8, 0.0, 0.8, 0.6, 0.0, 0.0, 0.0, 1.0), 0.37, (10.0, -20.0, 5.0))
MIRROR = Placement((1.0, 0, 0, 0, -1.0, 0, 0, 0, 1.0), 2.0, (0.0, 7.0, 0.0))


def car(**more):
    edges, sides, names, _ = body()
    return Patchwork.of_edges(edges, sides, "Car", (200, 30, 20), names, **more)


def single(net):
    return Patchwork(net, sides_of(net)[0], [[0, 1, 2, 3]])


def ball():
    """Six patches round a cube's corners, closed: a rough ball of radius 1."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 3**0.5
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    edges, sides, known = [], [], {}
    for quad in quads:
        row = []
        for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
            if (b, a) in known:
                row.append(~known[b, a])
                continue
            known[a, b] = len(edges)
            row.append(len(edges))
            p, q = corners[a], corners[b]
            reach = 4 / 3 * np.tan(np.arccos(p @ q) / 4)
            ta, tb = q - (p @ q) * p, p - (p @ q) * q
            unit = [t / np.linalg.norm(t) for t in (ta, tb)]
            edges.append([p, p + reach * unit[0], q + reach * unit[1], q])
        sides.append(row)
    return Patchwork.of_edges(edges, sides, "Ball")


def edges_of(mesh):
    """How often each pair of vertices is run through, by direction."""
    return Counter(
        (a, b) for f in mesh.faces.tolist() for a, b in zip(f, f[1:] + f[:1], strict=True)
    )


# -- topology ----------------------------------------------------------------------------------


def test_a_body_has_a_rim_of_twelve_edges_in_one_ring():
    one = car()
    assert (len(one.nets), len(one.edges), len(one.rim)) == (28, 62, 12)
    names = {number: pair for pair, number in network()[0].items()}
    assert all(n[0] in "BC" for edge in one.rim for n in names[edge])
    places, ends = one.nodes
    assert len(places) == 35
    assert set(Counter(ends[one.rim].ravel().tolist()).values()) == {2}
    np.testing.assert_array_equal(places[ends[:, 0]], one.edges[:, 0])
    np.testing.assert_array_equal(places[ends[:, 1]], one.edges[:, 3])
    assert [p.tolist() for p in one.pieces] == [list(range(28))]


def test_a_ball_has_no_rim_and_two_parts_are_two_pieces():
    assert not len(ball().rim)
    one, far = ball(), ball().placed(Placement(offset=(5.0, 0, 0)))
    both = Patchwork(
        np.vstack((one.nets, far.nets)),
        np.vstack((one.edges, far.edges)),
        np.vstack((one.sides, np.where(far.sides < 0, far.sides - 12, far.sides + 12))),
    )
    assert [p.tolist() for p in both.pieces] == [list(range(6)), list(range(6, 12))]


def spoiled(**changes):
    one = car()
    return lambda: replace(one, **{k: v(getattr(one, k)) for k, v in changes.items()})


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (spoiled(nets=lambda n: n[:-1]), "a net of 4 × 4"),
        (spoiled(nets=lambda n: n + 1e-9), "does not end in its edges"),
        (spoiled(edges=lambda e: e[:, :3]), "four points each"),
        (spoiled(edges=lambda e: e[:-1]), "does not exist"),
        (spoiled(sides=lambda s: np.vstack((s[:-1], s[:1]))), "twice in the same sense"),
        (spoiled(sides=lambda s: s[:, [0, 1, 3, 2]]), "does not end in its edges"),
        (spoiled(patch_names=lambda n: n[:3]), "a name for every patch"),
        (spoiled(nets=lambda n: n * np.nan), "not finite"),
        (lambda: Patchwork(np.zeros((0, 4, 4, 3)), np.zeros((1, 4, 3)), []), "needs a patch"),
    ],
)  # fmt: skip
def test_what_does_not_belong_together_is_refused(made, said):
    with pytest.raises(ValueError, match=said):
        made()


def test_sides_that_do_not_follow_each_other_are_refused():
    """No net can end in all of them."""
    edges, sides, _, _ = body()
    edges = edges.copy()
    edges[sides[0, 0], 0] += 1.0
    with pytest.raises(ValueError, match="end in its edges"):
        Patchwork.of_edges(edges, sides)


def test_arrays_cannot_be_written_to():
    one = car()
    for array in (one.nets, one.edges, one.sides):
        with pytest.raises(ValueError, match="read-only"):
            array.flat[0] = 1


# -- placements --------------------------------------------------------------------------------


@pytest.mark.parametrize("placement", [TURN, MIRROR, MIRROR.after(TURN)])
def test_placed_patches_are_where_placed_points_are_and_look_outward(placement):
    one, at = car(), np.linspace(0, 1, 5)
    moved = one.placed(placement)
    found = grid(moved.nets, at, at)
    normals = grid_normals(moved.nets, at, at)
    if placement.mirrors:
        found, normals = found[:, ::-1], normals[:, ::-1]
    before = grid(one.nets, at, at)
    expected = placement.points(before.reshape(-1, 3)).reshape(before.shape)
    np.testing.assert_allclose(found, expected, atol=1e-9)
    turned = placement.directions(grid_normals(one.nets, at, at).reshape(-1, 3))
    good = np.ones(normals.shape[:3], bool)
    good[:, [0, 0, -1, -1], [0, -1, 0, -1]] = False  # corners may have no tangent plane
    np.testing.assert_allclose(normals[good], turned.reshape(normals.shape)[good], atol=1e-9)
    assert len(moved.rim) == 12
    assert (moved.name, moved.color, moved.patch_names) == (one.name, one.color, one.patch_names)
    np.testing.assert_array_equal(sides_of(moved.nets), boundaries(moved.edges, moved.sides))


def test_shapes_carry_patchworks():
    one = Shapes(patchworks=(car(),))
    assert one
    assert len((one + one).patchworks) == 2
    (moved,) = one.placed(MIRROR).patchworks
    np.testing.assert_array_equal(moved.nets, car().placed(MIRROR).nets)
    assert one.placed(Placement()) is one
    both = one + Shapes(curves=(Curve(1, [0, 0, 1, 1], [[0, 0, 0], [1, 0, 0]]),))
    assert (len(both.curves), len(both.patchworks), len(both.placed(TURN).patchworks)) == (1, 1, 1)


# -- triangles ---------------------------------------------------------------------------------


@pytest.mark.parametrize("tolerance", [1.0, 20.0, 1e4])
def test_triangles_close_along_every_shared_edge(tolerance):
    one = car()
    mesh = tessellated(one, tolerance)
    runs = edges_of(mesh)
    assert set(runs.values()) == {1}
    free = {(a, b) for a, b in runs if (b, a) not in runs}
    starts = [a for a, _ in free]
    assert sorted(starts) == sorted(b for _, b in free)
    assert len(set(starts)) == len(starts)  # a ring
    step = dict(free)
    at, length = starts[0], 0
    while True:
        at, length = step[at], length + 1
        if at == starts[0]:
            break
    assert length == len(free)
    used = np.unique(mesh.faces)
    euler = len(used) - len({frozenset(e) for e in runs}) + len(mesh.faces)
    assert euler == 1
    rim = mesh.vertices[starts]
    assert all(np.abs(rim - node).max(axis=1).min() <= 1e-3 for node in one.edges[one.rim, 0])


def test_a_closed_patchwork_is_a_closed_mesh():
    mesh = tessellated(ball(), 1e-3)
    runs = edges_of(mesh)
    assert all((b, a) in runs for a, b in runs)
    corners = mesh.vertices[mesh.faces].astype(float)
    volume = np.einsum("fi,fi->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert 0.8 * 4 / 3 * math.pi < volume < 1.2 * 4 / 3 * math.pi  # and looks outward


@pytest.mark.parametrize("tolerance", [0.5, 2.0, 10.0])
def test_triangles_keep_to_the_tolerance(tolerance):
    one = car()
    mesh = tessellated(one, tolerance)
    rng = np.random.default_rng(1)
    corners = mesh.vertices[mesh.faces[rng.integers(0, len(mesh.faces), 400)]].astype(float)
    inside = np.einsum("nk,nkx->nx", rng.dirichlet([1, 1, 1], 400), corners)
    feet = points_at(one.nets, foot_points(one.nets, inside))
    assert np.linalg.norm(feet - inside, axis=1).max() <= tolerance + 1e-3  # float32
    assert len(mesh.faces) < 1e5 / tolerance


def test_a_flat_patch_takes_two_triangles_and_a_point_is_no_trouble():
    s = np.linspace(0, 9, 4)
    flat = np.stack((*np.meshgrid(s, s, indexing="ij"), 0 * np.eye(4)), -1)[None]
    assert tessellated(single(flat)).faces.tolist() in (
        [[0, 2, 3], [0, 3, 1]],
        [[0, 2, 1], [2, 3, 1]],
    )
    assert np.isfinite(tessellated(single(np.ones((1, 4, 4, 3)))).vertices).all()


def test_steps_of_a_parabola_are_those_of_its_curvature():
    """z = −x²: chords of length h are h²/4 off, in each direction half of the tolerance."""
    net = paraboloid()
    mesh = tessellated(single(net), 0.01)
    count = math.ceil(math.sqrt(2 * 4 / (4 * 0.01)))
    assert len(mesh.faces) == 2 * count**2


def test_equal_scale_gives_equal_triangles():
    one = car()
    small = one.placed(Placement(scale=1e-2))
    np.testing.assert_array_equal(tessellated(one).faces, tessellated(small).faces)


@pytest.mark.parametrize("divisions", [1, 5, 12])
def test_shaded_triangles_have_exact_normals_and_the_same_places_on_both_sides(divisions):
    one = car()
    mesh = shaded(one, divisions)
    at = np.linspace(0, 1, divisions + 1)
    places = mesh.vertices.reshape(28, divisions + 1, divisions + 1, 3)
    np.testing.assert_allclose(places, grid(one.nets, at, at), atol=1e-3)
    np.testing.assert_allclose(
        mesh.normals.reshape(places.shape), grid_normals(one.nets, at, at), atol=1e-6
    )
    lines = {}
    for patch, row in enumerate(one.sides.tolist()):
        p = places[patch]
        for side, line in zip(row, (p[:, 0], p[-1], p[::-1, -1], p[0, ::-1]), strict=True):
            lines.setdefault(side if side >= 0 else ~side, []).append(
                line if side >= 0 else line[::-1]
            )
    assert sorted(map(len, lines.values())) == [1] * 12 + [2] * 50
    for both in lines.values():
        np.testing.assert_array_equal(both[0], both[-1])
    corners = mesh.vertices[mesh.faces].astype(float)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if divisions > 1:
        assert ((across * mesh.normals[mesh.faces[:, 0]]).sum(1) > 0).mean() > 0.999


def test_a_patchwork_fills_its_extent():
    one = car()
    mesh = tessellated(one, 0.2)
    np.testing.assert_allclose(mesh.bounds, extent(one.nets), atol=0.2)


def test_coons_patches_take_edges_in_any_sense():
    edges, sides, _, _ = body()
    turned = edges[:, ::-1]
    np.testing.assert_array_equal(coons_nets(turned, ~sides), coons_nets(edges, sides))
