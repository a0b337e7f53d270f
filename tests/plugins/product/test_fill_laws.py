"""Laws of fills: exact sides, rotation, scale, twice the same, mirror images, shared vertices."""

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.geometry import Spline, sewn
from bozzetto_product.fill.network_fills import fill_net
from bozzetto_product.network.net import Edge, Net
from tests.plugins.product.known_surfaces import (
    analytic_loops,
    ellipsoid,
    error_percent,
    filled,
    fitted,
    graph,
    points_of,
    random_loop,
    true_normals,
)


def wavy(x, y):
    return 0.2 * np.sin(2 * x) * np.cos(1.5 * y) + 0.1 * x**2


def sheet(columns=2, rows=1, symmetric=False):
    """A net of curves on a wavy surface, and its loops; symmetric ones in the plane x = 0."""
    surface = graph(lambda x, y: wavy(np.abs(x) if symmetric else x, y))
    xs = np.linspace(-1, 1, columns + 1)
    ys = np.linspace(-0.6, 0.6, rows + 1)
    number = {(i, j): i * len(ys) + j for i in range(len(xs)) for j in range(len(ys))}
    nodes = np.array([surface.lift(np.array([[x, y]]))[0] for x in xs for y in ys])
    keys = [((i, j), (i + 1, j)) for i in range(columns) for j in range(rows + 1)]
    keys += [((i, j), (i, j + 1)) for i in range(columns + 1) for j in range(rows)]
    edges, at = [], {}
    t = np.linspace(0, 1, 97)[:, None]
    for key in keys:
        (a, b), (c, d) = key
        start, end = np.array((xs[a], ys[b])), np.array((xs[c], ys[d]))
        points = fitted(surface.lift(start * (1 - t) + end * t)).control_points.copy()
        points[0], points[-1] = nodes[number[a, b]], nodes[number[c, d]]
        spline = Spline.uniform(points)
        at[key] = len(edges)
        edges.append(Edge(spline, number[a, b], number[c, d], f"c{len(edges)}"))
    loops = [
        (
            (at[(i, j), (i + 1, j)], True),
            (at[(i + 1, j), (i + 1, j + 1)], True),
            (at[(i, j + 1), (i + 1, j + 1)], False),
            (at[(i, j), (i, j + 1)], False),
        )
        for i in range(columns)
        for j in range(rows)
    ]
    return Net(nodes, tuple(edges)), loops


def changed(net, points):
    """The net with its points mapped."""
    edges = [
        replace(edge, spline=Spline(edge.spline.knots, points(edge.spline.control_points)))
        for edge in net.edges
    ]
    return Net(points(net.nodes), tuple(edges), net.joints)


def corners(fill):
    return np.concatenate([patch.control_points.reshape(-1, 3) for patch in fill.patches])


@pytest.mark.parametrize("number", [0, 6, 11, 14])
def test_a_fill_lies_on_its_surface_and_passes_through_its_curves(number):
    known = analytic_loops()[number]
    fill = filled(known, true_normals(known))
    assert error_percent(known, fill) < 0.1
    assert fill.deviation < 1e-14 * known.diagonal
    assert not fill.folded
    for side in fill.sides:
        for half in side.halves:
            for piece in half.pieces:
                edge = known.net.edges[known.loop[piece.half_edge][0]].spline
                at = np.linspace(*piece.piece.curve.range, 9)
                assert np.abs(piece.piece.curve.value(at) - edge.value(at)).max() < 1e-14


def test_rows_of_control_points_on_sides_are_those_of_the_pieces():
    known = random_loop(2006)
    fill = filled(known, true_normals(known))
    for k, side in enumerate(fill.sides):
        after = (k + 1) % len(fill.sides)
        first, second = side.halves
        assert np.array_equal(fill.patches[k].control_points[:, 0], first.points)
        assert np.array_equal(fill.patches[after].control_points[0], second.points)


def test_patches_meet_smoothly_over_spokes():
    known = random_loop(2002)
    fill = filled(known, true_normals(known))
    t = np.linspace(0.05, 0.95, 13)
    one = np.ones_like(t)
    for k, patch in enumerate(fill.patches):
        other = fill.patches[(k + 1) % len(fill.patches)]
        assert np.abs(patch.value(one, t) - other.value(t, one)).max() < 1e-12
        sine = np.linalg.norm(np.cross(patch.normals(one, t), other.normals(t, one)), axis=1)
        assert np.degrees(np.arcsin(sine.max())) < 1e-5


def test_a_net_rotated_or_a_thousand_times_larger_is_filled_alike():
    net, loops = sheet()
    spin, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    spin *= np.sign(np.linalg.det(spin))
    before = fill_net(net, loops)
    turned = fill_net(changed(net, lambda p: p @ spin.T), loops)
    larger = fill_net(changed(net, lambda p: 1000 * p), loops)
    for one, two, three in zip(before, turned, larger, strict=True):
        size = np.ptp(corners(one))
        assert np.abs(corners(two) - corners(one) @ spin.T).max() < 1e-6 * size
        assert np.abs(corners(three) / 1000 - corners(one)).max() < 1e-6 * size


def test_filling_twice_gives_the_same_and_keeps_what_did_not_change():
    net, loops = sheet(3)
    first, second = fill_net(net, loops), fill_net(net, loops)
    for one, two in zip(first, second, strict=True):
        assert np.array_equal(corners(one), corners(two))
    again = fill_net(net, loops)
    assert all(one is two for one, two in zip(first, again, strict=True))
    moved = list(net.edges)
    points = moved[0].spline.control_points.copy()
    points[3] += (0, 0, 0.02)
    moved[0] = replace(moved[0], spline=Spline(moved[0].spline.knots, points))
    after = fill_net(Net(net.nodes, tuple(moved)), loops)
    assert after[0] is not first[0]
    assert after[2] is first[2]


def test_fills_share_edges_and_vertices_exactly():
    net, loops = sheet(2, 2)
    fills = fill_net(net, loops)
    whole = sewn([fill.brep for fill in fills])
    assert len(whole.pieces) == 1
    assert len(whole.rim) == 2 * 8
    cells = [{row.tobytes() for row in fill.mesh.vertices} for fill in fills]
    segments = len(cells[0] & cells[1]) - 1
    assert segments >= 2 * 3
    assert len(cells[0] & cells[1] & cells[2] & cells[3]) == 1
    assert (
        len(set.union(*cells))
        == sum(map(len, cells))
        - sum(len(cells[a] & cells[b]) for a, b in ((0, 1), (0, 2), (1, 3), (2, 3)))
        + 1
    )


def test_smooth_edges_are_smooth_and_creases_are_told():
    net, loops = sheet()
    inner = next(
        e for e in range(len(net.edges)) if sum(e == h for one in loops for h, _ in one) == 2
    )
    smooth = fill_net(net, loops)
    place = [h for h, _ in loops[0]].index(inner)
    assert smooth[0].g1_degrees[place] < 0.05
    edges = list(net.edges)
    edges[inner] = replace(edges[inner], crease=1.0)
    creased = fill_net(Net(net.nodes, tuple(edges)), loops)
    assert np.isnan(creased[0].g1_degrees).all()


def test_fills_of_mirror_images_are_mirror_images_to_the_last_bit():
    net, loops = sheet(1)
    shift = np.array((3.0, 0, 0))
    net = changed(net, lambda p: p + shift)
    count, nodes = len(net.edges), len(net.nodes)
    flip = np.array((-1.0, 1, 1))
    edges = [replace(edge, twin=k + count) for k, edge in enumerate(net.edges)]
    edges += [
        Edge(
            Spline(edge.spline.knots, edge.spline.control_points * flip),
            edge.start + nodes,
            edge.end + nodes,
            edge.curve,
            mirrored=True,
            twin=k,
        )
        for k, edge in enumerate(net.edges)
    ]
    whole = Net(np.concatenate((net.nodes, net.nodes * flip)), tuple(edges))
    image = tuple((edge + count, not forward) for edge, forward in reversed(loops[0]))
    image = image[1:] + image[:1]
    one, two = fill_net(whole, [loops[0], image])
    for k, patch in enumerate(one.patches):
        other = two.patches[-k % len(two.patches)].turned_over()
        assert np.array_equal(patch.control_points * flip, other.control_points)
    assert two.deviation < 1e-14
    assert len(sewn([one.brep, two.brep]).pieces) == 2
    assert np.abs(two.solution.nets).max() < 2.0


@pytest.mark.parametrize("sense", [1, -1])
def test_images_of_edges_are_smooth_whatever_their_parameters(sense):
    """Twins need not have the range, nor the sense, of the edges that they are images of."""
    net, loops = sheet(2)
    net = changed(net, lambda p: p + np.array((3.0, 0, 0)))
    count, nodes = len(net.edges), len(net.nodes)
    flip = np.array((-1.0, 1, 1))
    edges = [replace(edge, twin=k + count) for k, edge in enumerate(net.edges)]
    for k, edge in enumerate(net.edges):
        image = Spline(2.0 * edge.spline.knots + 7.0, edge.spline.control_points * flip)
        ends = (edge.start + nodes, edge.end + nodes)
        image, ends = (image, ends) if sense > 0 else (image.reversed(), ends[::-1])
        edges.append(Edge(image, *ends, edge.curve, mirrored=True, twin=k))
    whole = Net(np.concatenate((net.nodes, net.nodes * flip)), tuple(edges))
    images = [
        tuple((edge + count, forward != (sense > 0)) for edge, forward in reversed(loop))
        for loop in loops
    ]
    for made in (fill_net(whole, images), fill_net(whole, [*loops, *images])[2:]):
        angles = np.array([angle for fill in made for angle in fill.g1_degrees])
        assert np.isfinite(angles).sum() == 2
        assert np.nanmax(angles) < 0.01


def test_a_surface_of_two_edges_and_of_one_closed_curve():
    surface = ellipsoid(1, 1, 1)
    t = np.linspace(0, 1, 129)
    x, y = 0.8 * (1 - 2 * t), 0.3 * (1 - (1 - 2 * t) ** 2)
    one = fitted(surface.lift(np.column_stack((x, y))))
    two = fitted(surface.lift(np.column_stack((-x, -y))))
    points = two.control_points.copy()
    points[0], points[-1] = one.control_points[-1], one.control_points[0]
    ends = np.array((one.control_points[0], one.control_points[-1]))
    net = Net(ends, (Edge(one, 0, 1, "a"), Edge(Spline(two.knots, points), 1, 0, "b")))
    (leaf,) = fill_net(net, [((0, True), (1, True))])
    assert leaf.deviation < 1e-12
    assert not leaf.folded
    ring = Spline.uniform(
        [(np.cos(a), 0.6 * np.sin(a), 0.1 * np.cos(2 * a)) for a in np.arange(10) * np.pi / 5],
        closed=True,
    )
    (disc,) = fill_net(Net(np.zeros((0, 3)), (Edge(ring, -1, -1, "c"),)), [((0, True),)])
    assert disc.deviation < 1e-12
    assert not disc.folded
    assert disc.brep.rim.size == 8


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_tiny_and_huge_nets_are_filled(scale):
    net, loops = sheet(1)
    (fill,) = fill_net(changed(net, lambda p: scale * p), loops)
    assert np.isfinite(points_of(fill)).all()
    assert fill.mesh.faces.size
    assert fill.quality_p5 > 0.3


def test_triangles_stay_while_a_curve_is_dragged_a_little_and_never_turn_over():
    net, loops = sheet(1)
    spots = []
    for step in range(4):
        edges = list(net.edges)
        points = edges[0].spline.control_points.copy()
        points[2:-2] += (0.0, 0.0, 1e-4 * step)
        edges[0] = replace(edges[0], spline=Spline(edges[0].spline.knots, points))
        (fill,) = fill_net(Net(net.nodes, tuple(edges)), loops)
        spots.append(fill.mesh)
    assert all(np.array_equal(mesh.faces, spots[0].faces) for mesh in spots)
    for mesh in spots:
        a, b, c = mesh.vertices.astype(float)[mesh.faces].transpose(1, 0, 2)
        across = np.cross(b - a, c - a)
        assert ((across * mesh.vertex_normals()[mesh.faces[:, 0]]).sum(axis=1) > 0).all()
