"""Where walls of a region end: on a floor, or on the far side of the body."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import BSplineSurface
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.course import TURNED
from bozzetto_product.details.floor import Floor, Offset, floor_under, offset_of
from bozzetto_product.details.joint_edges import Track
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.zones import Zone


@dataclass(frozen=True, eq=False)
class Level:
    """Where walls of a region end: on a floor, or on the far side of the body.

    Parameters
    ----------
    floor : Floor, optional
        None for a far side.
    places : callable
        Ring, parameters t, (n,), and the surface that is likely over them, to parameters of the
        floor, (n, 2); for a far side unused.
    rings : tuple of Ring
        For a far side: the outlines there.
    """

    floor: Floor | None
    places: Callable[[int, Array, BSplineSurface | None], Array] | None = None
    rings: tuple[Ring, ...] = ()


Ends = tuple[tuple[float, float] | None, tuple[float, float] | None]
"""Where the foot of a part of an outline begins and ends, as u and v; None where a level says."""


def track_on_floor(
    level: Level,
    number: int,
    count: int,
    run: tuple[float, float],
    over: BSplineSurface,
    ends: Ends = (None, None),
) -> Track:
    """Return the curve on the floor under a part of an outline.

    It is offset with the normals of the surface over it. Where surfaces meet a little off smooth
    these jump; so its ends are brought to places that both sides agree on, evenly along it.
    """
    assert level.floor is not None
    places = level.places
    assert places is not None
    start, end = run
    # At the end of a stretch it is that stretch whose offset counts, not the next one's.
    last = end - 1e-12 * max(1.0, abs(end))
    nodes = np.array((start, 0.0 if end == float(count) else end))
    agreed = places(number, nodes, None)
    for row, told in enumerate(ends):
        if told is not None:
            agreed[row] = told
    off = agreed - places(number, np.array((start, last)), over)

    def parameters(t: Array) -> Array:
        share = ((t - start) / (end - start))[:, None]
        own = places(number, np.clip(t, start, last), over)
        return np.asarray(own + (1.0 - share) * off[0] + share * off[1])

    return Track(level.floor.surface, parameters)


def floor_level(
    chart: Chart,
    rings: Sequence[Ring],
    surfaces: Sequence[BSplineSurface],
    height: float,
    draft: float,
    size: float,
) -> Level:
    """Return the floor of a region, and where its walls meet it.

    Parameters
    ----------
    chart : Chart
        Over the region.
    rings : sequence of Ring
        The outer outline first.
    surfaces : sequence of BSplineSurface
        Those of the region.
    height : float
        mm, outward.
    draft : float
        Angle between walls and normals, radians: the floor is smaller by it.
    size : float
        Of the whole, mm.
    """
    floor = floor_under(offset_of(surfaces, chart), rings[0].polyline[:-1], height, size)
    reach = abs(height) * np.tan(draft)

    def places(number: int, t: Array, over: BSplineSurface | None) -> Array:
        first = () if over is None else (over,)
        offset = offset_of((*first, *(one for one in surfaces if one is not over)), chart)
        targets = inset_points(chart, offset, rings[number], t, reach, height)
        return floor.nearest(targets, rings[number].value(t))

    return Level(floor, places)


def zone_level(
    zone: Zone, rings: Sequence[Ring], height: float, inward: float, size: float, reach: float
) -> Level:
    """Return the floor of a zone between creases, and where walls meet it.

    Walls lean on the floor itself, which is smooth, and goes on beyond the zone: over a crease the
    feet of walls slide along their own course.

    Parameters
    ----------
    zone : Zone
        What the floor is the offset of.
    rings : sequence of Ring
        The outer outline first.
    height, inward : float
        Of the floor, outward, and by which it is smaller, mm.
    size : float
        Of the whole, mm.
    reach : float
        How far the floor goes on beyond the zone, mm.
    """
    floor = floor_under(zone.offset, zone.outline, height, size, reach)
    surface = floor.surface

    def on_floor(flat: Array) -> tuple[Array, Array]:
        return surface.value(*flat.T), surface.normals(*flat.T)

    def places(number: int, t: Array, over: BSplineSurface | None) -> Array:
        flat = rings[number].value(t)
        if inward == 0.0:
            return flat
        targets = inset_points(zone.chart, on_floor, rings[number], t, inward, 0.0)
        return floor.nearest(targets, flat)

    return Level(floor, places)


def inset_points(
    chart: Chart,
    offset: Offset,
    ring: Ring,
    t: Array,
    reach: Array | float,
    height: float,
) -> Array:
    """Return points of an outline moved inward along the surface, and up along its normals, mm."""
    flat = ring.value(t)
    points, normals = offset(flat)
    if not np.isfinite(points).all():
        raise UserError(TURNED)
    way = ring.tangents(t) @ chart.axes[:2]
    # The tangent over which the chart sees that of the outline.
    along = way - ((way * normals).sum(axis=1) / (normals @ chart.normal))[:, None] * chart.normal
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    inward = cross_product(normals, along)
    left, on = ring.inset_by(t, reach)
    return np.asarray(points + left[:, None] * inward + on[:, None] * along + height * normals)
