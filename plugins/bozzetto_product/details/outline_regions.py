"""Outlines of details on surfaces as they are now, as regions of a chart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.plugin import remembered
from bozzetto_product.details.carve import Near
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.emblem_places import emblem_outlines
from bozzetto_product.details.floor_places import LaidFloor, on_floors
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

FLOORED: Final = ("in", "raised")
"""Kinds of details that move all that is inside."""

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
            regions = [[ring_through(chart.flat(points), corners, closed=False)]]
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
    rings = [ring_through(flat[rows], corners[rows]) for rows in pieces]
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


def _run(ring: Ring, *, leftward: bool) -> Ring:
    import shapely

    return ring if shapely.LinearRing(ring.polyline[:-1]).is_ccw == leftward else ring.reversed()


def enclosing_first(grounds: tuple[Ground, ...], details: Sequence[Detail]) -> list[Detail]:
    """Return details in the order in which they are carved: what encloses others before these."""
    row: list[Detail] = []
    for detail in details:
        places = (k for k, other in enumerate(row) if _encloses(grounds, detail, other))
        row.insert(next(places, len(row)), detail)
    return row


def _encloses(grounds: tuple[Ground, ...], outer: Detail, inner: Detail) -> bool:
    """Whether a detail with a floor goes round all of another one."""
    import shapely

    if outer.kind not in FLOORED or not outer.closed or None in (outer.places, inner.places):
        return False
    try:
        around, within = (outline_of(detail, grounds) for detail in (outer, inner))
    except UserError:
        return False
    followed, own = (followed_places(grounds, places, None) for places in (around, within))
    if followed is None or own is None:
        return False
    laid = laid_outlines(followed, (), around, True)
    if laid.chart is None or (own.normals @ laid.chart.normal <= 0.0).any():
        return False
    flat = laid.chart.flat(own.points)
    areas = (
        shapely.Polygon(rings[0].polyline[:-1], [ring.polyline[:-1] for ring in rings[1:]])
        for rings in laid.regions
    )
    return any(bool(shapely.contains_xy(area, *flat.T).all()) for area in areas)
