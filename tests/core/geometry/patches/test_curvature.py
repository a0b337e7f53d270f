"""Curvatures of patches against graphs of polynomials, round shapes, brute force and laws."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial.polynomial import polyder, polyval2d
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from bozzetto.geometry.patches.curvature import grid_curvatures
from bozzetto.geometry.patches.patch import Places, mirrored, normals_at, points_at, turned_over
from tests.core.geometry.patches.test_patch import flat_corner, nets, somewhere

AT = np.linspace(0, 1, 9)
NODES = np.linspace(0, 1, 4)


def through(surface):
    """The bicubic patch through sixteen points of a surface over the unit square."""
    rows = np.linalg.inv(BSpline([0] * 4 + [1] * 4, np.eye(4), 3)(NODES))
    u, v = np.meshgrid(NODES, NODES, indexing="ij")
    return np.einsum("ia,jb,abx->ijx", rows, rows, np.stack(surface(u, v), -1))[None]


def test_a_graph_has_the_curvature_of_the_textbook():
    """z = f(x, y) with bicubic f; the normal looks upward, so a hilltop bulges."""
    f = np.random.default_rng(3).normal(size=(4, 4))
    x, y = 2 * AT[:, None] - 1 + 0 * AT, 2 * AT[None, :] - 1 + 0 * AT[:, None]
    net = through(lambda u, v: (2 * u - 1, 2 * v - 1, polyval2d(2 * u - 1, 2 * v - 1, f)))

    def by(i, j):
        return polyval2d(x, y, polyder(polyder(f, i, axis=0), j, axis=1))

    fx, fy, xx, xy, yy = by(1, 0), by(0, 1), by(2, 0), by(1, 1), by(0, 2)
    steep = 1 + fx**2 + fy**2
    gaussian = (xx * yy - xy**2) / steep**2
    mean = -((1 + fx**2) * yy - 2 * fx * fy * xy + (1 + fy**2) * xx) / (2 * steep**1.5)
    found = grid_curvatures(net, AT, AT)
    np.testing.assert_allclose(
        (found.most * found.least)[0], gaussian, atol=1e-10 * np.abs(gaussian).max()
    )
    np.testing.assert_allclose(found.mean[0], mean, atol=1e-10 * np.abs(mean).max())


@pytest.mark.parametrize("radius", [1e-2, 30.0, 1e5])
def test_round_shapes(radius):
    """A twentieth of a radian of each, where a bicubic patch is all but exact."""
    span = 0.05

    def torus(u, v):  # three times as far round as it is thick
        a, b = span * u, 0.3 + span * v
        ring = 3 + np.cos(b)
        return radius * ring * np.cos(a), radius * ring * np.sin(a), radius * np.sin(b)

    def ball(u, v):
        a, b = span * u, 0.3 + span * v
        return (radius * np.cos(a) * np.cos(b), radius * np.sin(a) * np.cos(b),
                radius * np.sin(b))  # fmt: skip

    def tube(u, v):
        return radius * np.cos(span * u), radius * np.sin(span * u), radius * v

    around = np.cos(0.3 + span * AT) / (3 + np.cos(0.3 + span * AT))
    for shape, most, least in ((torus, 1.0, around), (ball, 1.0, 1.0), (tube, 1.0, 0.0)):
        found = grid_curvatures(through(shape), AT, AT)
        np.testing.assert_allclose(radius * found.most[0], most + 0 * found.most[0], atol=3e-4)
        np.testing.assert_allclose(radius * found.least[0], least + 0 * found.least[0], atol=3e-4)
        np.testing.assert_allclose(found.mean, 0.5 * (found.most + found.least))
        hollow = grid_curvatures(turned_over(through(shape)), AT, AT)
        np.testing.assert_allclose(radius * hollow.least[0, ::-1], -most, atol=3e-4)


def test_principal_curvatures_are_the_extremes_of_all_directions():
    """How fast the normal turns along a step, in every direction, by differences."""
    own = nets(seed=4)
    inner = somewhere(40, 5, seed=5)
    places = Places(inner.patches, 0.1 + 0.8 * inner.parameters)
    turned, step = np.radians(np.arange(0.0, 180.0, 0.5)), 1e-5
    found = []
    for angle in turned:
        by = step * np.array([np.cos(angle), np.sin(angle)])
        ends = [Places(places.patches, places.parameters + sign * by) for sign in (1, -1)]
        moved = points_at(own, ends[0]) - points_at(own, ends[1])
        bent = normals_at(own, ends[0]) - normals_at(own, ends[1])
        found.append((moved * bent).sum(1) / (moved**2).sum(1))
    found_here = [
        grid_curvatures(own[[patch]], [u], [v])
        for patch, (u, v) in zip(places.patches, places.parameters, strict=True)
    ]
    most, least = (np.array([getattr(one, name).item() for one in found_here])
                   for name in ("most", "least"))  # fmt: skip
    size = np.maximum(np.abs(most), np.abs(least))
    highest, lowest = np.max(found, axis=0), np.min(found, axis=0)
    assert (np.abs(most - highest) <= 2e-2 * size).all()
    assert (np.abs(least - lowest) <= 2e-2 * size).all()
    assert (highest <= most + 1e-4 * size).all()
    assert (lowest >= least - 1e-4 * size).all()


def test_motions_images_and_other_parameters_change_nothing_but_the_sign():
    own = nets(seed=6)
    found = grid_curvatures(own, AT, AT)

    def same(other, most, least):
        again = grid_curvatures(other, AT, AT)
        size = np.abs(most).max()
        np.testing.assert_allclose(again.most, most, rtol=1e-7, atol=1e-10 * size)
        np.testing.assert_allclose(again.least, least, rtol=1e-7, atol=1e-10 * size)

    turn = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    same(own @ turn.T + (1e3, -50.0, 7.0), found.most, found.least)
    same(40.0 * own, found.most / 40.0, found.least / 40.0)
    same(mirrored(own), found.most[:, ::-1], found.least[:, ::-1])
    same(turned_over(own), -found.least[:, ::-1], -found.most[:, ::-1])
    same(own.transpose(0, 2, 1, 3), *(-a.transpose(0, 2, 1) for a in (found.least, found.most)))
    same(own[:, ::-1, ::-1], found.most[:, ::-1, ::-1], found.least[:, ::-1, ::-1])


def test_what_has_no_tangent_plane_does_not_bend():
    """And no warning is given: these are errors in tests."""
    line = np.tile(np.arange(4.0)[:, None, None], (1, 1, 4, 3))
    for own in (np.zeros((1, 4, 4, 3)), np.full((2, 4, 4, 3), 7.0), line):
        found = grid_curvatures(own, AT, AT)
        assert not found.most.any()
        assert not found.least.any()
    corner = grid_curvatures(flat_corner(), AT, AT)
    assert corner.most[0, 0, 0] == corner.least[0, 0, 0] == 0.0
    assert np.isfinite(corner.most).all()
    np.testing.assert_allclose(corner.mean[0, 1:, 1:], 0.0, atol=1e-12)  # it lies in a plane
