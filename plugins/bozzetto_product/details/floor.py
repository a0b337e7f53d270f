"""The floor of a detail: the surface at a distance from a region, as one spline over its chart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import BSplineSurface
from bozzetto_product.details.chart import Chart, parameters_at

DEGREE: Final = 3

SPANS: Final = (6, 12, 24)
"""Spans along each axis of a floor; more only where fewer are not near enough."""

PER_SPAN: Final = 2.5
"""Places along a span at which the floor is fitted."""

NEAR: Final = 2e-6
"""Distance from the true offset, as share of the size of the whole, that needs no finer floor."""

MARGIN: Final = 0.04
"""How far a floor reaches beyond its region, as share of the region's extent."""

BEYOND: Final = 1e-4
"""Weight of places beyond creases, where a floor goes on to meet another one, against those of the
surfaces."""

STIFF: Final = 1e-9
"""Weight of second differences of control points, which hold where no place is known."""

SEED: Final = 7
"""Of the places at which a floor is compared with the true offset."""

ROUNDS: Final = 30
"""Most steps to the nearest place of a floor."""


@dataclass(frozen=True, eq=False)
class Floor:
    """A surface under or over a region.

    Parameters
    ----------
    surface : BSplineSurface
        Its parameters are the coordinates in the chart of the places it is the offset of.
    deviation : float
        Largest distance from the true offset where that was looked at, mm.
    """

    surface: BSplineSurface
    deviation: float

    def nearest(self, points: Array, start: Array) -> Array:
        """Return parameters of the places nearest to points in space, (n, 2)."""
        at = np.array(start)
        low, high = np.transpose(self.surface.ranges)
        for _ in range(ROUNDS):
            off = points - self.surface.value(*at.T)
            x = self.surface.derivative(at[:, 0], at[:, 1], 1, 0)
            y = self.surface.derivative(at[:, 0], at[:, 1], 0, 1)
            xx, xy, yy = ((a * b).sum(axis=1) for a, b in ((x, x), (x, y), (y, y)))
            px, py = (off * x).sum(axis=1), (off * y).sum(axis=1)
            whole = np.maximum(xx * yy - xy * xy, 1e-30)
            step = np.column_stack(((px * yy - py * xy) / whole, (xx * py - xy * px) / whole))
            after = np.clip(at + step, low, high)
            moved = float(np.abs(after - at).max(initial=0.0))
            at = after
            if moved <= 1e-14 * float(np.max(high - low)):
                break
        return at


Offset = Callable[[Array], tuple[Array, Array]]
"""Places of a chart, (n, 2), to points in space and outward normals, (n, 3); NaN where none is."""


def offset_of(surfaces: Sequence[BSplineSurface], chart: Chart) -> Offset:
    """Return what gives places and normals of surfaces over a chart, the first that is there."""

    def places(flat: Array) -> tuple[Array, Array]:
        points, normals = np.full((len(flat), 3), np.nan), np.full((len(flat), 3), np.nan)
        left = np.ones(len(flat), bool)
        for surface in surfaces:
            if not left.any():
                break
            at = parameters_at(surface, chart, flat[left], 1.0)
            found = np.isfinite(at).all(axis=1)
            rows = np.flatnonzero(left)[found]
            points[rows] = surface.value(*at[found].T)
            normals[rows] = surface.normals(*at[found].T)
            left[rows] = False
        return points, normals

    return places


def floor_under(
    places: Offset, ring: Array, height: float, size: float, reach: float = 0.0
) -> Floor:
    """Return the offset of what is inside a ring, by a height along its normals.

    Parameters
    ----------
    places : callable
        Points and normals over places of the chart.
    ring : (n, 2) float
        The outline in the chart.
    height : float
        mm, outward.
    size : float
        Of the whole, mm.
    reach : float
        How far beyond the ring the floor goes on, mm.

    Raises
    ------
    UserError
        If the surface bends more closely than the floor is deep.
    """
    import shapely

    low, high = ring.min(axis=0), ring.max(axis=0)
    slack = MARGIN * float((high - low).max())
    low, high = low - slack - reach, high + slack + reach
    area = shapely.Polygon(ring)
    region = area.buffer(0.25 * slack + reach)
    draws = np.random.default_rng(SEED).uniform(low, high, (600, 2))
    probes = np.vstack((draws[shapely.contains_xy(area, *draws.T)], ring[::3]))
    wanted = _lifted(places, probes, height)
    known = np.isfinite(wanted).all(axis=1)
    floor: BSplineSurface | None = None
    deviation = np.inf
    for spans in SPANS:
        count = int(PER_SPAN * spans) + 1
        x, y = (np.linspace(low[k], high[k], count) for k in range(2))
        flat = np.column_stack([grid.ravel() for grid in np.meshgrid(x, y, indexing="ij")])
        flat = flat[shapely.contains_xy(region, *flat.T)]
        weights = np.ones(len(flat) + len(ring))
        if reach > 0.0:
            weights[: len(flat)][~shapely.contains_xy(area, *flat.T)] = BEYOND
        flat = np.vstack((flat, ring))
        lifted = _lifted(places, flat, height)
        there = np.isfinite(lifted).all(axis=1)
        made = _fitted(flat[there], lifted[there], weights[there], low, high, spans)
        off = np.linalg.norm(made.value(*probes[known].T) - wanted[known], axis=1)
        if float(off.max()) < deviation:
            floor, deviation = made, float(off.max())
        if deviation <= NEAR * size:
            break
    assert floor is not None
    own, base = floor.normals(*probes[known].T), places(probes[known])[1]
    if float((own * base).sum(axis=1).min()) < 0.5:
        raise UserError(
            "The surface bends more closely here than the detail is deep. Make it less deep."
        )
    return Floor(floor, deviation)


def _lifted(places: Offset, flat: Array, height: float) -> Array:
    points, normals = places(flat)
    return points + height * normals


def _fitted(
    flat: Array, lifted: Array, weights: Array, low: Array, high: Array, spans: int
) -> BSplineSurface:
    """Return the cubic spline surface nearest to points over places, in the least squares sense."""
    from scipy.interpolate import BSpline
    from scipy.linalg import cho_factor, cho_solve

    knots = [
        np.concatenate((np.repeat(a, DEGREE), np.linspace(a, b, spans + 1), np.repeat(b, DEGREE)))
        for a, b in zip(low, high, strict=True)
    ]
    count = spans + DEGREE
    rows_x, rows_y = (
        BSpline.design_matrix(flat[:, k], knots[k], DEGREE).toarray() for k in range(2)
    )
    rows = np.einsum("na,nb->nab", rows_x, rows_y).reshape(len(flat), count * count)
    bend = np.diff(np.eye(count), 2, axis=0)
    bends = np.kron(bend, np.eye(count)), np.kron(np.eye(count), bend)
    weighted = weights[:, None] * rows
    matrix = weighted.T @ rows + STIFF * sum(b.T @ b for b in bends)
    matrix += 1e-14 * np.trace(matrix) / len(matrix) * np.eye(len(matrix))
    middle = lifted.mean(axis=0)
    points = cho_solve(cho_factor(matrix), weighted.T @ (lifted - middle)) + middle
    return BSplineSurface((DEGREE, DEGREE), knots[0], knots[1], points.reshape(count, count, 3))
