"""What the colours of a body say, and that everybody can read them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.geometry import Patchwork
from bozzetto.geometry.patches.patch import turned_over
from bozzetto.geometry.patches.tessellation import shaded
from bozzetto_car.solver.uncertainty import Source
from bozzetto_car.template.model import Template
from bozzetto_car.view.surface_colors import (
    BENDS,
    SOURCE_COLORS,
    certainty_colors,
    curvature_colors,
)

Array = NDArray[np.float64]

COLOR_VISION = {
    "all cones": np.eye(3),
    "no long ones": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
         [-0.003882, -0.048116, 1.051998]]),
    "no middle ones": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
         [-0.011820, 0.042940, 0.968881]]),
    "no short ones": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
         [0.004733, 0.691367, 0.303900]]),
}  # fmt: skip
"""What is left of linear sRGB (Machado, Oliveira & Fernandes 2009, "A physiologically-based model
for simulation of color vision deficiency", severity 1)."""

TOLD_APART = 20.0
"""Distance in CIELAB at which two fields of colour are told apart at once."""


def as_lab(colors: Array, vision: Array) -> Array:
    """CIELAB (D65) of sRGB colours 0 … 255 as somebody sees them, (n, 3)."""
    share = np.asarray(colors, float) / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    linear = np.clip(linear @ vision.T, 0.0, 1.0)
    to_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    x, y, z = np.cbrt(linear @ np.array(to_xyz).T / (0.9505, 1.0, 1.089)).T
    return np.stack((116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)), axis=1)


def body(template: Template) -> Patchwork:
    return Patchwork.of_edges(template.control_points, [patch.edges for patch in template.patches])


def bowl(depth: float = 0.2) -> Array:
    """One patch over a square of a metre, z = depth (x² + y²), looking upward: a hollow."""
    s = np.linspace(0.0, 1.0, 4)
    square = np.array([0.0, 0.0, 1.0 / 3.0, 1.0])  # control points of x² over 0 … 1
    x, y = np.meshgrid(s, s, indexing="ij")
    net = np.stack((x, y, depth * (square[:, None] + square[None, :])), axis=-1)
    return 1000.0 * net[None]


# -- curvature -------------------------------------------------------------------------------------


def test_a_hollow_is_blue_a_bulge_red_and_a_plane_grey() -> None:
    red, _, blue = curvature_colors(bowl())[:, :3].astype(int).T
    assert (blue > red + 30).all()
    red, _, blue = curvature_colors(turned_over(bowl()))[:, :3].astype(int).T
    assert (red > blue + 30).all()
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    flat = curvature_colors(bowl(0.0) @ turn.T + 0.1)[:, :3].astype(int)
    assert np.ptp(flat, axis=1).max() <= 8  # whatever rounding has left
    assert np.ptp(flat, axis=0).max() == 0


def test_a_saddle_is_as_grey_as_a_plane() -> None:
    net = bowl(0.0)
    net[0, :, :, 2] = 50.0 * np.linspace(-1, 1, 4)[:, None] * np.linspace(-1, 1, 4)[None, :]
    both = np.concatenate((net, bowl()))
    saddle = curvature_colors(both, 4)[:25, :3].astype(int)
    assert np.ptp(saddle, axis=1).max() <= 12


def test_what_bends_more_has_more_colour() -> None:
    """A bowl is bent most at its bottom, the corner at the origin, and ever less from there."""
    red = curvature_colors(bowl(2.0))[:, 0].astype(int).reshape(13, 13)
    outward = red[np.arange(13), np.arange(13)]
    assert (np.diff(outward) >= 0).all()
    assert outward[-1] > outward[0] + 50


def test_colours_stand_at_their_vertices_in_a_symmetric_car(template: Template) -> None:
    """The mirror image of every vertex has the same colour."""
    whole = body(template)
    places = np.asarray(shaded(whole).vertices, float)
    colors = curvature_colors(whole.nets).astype(int)
    assert colors.shape == (len(places), 4)
    assert (colors[:, 3] == 255).all()
    middle = places.reshape(-1, 13, 13, 3)[:, 1:-1, 1:-1].reshape(-1, 3)  # of one patch each
    own = colors.reshape(-1, 13, 13, 4)[:, 1:-1, 1:-1].reshape(-1, 4)
    image = middle * (1.0, -1.0, 1.0)
    for k in range(0, len(middle), 7):
        gap = ((middle - image[k]) ** 2).sum(axis=1)
        twin = int(gap.argmin())
        assert gap[twin] < 1e-4
        assert np.abs(own[twin] - own[k]).max() <= 1


def test_size_does_not_matter_and_a_sharp_corner_does_not_grey_the_rest(
    template: Template,
) -> None:
    nets = body(template).nets
    colors = curvature_colors(nets)
    small = curvature_colors(0.01 * nets)
    assert np.abs(colors.astype(int) - small).max() <= 1
    thorn = np.concatenate((nets, 1e-3 * bowl(4.0)))
    spoilt = curvature_colors(thorn)[: len(colors)].astype(int)
    assert np.abs(spoilt - colors).mean() < 12


# -- certainty -------------------------------------------------------------------------------------


def some_sources(template: Template, seed: int) -> list[Source]:
    kinds: tuple[Source, ...] = ("seen", "mirrored", "guessed")
    return [kinds[k] for k in np.random.default_rng(seed).integers(0, 3, len(template.names))]


def test_a_node_has_the_colour_of_what_is_known_of_it(template: Template) -> None:
    sources = some_sources(template, 1)
    places = np.asarray(shaded(body(template)).vertices, float)
    colors = certainty_colors(template, sources)
    found = 0
    for node, place in enumerate(template.positions):
        there = colors[np.abs(places - place).max(axis=1) < 1e-3]
        found += len(there)
        assert (there[:, :3] == SOURCE_COLORS[sources[node]]).all()
    assert found == 4 * len(template.patches)


def test_patches_agree_along_the_edges_they_share(template: Template) -> None:
    colors = certainty_colors(template, some_sources(template, 2)).astype(int)
    places = np.asarray(shaded(body(template)).vertices, float)
    _, which, counts = np.unique(places, axis=0, return_inverse=True, return_counts=True)
    shared = 0
    for place in np.flatnonzero(counts > 1):
        there = colors[which.ravel() == place]
        shared += 1
        assert np.ptp(there, axis=0).max() <= 1
    assert shared >= 11 * (len(template.edges) - 12)


def test_a_car_that_is_seen_all_over_has_one_colour(template: Template) -> None:
    colors = certainty_colors(template, ["seen"] * len(template.names), 5)
    assert colors.shape == (36 * len(template.patches), 4)
    assert (colors == (*SOURCE_COLORS["seen"], 255)).all()


# -- whoever looks ---------------------------------------------------------------------------------


@pytest.mark.parametrize("vision", COLOR_VISION)
def test_everybody_tells_the_colours_apart(vision: str) -> None:
    sources = as_lab(np.array(list(SOURCE_COLORS.values())), COLOR_VISION[vision])
    for a in range(3):
        for b in range(a):
            assert np.linalg.norm(sources[a] - sources[b]) > TOLD_APART
    bends = as_lab(BENDS, COLOR_VISION[vision])
    for step in range(2, 5):  # from the second on, a hollow is not taken for a bulge
        assert np.linalg.norm(bends[4 - step] - bends[4 + step]) > TOLD_APART
    lightness = bends[:, 0]
    assert (np.diff(lightness[:5]) > 0).all()
    assert (np.diff(lightness[4:]) < 0).all()
