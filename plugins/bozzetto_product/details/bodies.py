"""Bodies with details: all that are visible, one after another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import sewn
from bozzetto.plugin import remembered
from bozzetto.scene import Hits, Layer, Scene, Shaded, cast_rays
from bozzetto.view import Rays
from bozzetto_product.details.carve import Form, Near, Thickness, carved, parted
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.course import CROSSES
from bozzetto_product.details.emblem_places import LOST, emblem_outlines
from bozzetto_product.details.floor_places import LaidFloor, on_floors
from bozzetto_product.details.ground import (
    FollowedOutline,
    Ground,
    followed_outline,
    kept_places,
)
from bozzetto_product.details.region import faces_over
from bozzetto_product.details.ring import Ring, ring_through
from bozzetto_product.details.shell import Owner, Shell
from bozzetto_product.model.details import Detail, OutlinePlaces
from bozzetto_product.model.emblems import Emblem, FlatOutlines
from bozzetto_product.model.planes import Plane
from bozzetto_product.network.reflection import Reflection

BEHIND: Final = 1e-4
"""Share of the size behind a surface from which on its far side is sought."""

THIN: Final = 1e-7
"""Share of the size by which rays go on behind a triangle."""

LAYERS: Final = 4
"""Triangles in front of the far side that a ray may meet: those of the surface's own side, for
triangles lie a little beside a surface."""

FLOORED: Final = ("in", "raised")
"""Kinds of details that move all that is inside."""

OFF: Final = "The outline is on no surface. Draw it on a surface."
UNDRAWN: Final = "it has no outline. Draw it with the tool “Detail”."
ASIDE: Final = "a surface under it is gone; it lies on those beside it."
OPEN: Final = (
    "its outline is open, so it only splits the surface. Draw a closed round to press it in, "
    "raise it or cut it out."
)
EMPTY: Final = "its outline encloses no area, or crosses itself. Draw it again, as one round."


@dataclass(frozen=True, eq=False)
class SolvedDetail:
    """A detail of the recipe, or its mirror image.

    Parameters
    ----------
    detail : Detail
    mirrored : bool
        It is the mirror image.
    outlines : tuple of (n, 3) float
        Polylines on the surface, mm.
    problem : str
        Why it is not carved, for a person; "" where it is.
    told : str
        What a person must know of it besides.
    deviation : float
        Largest distance of its floor from the true offset, mm.
    """

    detail: Detail
    mirrored: bool
    outlines: tuple[Array, ...] = ()
    problem: str = ""
    told: str = ""
    deviation: float = 0.0

    @property
    def name(self) -> str:
        """Name for people and files."""
        return f"{self.detail.name} mirrored" if self.mirrored else self.detail.name


@dataclass(frozen=True, eq=False)
class DetailedBodies:
    """Surfaces with details.

    Parameters
    ----------
    shells : tuple of Shell
        Of surfaces that hang together; their owners count grounds and `details`.
    details : tuple of SolvedDetail
    plain : tuple of Shell
        The same surfaces without details.
    grounds : tuple of Ground
        What they lie on.
    floors : tuple of LaidFloor
        Those of the details, as they were made.
    """

    shells: tuple[Shell, ...] = ()
    details: tuple[SolvedDetail, ...] = ()
    plain: tuple[Shell, ...] = ()
    grounds: tuple[Ground, ...] = ()
    floors: tuple[LaidFloor, ...] = ()

    def number_of(self, detail: Detail, mirrored: bool) -> int:
        """Return the number of a detail, or of its mirror image."""
        rows = ((one.detail, one.mirrored) for one in self.details)
        return next(k for k, row in enumerate(rows) if row == (detail, mirrored))

    @property
    def changed(self) -> tuple[Shell, ...]:
        """The shells that have details."""
        pairs = zip(self.shells, self.plain, strict=True)
        return tuple(shell for shell, plain in pairs if shell is not plain)


def detailed_bodies(
    grounds: Sequence[Ground],
    details: Sequence[Detail],
    symmetry: Plane,
    checkpoint: Callable[[], None] = lambda: None,
) -> DetailedBodies:
    """Return bodies with details carved in their order; a mirror image after its detail.

    What has a floor comes before what it encloses, which then lies on that floor. What cannot be
    carved is left as it is and told by its `SolvedDetail.problem`.
    """
    made = _plain_bodies(tuple(grounds))
    for detail in _enclosing_first(tuple(grounds), details):
        for mirrored in (False, True) if detail.mirrored else (False,):
            checkpoint()
            made = _with_detail(made, tuple(grounds), detail, mirrored, symmetry)
    return made


def _enclosing_first(grounds: tuple[Ground, ...], details: Sequence[Detail]) -> list[Detail]:
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
    followed, own = (_followed(grounds, places, None) for places in (around, within))
    if followed is None or own is None:
        return False
    laid = _laid(followed, (), around, True)
    if laid.chart is None or (own.normals @ laid.chart.normal <= 0.0).any():
        return False
    flat = laid.chart.flat(own.points)
    areas = (
        shapely.Polygon(rings[0].polyline[:-1], [ring.polyline[:-1] for ring in rings[1:]])
        for rings in laid.regions
    )
    return any(bool(shapely.contains_xy(area, *flat.T).all()) for area in areas)


@remembered(limit=4, key=lambda grounds: tuple((g.patch, g.mirrored, g.fill.key) for g in grounds))
def _plain_bodies(grounds: tuple[Ground, ...]) -> DetailedBodies:
    """Return the bodies without details: what those with details are remembered by."""
    plain = _shells(grounds)
    return DetailedBodies(plain, plain=plain, grounds=grounds)


@remembered(limit=4, key=lambda grounds: tuple(g.fill.key for g in grounds))
def _shells(grounds: tuple[Ground, ...]) -> tuple[Shell, ...]:
    if not grounds:
        return ()
    whole = sewn([one.fill.brep for one in grounds])
    owners = [Owner(k) for k, one in enumerate(grounds) for _ in one.fill.patches]
    return tuple(
        Shell(
            whole.edges,
            tuple(whole.faces[k] for k in piece.tolist()),
            tuple(owners[k] for k in piece.tolist()),
        )
        for piece in whole.pieces
    )


@remembered(
    limit=64,
    key=lambda made, grounds, detail, mirrored, symmetry: (
        made,
        detail,
        mirrored,
        symmetry,
        tuple((g.patch, g.mirrored, g.fill.key) for g in grounds),
    ),
)
def _with_detail(
    made: DetailedBodies,
    grounds: tuple[Ground, ...],
    detail: Detail,
    mirrored: bool,
    symmetry: Plane,
) -> DetailedBodies:
    number = len(made.details)
    if detail.places is None:
        row = SolvedDetail(detail, mirrored, problem=UNDRAWN)
        return replace(made, details=(*made.details, row))
    plane = symmetry if mirrored else None
    try:
        places = outline_of(detail, grounds)
    except UserError as error:
        row = SolvedDetail(detail, mirrored, problem=str(error))
        return replace(made, details=(*made.details, row))
    followed = _followed(grounds, places, plane)
    if followed is None:
        row = SolvedDetail(detail, mirrored, problem=LOST)
        return replace(made, details=(*made.details, row))
    *_, under = on_floors(made.floors, followed.points, followed.normals, places.starts.tolist())
    laid = _laid(followed, under, places, detail.closed)
    told = ASIDE if laid.lost else ""
    if isinstance(detail, Emblem) and detail.flat is not None and detail.flat.missing:
        told = f"there are no letters for “{detail.flat.missing}”; it is written without."
    if not detail.closed and detail.kind != "split":
        told = OPEN
    solved = SolvedDetail(detail, mirrored, laid.outlines, laid.problem, told)
    shells, floors = list(made.shells), list[LaidFloor]()
    try:
        form = Form(detail.kind, detail.depth, float(np.radians(detail.draft)), detail.gap)
        for region in laid.regions:
            chart, near = laid.chart, laid.near
            assert chart is not None
            assert near is not None
            which = _shell_under(shells, chart, region[0], near)
            if which < 0:
                under = _shell_under(made.plain, chart, region[0], near)
                raise UserError(OFF if under < 0 else CROSSES)
            if detail.closed:
                done = carved(shells[which], chart, region, near, form, _thickness(grounds), number)
            else:
                done = parted(shells[which], chart, region[0], near, number)
            shells[which] = done.shell
            floors += () if done.floor is None else (done.floor,)
    except UserError as error:
        return replace(made, details=(*made.details, replace(solved, problem=str(error))))
    row = replace(solved, deviation=max((f.floor.deviation for f in floors), default=0.0))
    return replace(
        made,
        shells=tuple(shells),
        details=(*made.details, row),
        floors=(*made.floors, *floors),
    )


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
class _Laid:
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
def _followed(
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
def _laid(
    followed: FollowedOutline,
    floors: tuple[LaidFloor, ...],
    places: OutlinePlaces,
    closed: bool,
) -> _Laid:
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
        return _Laid(outlines, followed.lost, str(error))
    near = _nearest_of(chart, points)
    return _Laid(outlines, followed.lost, "", chart, near, tuple(map(tuple, regions)))


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


def _shell_under(shells: Sequence[Shell], chart: Chart, ring: Ring, near: Near) -> int:
    """Return the number of the shell that an outline lies on; −1 where there is none."""
    place = ring.value(np.array([0.0 if ring.closed else 0.5 * ring.end]))[0]
    point = near(place)
    best, found = np.inf, -1
    for number, shell in enumerate(shells):
        for _, where in faces_over(shell, chart, place, 1.0):
            gap = float(np.linalg.norm(where - point))
            if gap < best:
                best, found = gap, number
    return found


def _outward(grounds: Sequence[Ground], hits: Hits) -> Array:
    """Return outward normals of triangles that rays hit, (n, 3); 0 where they hit none."""
    made = np.zeros((len(hits.hit), 3))
    for number, surface in enumerate(hits.surfaces):
        rows = hits.hit & (hits.on == number)
        mesh = grounds[surface.number].fill.mesh
        a, b, c = mesh.vertices.astype(float)[mesh.faces[hits.faces[rows]]].transpose(1, 0, 2)
        made[rows] = cross_product(b - a, c - a)
    return made


@remembered(limit=4, key=lambda grounds: tuple(g.fill.key for g in grounds))
def _thickness(grounds: tuple[Ground, ...]) -> Thickness:
    """Return what measures bodies behind points of their surface."""
    scene = Scene((Layer("surfaces", tuple(Shaded(g.fill.mesh) for g in grounds)),))
    size = max(float(np.linalg.norm(np.ptp(g.fill.mesh.bounds, axis=0))) for g in grounds)

    def thickness(points: Array, normals: Array) -> Array:
        if not len(points):
            return np.empty(0)
        depth = np.full(len(points), BEHIND * size)
        going = np.arange(len(points))
        for _ in range(LAYERS):
            starts = points[going] - depth[going, None] * normals[going]
            hits = cast_rays(scene, Rays(starts, -normals[going]))
            depth[going] += np.where(hits.hit, hits.distance, np.inf)
            entered = hits.hit & ((_outward(grounds, hits) * normals[going]).sum(axis=1) > 0.0)
            going = going[entered]
            depth[going] += THIN * size
            if not len(going):
                break
        return depth

    return thickness
