"""Patches that bend one way where they can: control points move a little.

Of all patches between the same lines those of least variation (`fair_patches`) still bend to both
sides in places where they need not. Here control points move a little more, inner ones along the
normals of their corners, and those of lines where these may turn (`body.turned_lines`), until

    V + w Σ a² ρ(s) + c Σ m²,    s = k₁ k₂ / (k₂ - k₁) where k₁ k₂ < 0, else 0

is least: V is the variation of `fair_patches`, the first sum goes over places of all patches, and
m is what creases miss (`weak_creases`; `crease_angles` where lines turn). s is half the harmonic
mean of the two curvatures of a saddle, so about the smaller one. ρ is the pseudo-Huber loss
(Charbonnier et al. 1997, "Deterministic edge-preserving regularization in computed imaging"), with
which it is the area of saddles that counts, and hardly their depth: what lines force stays, and is
not made up for elsewhere. The least is found by steps of Gauss and Newton's method with iterated
weights; their number is fixed, so that a body that moves a little has patches that move a little.
"""

from __future__ import annotations

from typing import Final, Protocol

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry.patches import bernstein

PLACES: Final = np.linspace(0.1, 0.9, 4)
"""Parameters, in both directions, of the places in which patches are looked at. Sides have the
curvature that their lines give them."""

WEIGHT: Final = 4e3
"""Weight of saddles relative to the variation. With more of it there are hardly fewer."""

SHALLOW: Final = 0.2
"""Curvature up to which a saddle counts by its square and from which by its size, per length of the
car: a radius of five lengths."""

STEPS: Final = 3
"""Steps of the method. With twice as many there are hardly fewer saddles."""

STIFF: Final = 600.0
"""Weight of what is missing over creases, mm² each, relative to the variation."""

TINY: Final = float(np.finfo(float).tiny)


def _products() -> Array:
    """Return x_u, x_v, x_uu, x_uv and x_vv of the places by the points of a net, (5, p, 16)."""
    by = [bernstein(PLACES, order) for order in range(3)]
    orders = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    return np.stack([np.kron(by[along], by[across]) for along, across in orders])


_DERIVED: Final = _products()


class Missing(Protocol):
    """What creases should have and have not."""

    def missing(self, nets: Array, ways: Array) -> tuple[Array, Array]:
        """Return what is missing, (c,) mm, and how it changes with the unknowns, (c, n)."""


def bent_one_way(
    nets: Array,
    free: tuple[int, ...],
    ways: Array,
    form: Array,
    creases: Missing,
    *,
    gently: bool = False,
) -> Array:
    """Return how far control points move for least saddles, (n,).

    Parameters
    ----------
    nets : (k, 4, 4, 3) float
        Patches of least variation, mm.
    free : tuple of int
        Numbers 0 … 15 of the f control points of a net that move.
    ways : (k, f, n, 3) float
        How each of them moves with each unknown.
    form : (n, n) float
        The variation by the unknowns, from its least, is half of this form; it is positive.
    creases : Missing
        What creases between the patches should have.
    gently : bool
        Whether saddles that have just come to be count for nothing, and for half at `SHALLOW`. The
        few steps then lead to patches that leap less when lines turn with them.
    """
    count = len(form)
    begun = nets.reshape(-1, 16, 3)
    by_point = ways.transpose(0, 1, 3, 2).reshape(len(nets), 3 * len(free), count)
    size = float(np.ptp(nets[..., 0]))
    moved = np.zeros(count)
    for _ in range(STEPS):
        now = begun.copy()
        now[:, list(free)] += (by_point @ moved).reshape(-1, len(free), 3)
        depths, slopes, areas = _saddles(now, free)
        loss = 1.0 / np.sqrt(1.0 + (depths * (size / SHALLOW)) ** 2)
        if gently:
            loss *= depths / (depths + SHALLOW / size)
        weights = WEIGHT * areas.mean(axis=1, keepdims=True) * areas / len(areas[0]) * loss
        rows = (slopes.reshape(*depths.shape, -1) @ by_point).reshape(depths.size, count)
        weighted = rows.T * weights.ravel()
        short, turns = creases.missing(now, ways)
        matrix = form + weighted @ rows + STIFF * turns.T @ turns
        slope = form @ moved + weighted @ depths.ravel() + STIFF * turns.T @ short
        moved = moved - np.linalg.solve(matrix, slope)
    return moved


def _saddles(nets: Array, free: tuple[int, ...]) -> tuple[Array, Array, Array]:
    """Return s of the module's head, 0 where a patch bends one way, and how it changes.

    Parameters
    ----------
    nets : (k, 16, 3) float
        Control points, mm.
    free : tuple of int
        Numbers of the f that move.

    Returns
    -------
    depths : (k, p) float
        s in each place, 1/mm.
    slopes : (k, p, f, 3) float
        Its derivatives by these control points; normals and lengths count as fixed.
    areas : (k, p) float
        Area per unit of both parameters, mm².
    """
    along, across, *bends = _DERIVED[:, None] @ nets
    normals = cross_product(along, across)
    areas = np.maximum(np.linalg.norm(normals, axis=-1), TINY)
    normals /= areas[..., None]
    lengths = np.maximum(np.linalg.norm(along, axis=-1), TINY)
    by_u, by_v, by_both = (
        ((normals * bend).sum(axis=-1)) for bend in (bends[0], bends[2], bends[1])
    )
    # Unit vectors in the surface: one along u, (a, 0) in the parameters, and one across it, (b, c).
    a, b, c = 1.0 / lengths, -(along * across).sum(axis=-1) / (lengths * areas), lengths / areas
    one, both, other = (
        a * a * by_u,
        a * (b * by_u + c * by_both),
        b * b * by_u + 2.0 * b * c * by_both + c * c * by_v,
    )
    gauss, apart = one * other - both**2, np.hypot(one - other, 2.0 * both)
    saddle = gauss < 0.0
    apart = np.where(saddle, apart, 1.0)
    depths = np.where(saddle, -gauss / apart, 0.0)
    share = gauss / apart**3
    slope_one = -other / apart + share * (one - other)
    slope_other = -one / apart - share * (one - other)
    slope_both = 2.0 * both / apart + 4.0 * share * both
    parts = (
        slope_one * a * a + slope_both * a * b + slope_other * b * b,
        slope_both * a * c + 2.0 * slope_other * b * c,
        slope_other * c * c,
    )
    by_bend = sum(
        part[..., None] * by_point
        for part, by_point in zip(parts, _DERIVED[2:, :, list(free)], strict=True)
    )
    slopes = np.where(saddle[..., None], by_bend, 0.0)[..., None] * normals[..., None, :]
    return depths, slopes, areas
