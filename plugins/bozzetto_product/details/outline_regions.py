"""Outlines of details on surfaces as they are now, as regions of a chart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.emblem_places import emblem_outlines
from bozzetto_product.details.floor_places import LaidFloor, on_floors
from bozzetto_product.details.form import Near
from bozzetto_product.details.ground import (
    FollowedOutline,
    Ground,
    followed_outline,
    kept_places,
)
from bozzetto_product.details.ring import Ring, ring_through
from bozzetto_product.model.details import Detail, OutlinePlaces
from bozzetto_product.model.emblems import Emblem, FlatOutlines
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.reflection import Reflection

if TYPE_CHECKING:
    import shapely

FLOORED: Final = ("in", "raised")
"""Kinds of details that move all that is inside."""

SAME: Final = 1e-9
"""Distance of neighbours below which they are one point, as share of the outline's size."""

EMPTY: Final = "its outline encloses no area, or crosses itself. Draw it again, as one round."


def outline_of(detail: Detail, grounds: tuple[Ground, ...]) -> OutlinePlaces:
    """Return the places of a detail's outlines; those of an emblem are laid on the surfaces.

    Raises
    ------
    UserError
        If an emblem has no outlines, or they are beside the surfaces.
    """
    assert detail.places is not None
    if not isinstance(detail, Emblem):
        return detail.places
    assert detail.flat is not None or not detail.text
    return _emblem_places(detail.places, detail.flat, detail.height, detail.turn, grounds)


@remembered(
    limit=64,
    key=lambda places, flat, height, turn, grounds: (
        places,
        flat,
        height,
        turn,
        tuple((g.patch, g.mirrored, g.fill.key) for g in grounds),
    ),
)
def _emblem_places(
    places: OutlinePlaces,
    flat: FlatOutlines | None,
    height: float,
    turn: float,
    grounds: tuple[Ground, ...],
) -> OutlinePlaces:
    text = "" if flat is None else flat.text
    emblem = Emblem(places=places, flat=flat, height=height, turn=turn, text=text)
    rows = emblem_outlines(emblem, grounds)
    assert flat is not None
    return kept_places(grounds, np.concatenate(rows), flat.corners > 0, flat.starts.tolist())


@dataclass(frozen=True, eq=False)
class LaidOutlines:
    """Outlines on the surfaces as they are now.

    Parameters
    ----------
    outlines : tuple of (n, 3) float
        Polylines, mm.
    lost : tuple of str
        Ids of patches that are gone.
    problem : str
        Why there are no regions, for a person.
    chart : Chart, optional
        None with a problem, as is `near`.
    near : callable, optional
        See `Near`.
    regions : tuple of tuple of Ring
        The outline round each region, and those of holes in it; of an open outline itself.
    """

    outlines: tuple[Array, ...]
    lost: tuple[str, ...]
    problem: str = ""
    chart: Chart | None = None
    near: Near | None = None
    regions: tuple[tuple[Ring, ...], ...] = ()


@remembered(
    limit=128,
    key=lambda grounds, places, plane: (
        places,
        plane,
        tuple((g.patch, g.mirrored, g.fill.key) for g in grounds),
    ),
)
def followed_places(
    grounds: tuple[Ground, ...], places: OutlinePlaces, plane: Plane | None
) -> FollowedOutline | None:
    """Return where outlines are now, or their mirror images; None where their surfaces are gone."""
    followed = followed_outline(grounds, places)
    if followed is None or plane is None:
        return followed
    mirror = Reflection(plane)
    normals = followed.normals
    return FollowedOutline(
        mirror.points(followed.points),
        normals - 2.0 * (normals @ mirror.normal)[:, None] * mirror.normal,
        followed.lost,
    )


@remembered(
    limit=128,
    key=lambda followed, floors, places, closed: (
        followed,
        tuple(floor.floor for floor in floors),
        places,
        closed,
    ),
)
def laid_outlines(
    followed: FollowedOutline,
    floors: tuple[LaidFloor, ...],
    places: OutlinePlaces,
    closed: bool,
) -> LaidOutlines:
    """Return outlines on surfaces, or on floors, as regions of a chart."""
    points, normals, _ = on_floors(
        floors, followed.points, followed.normals, places.starts.tolist()
    )
    pieces = np.split(np.arange(len(points)), places.starts[1:].tolist())
    outlines = tuple(
        np.vstack((points[rows], points[rows[:1]])) if closed else points[rows] for rows in pieces
    )
    corners = places.corners > 0
    try:
        chart = Chart.facing(points, normals)
        if closed:
            regions = _regions(chart, points, corners, pieces)
        else:
            regions = [[_ring(chart.flat(points), corners, closed=False)]]
    except UserError as error:
        return LaidOutlines(outlines, followed.lost, str(error))
    near = _nearest_of(chart, points)
    return LaidOutlines(outlines, followed.lost, "", chart, near, tuple(map(tuple, regions)))


def _nearest_of(chart: Chart, points: Array) -> Near:
    """Return what gives for a place of the chart the point of the outlines nearest to it."""
    flat = chart.flat(points)
    return lambda place: points[int(np.argmin(((flat - place) ** 2).sum(axis=1)))]


def _regions(
    chart: Chart, points: Array, corners: Flags, pieces: Sequence[Index]
) -> list[list[Ring]]:
    """Return outlines as regions: each the outline round it, and those of holes in it.

    An outline inside an odd number of others is a hole.

    Raises
    ------
    UserError
        If an outline encloses no area, or outlines cross.
    """
    import shapely

    flat = chart.flat(points)
    rings = [_ring(flat[rows], corners[rows], closed=True) for rows in pieces]
    polygons = [shapely.Polygon(ring.polyline[:-1]) for ring in rings]
    if any(not polygon.is_valid or not polygon.area > 0.0 for polygon in polygons):
        raise UserError(EMPTY)
    around = [
        [k for k, other in enumerate(polygons) if k != number and other.contains(polygon)]
        for number, polygon in enumerate(polygons)
    ]
    regions: dict[int, list[Ring]] = {}
    for number, ring in enumerate(rings):
        if len(around[number]) % 2 == 0:
            regions[number] = [_run(ring, leftward=True)]
    for number, ring in enumerate(rings):
        if len(around[number]) % 2:
            home = max(around[number], key=lambda k: len(around[k]))
            regions[home].append(_run(ring, leftward=False))
    for region in regions.values():
        rows = [ring.polyline[:-1] for ring in region]
        if not shapely.Polygon(rows[0], rows[1:]).is_valid:
            raise UserError(EMPTY)
    return list(regions.values())


def _ring(points: Array, corners: Flags, *, closed: bool) -> Ring:
    """Return the ring through points of a chart, of which some may be the one before again.

    Raises
    ------
    UserError
        If fewer differ than a line, or an outline, has.
    """
    least = SAME * float(np.linalg.norm(np.ptp(points, axis=0)))
    kept: list[int] = []
    for number in range(len(points)):
        if not kept or np.linalg.norm(points[number] - points[kept[-1]]) > least:
            kept.append(number)
    if closed and len(kept) > 1 and np.linalg.norm(points[kept[-1]] - points[kept[0]]) <= least:
        kept.pop()
    if len(kept) < (3 if closed else 2):
        raise UserError(EMPTY)
    return ring_through(points[kept], corners[kept], closed=closed)


def _run(ring: Ring, *, leftward: bool) -> Ring:
    import shapely

    return ring if shapely.LinearRing(ring.polyline[:-1]).is_ccw == leftward else ring.reversed()


def enclosing_first(grounds: tuple[Ground, ...], details: Sequence[Detail]) -> list[Detail]:
    """Return details in the order in which they are carved: what encloses others before these."""
    return [details[number] for number in _order(grounds, tuple(details))]


def _kept(detail: Detail) -> tuple[object, ...]:
    """Return what tells which details one encloses; its depth, draft and gap do not."""
    own = (detail.flat, detail.height, detail.turn) if isinstance(detail, Emblem) else ()
    return detail.places, detail.kind in FLOORED, detail.closed, own


@remembered(
    limit=8,
    key=lambda grounds, details: (
        tuple(map(_kept, details)),
        tuple((g.patch, g.mirrored, g.fill.key) for g in grounds),
    ),
)
def _order(grounds: tuple[Ground, ...], details: tuple[Detail, ...]) -> tuple[int, ...]:
    extents = [_extent(grounds, detail) for detail in details]
    row: list[int] = []
    for number, outer in enumerate(extents):
        places = (k for k, other in enumerate(row) if _encloses(outer, extents[other]))
        row.insert(next(places, len(row)), number)
    return tuple(row)


@dataclass(frozen=True, eq=False)
class _Extent:
    """The places of a detail's outlines, and where it is with a floor the areas inside.

    Parameters
    ----------
    followed : FollowedOutline
    chart : Chart, optional
        None without areas.
    areas : tuple of Polygon
        In the chart.
    """

    followed: FollowedOutline
    chart: Chart | None = None
    areas: tuple[shapely.Polygon, ...] = ()


def _extent(grounds: tuple[Ground, ...], detail: Detail) -> _Extent | None:
    """Return where a detail is; None where it has no outline."""
    import shapely

    if detail.places is None:
        return None
    try:
        places = outline_of(detail, grounds)
    except UserError:
        return None
    followed = followed_places(grounds, places, None)
    if followed is None or detail.kind not in FLOORED or not detail.closed:
        return None if followed is None else _Extent(followed)
    laid = laid_outlines(followed, (), places, True)
    areas = tuple(
        shapely.Polygon(rings[0].polyline[:-1], [ring.polyline[:-1] for ring in rings[1:]])
        for rings in laid.regions
    )
    shapely.prepare(areas)
    return _Extent(followed, laid.chart, areas)


def _encloses(outer: _Extent | None, inner: _Extent | None) -> bool:
    """Whether a detail with a floor goes round all of another one."""
    import shapely

    if outer is None or inner is None or outer.chart is None:
        return False
    points, normals = inner.followed.points, inner.followed.normals
    if (normals @ outer.chart.normal <= 0.0).any():
        return False
    flat = outer.chart.flat(points)
    return any(
        bool(shapely.contains_xy(area, *flat[0])) and bool(shapely.contains_xy(area, *flat.T).all())
        for area in outer.areas
    )
