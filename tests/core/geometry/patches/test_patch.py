"""Patches and Coons nets against Coons' own formula, SciPy, closed forms and laws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from bozzetto.geometry.patches.coons import (
    boundaries,
    coons_nets,
    edge_numbers,
    sides_of,
    with_boundaries,
)
from bozzetto.geometry.patches.patch import (
    Places,
    bernstein,
    extent,
    grid,
    grid_normals,
    halved,
    mirrored,
    normals_at,
    points_at,
    split,
    turned_over,
)
from tests.core.geometry.body_kit import body

KNOTS = [0] * 4 + [1] * 4
RNG = np.random.default_rng(8)


def nets(count=5, size=100.0, seed=1):
    return np.random.default_rng(seed).normal(size=(count, 4, 4, 3)) * size


def somewhere(count, patches, seed=2):
    rng = np.random.default_rng(seed)
    return Places(rng.integers(0, patches, count), rng.random((count, 2)))


def by_scipy(net, u, v, du=0, dv=0):
    """Tensor product of SciPy's B-splines, (n, 3)."""
    rows = [BSpline(KNOTS, np.eye(4), 3)(u, du), BSpline(KNOTS, np.eye(4), 3)(v, dv)]
    return np.einsum("ni,nj,ijx->nx", *rows, net)


# -- Coons -------------------------------------------------------------------------------------


def hermite(t):
    """Cubic Hermite polynomials: value and slope at 0, slope and value at 1."""
    return np.stack(
        (1 - 3 * t**2 + 2 * t**3, t - 2 * t**2 + t**3, t**3 - t**2, 3 * t**2 - 2 * t**3)
    )


def coons(south, east, north, west, u, v):
    """Coons' bicubically blended patch as he wrote it: two lofts less the corners.

    South and north run with u, west and east with v, all as SciPy's Bézier curves.
    """
    curve = {k: BSpline(KNOTS, c, 3) for k, c in
             {"s": south, "e": east, "n": north, "w": west}.items()}  # fmt: skip
    hu, hv = hermite(u)[..., None], hermite(v)[..., None]

    def across(h, start, end):
        return h[0] * start + h[3] * end  # blended as values are, twists 0

    d = {k: (c(0.0, 1), c(1.0, 1)) for k, c in curve.items()}
    loft_u = (
        hu[0] * curve["w"](v) + hu[3] * curve["e"](v)
        + hu[1] * across(hv, d["s"][0], d["n"][0]) + hu[2] * across(hv, d["s"][1], d["n"][1])
    )  # fmt: skip
    loft_v = (
        hv[0] * curve["s"](u) + hv[3] * curve["n"](u)
        + hv[1] * across(hu, d["w"][0], d["e"][0]) + hv[2] * across(hu, d["w"][1], d["e"][1])
    )  # fmt: skip
    corners = np.zeros((4, 4, 3))
    corners[0, 0], corners[3, 0], corners[0, 3], corners[3, 3] = (
        south[0], south[3], north[0], north[3])  # fmt: skip
    corners[1, 0], corners[2, 0], corners[1, 3], corners[2, 3] = (*d["s"], *d["n"])
    corners[0, 1], corners[0, 2], corners[3, 1], corners[3, 2] = (*d["w"], *d["e"])
    return loft_u + loft_v - np.einsum("in,jn,ijx->nx", hermite(u), hermite(v), corners)


def random_square(seed):
    """Four edges in random senses, and the sides of one patch between them."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(4, 3))
    edges, sides = [], []
    for k in range(4):
        edge = np.vstack((corners[k], rng.normal(size=(2, 3)), corners[(k + 1) % 4]))
        turned = rng.random() < 0.5
        edges.append(edge[::-1] if turned else edge)
        sides.append(~k if turned else k)
    return np.array(edges), np.array([sides])


def test_the_net_is_coons_formula():
    u, v = RNG.random((2, 5000))
    for seed in range(20):
        edges, sides = random_square(seed)
        (net,) = coons_nets(edges, sides)
        south, east, north, west = boundaries(edges, sides)[0]
        expected = coons(south, east, north[::-1], west[::-1], u, v)
        assert np.abs(by_scipy(net, u, v) - expected).max() <= 1e-12


def test_a_body_of_coons_patches_is_coons_formula_to_1e12_of_its_size():
    edges, sides, _, _ = body(1, 0.5)
    u, v = RNG.random((2, 200))
    for net, round_ in zip(coons_nets(edges, sides), boundaries(edges, sides), strict=True):
        south, east, north, west = round_
        expected = coons(south, east, north[::-1], west[::-1], u, v)
        assert np.abs(by_scipy(net, u, v) - expected).max() <= 1e-12 * 4600


def test_nets_end_in_their_edges_bit_for_bit():
    edges, sides, _, _ = body()
    made = coons_nets(edges, sides)
    np.testing.assert_array_equal(sides_of(made), boundaries(edges, sides))
    np.testing.assert_array_equal(with_boundaries(made, edges, sides), made)
    assert sides_of(made)[:, :, 3].tolist() == sides_of(made)[:, [1, 2, 3, 0], 0].tolist()


def test_the_twist_in_the_corners_is_none():
    edges, sides = random_square(3)
    (net,) = coons_nets(edges, sides)
    for u in (0.0, 1.0):
        for v in (0.0, 1.0):
            np.testing.assert_allclose(by_scipy(net, [u], [v], 1, 1), 0, atol=1e-13)


def test_numbers_of_edges():
    assert edge_numbers([[0, ~0, 5, ~7]]).tolist() == [[0, 0, 5, 7]]


# -- values and derivatives --------------------------------------------------------------------


@pytest.mark.parametrize("du", [0, 1, 2, 3])
@pytest.mark.parametrize("dv", [0, 1, 2])
def test_grids_and_places_are_scipys(du, dv):
    own = nets()
    u, v = np.linspace(0, 1, 7), np.linspace(0, 1, 5)
    found = grid(own, u, v, du=du, dv=dv)
    assert found.shape == (5, 7, 5, 3)
    uu, vv = (a.ravel() for a in np.meshgrid(u, v, indexing="ij"))
    for patch, net in enumerate(own):
        expected = by_scipy(net, uu, vv, du, dv)
        np.testing.assert_allclose(found[patch].reshape(-1, 3), expected, atol=1e-9)
        at = Places(np.full(len(uu), patch), np.column_stack((uu, vv)))
        np.testing.assert_allclose(points_at(own, at, du=du, dv=dv), expected, atol=1e-9)


def test_bernstein_polynomials_are_one_together():
    at = np.linspace(0, 1, 101)
    np.testing.assert_allclose(bernstein(at).sum(axis=1), 1, atol=1e-15)
    assert bernstein([0.0, 1.0]).tolist() == [[1, 0, 0, 0], [0, 0, 0, 1]]


def test_normals_are_units_across_both_tangents():
    own, at = nets(), np.linspace(0, 1, 9)
    normals = grid_normals(own, at, at)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1, atol=1e-12)
    xu, xv = grid(own, at, at, du=1), grid(own, at, at, dv=1)
    for tangent in (xu, xv):
        length = np.linalg.norm(tangent, axis=-1)
        assert (np.abs((normals * tangent).sum(-1)) <= 1e-10 * length).all()
    assert (np.einsum("...x,...x", np.cross(xu, xv), normals) > 0).all()
    places = somewhere(50, 5)
    exact = np.cross(points_at(own, places, du=1), points_at(own, places, dv=1))
    exact /= np.linalg.norm(exact, axis=1, keepdims=True)
    np.testing.assert_allclose(normals_at(own, places), exact, atol=1e-9)


def flat_corner():
    """A patch in the plane z = 0 whose edges run on into each other at u = v = 0."""
    corners = np.array([[0, 0, 0], [10, 0, 0], [0, 20, 0], [-10, 0, 0]], float)
    edges = []
    for k in range(4):
        p, q = corners[k], corners[(k + 1) % 4]
        edges.append([p, p + (q - p) / 3, q + (p - q) / 3, q])
    return coons_nets(edges, [[0, 1, 2, 3]])


def test_a_corner_without_a_tangent_plane_has_the_normal_beside_it():
    own = flat_corner()
    np.testing.assert_array_equal(np.cross(own[0, 1, 0], own[0, 0, 1]), 0)
    np.testing.assert_allclose(grid_normals(own, [0, 1], [0, 1])[0, 0, 0], [0, 0, 1])
    np.testing.assert_allclose(
        normals_at(own, Places(np.array([0]), np.zeros((1, 2)))), [[0, 0, 1]]
    )


def test_what_has_no_area_has_normals_of_nought():
    for own in (np.zeros((1, 4, 4, 3)), np.tile(np.arange(4.0)[:, None, None], (1, 1, 4, 3))):
        assert not grid_normals(own, [0, 0.3], [0.2]).any()


# -- pieces and images -------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("at", [0.0, 0.3, 1.0])
def test_both_parts_of_a_split_are_the_patch(axis, at):
    own = nets(3)
    low, high = split(own, at, axis)
    places = somewhere(60, 3)
    for part, begin, width in ((low, 0.0, at), (high, at, 1.0 - at)):
        there = places.parameters.copy()
        there[:, axis] = begin + width * there[:, axis]
        expected = points_at(own, Places(places.patches, there))
        np.testing.assert_allclose(points_at(part, places), expected, atol=1e-10)
    np.testing.assert_array_equal(np.take(low, 3, axis + 1), np.take(high, 0, axis + 1))


def test_quarters_are_the_patch():
    own = nets(2)
    quarters = halved(own)
    at = np.linspace(0, 1, 4)
    for number, (u, v) in enumerate([(0, 0), (0, 0.5), (0.5, 0), (0.5, 0.5)]):
        np.testing.assert_allclose(
            grid(quarters[number], at, at), grid(own, u + at / 2, v + at / 2), atol=1e-10
        )


def test_mirror_images_are_exact_and_look_outward():
    own, at = nets(), np.linspace(0, 1, 6)
    image = mirrored(own)
    np.testing.assert_array_equal(mirrored(image), own)
    np.testing.assert_array_equal(image[:, ::-1] * [1, -1, 1], own)
    expected = grid_normals(own, at, at)[:, ::-1] * [1, -1, 1]
    np.testing.assert_allclose(grid_normals(image, at, at), expected, atol=1e-12)
    np.testing.assert_array_equal(mirrored(own, 2)[..., 2], -own[:, ::-1][..., 2])


def test_turned_over_normals_point_the_other_way():
    own = nets()
    expected = -grid_normals(own, [0.25], [0.75])
    np.testing.assert_allclose(grid_normals(turned_over(own), [0.75], [0.75]), expected, atol=1e-12)


# -- extent ------------------------------------------------------------------------------------


def paraboloid(a=0.0, b=0.0):
    """z = 1 − (x − a)² − (y − b)² over −1 … 1, exactly."""
    s = np.array([-1, -1 / 3, 1 / 3, 1])
    square = np.array([1, -1 / 3, -1 / 3, 1])  # control points of x² over −1 … 1
    net = np.empty((1, 4, 4, 3))
    net[0, ..., 0], net[0, ..., 1] = s[:, None], s[None, :]
    net[0, ..., 2] = (
        1 - (square - 2 * a * s + a * a)[:, None] - (square - 2 * b * s + b * b)[None, :]
    )
    return net


def test_extent_of_a_paraboloid():
    box = extent(paraboloid(0.3, -0.7))
    low = 1 - 1.3**2 - 1.7**2
    np.testing.assert_allclose(box, [[-1, -1, low], [1, 1, 1]], atol=1e-9)


def test_extent_holds_the_surface_and_is_reached_by_it():
    at = np.linspace(0, 1, 301)
    for seed in range(15):
        own = nets(3, seed=seed)
        box = extent(own)
        found = grid(own, at, at).reshape(-1, 3)
        slack = 1e-9 * np.abs(own).max()
        assert (found >= box[0] - slack).all()
        assert (found <= box[1] + slack).all()
        size = np.abs(own).max()
        np.testing.assert_allclose([found.min(0), found.max(0)], box, atol=2e-4 * size)


@pytest.mark.parametrize(
    "net",
    [
        np.zeros((4, 4, 3)),
        np.ones((4, 4, 3)) * 1e9,
        np.tile(np.linspace(0, 5, 4)[:, None, None], (1, 4, 3)),
    ],
)
def test_extent_of_the_flat_and_the_pointlike(net):
    found = extent(net[None])
    np.testing.assert_allclose(found, [net.min((0, 1)), net.max((0, 1))], rtol=1e-9)


@pytest.mark.parametrize("slope", [0.0, 1e-12, 1e-7, 1e-3])
def test_extent_of_a_ridge_that_is_nearly_level(slope):
    """z = 1000 (1 − (x − 0.3)²) + slope y: its height is that of the ridge's far end."""
    net = 1000 * paraboloid(0.3)
    net[..., 2] += 1000 * np.array([1, -1 / 3, -1 / 3, 1])  # without the part of y
    net[..., 2] += slope * net[..., 1]
    assert extent(net)[1, 2] == pytest.approx(1000 + 1000 * slope, abs=1e-6)


def test_extent_of_a_body_that_touches_its_box_along_a_whole_line():
    own = coons_nets(*body()[:2])
    own[..., 2] = np.minimum(own[..., 2], 1000.0)  # many patches are flat on top
    assert extent(own)[1, 2] == pytest.approx(1000.0, abs=1e-6)
