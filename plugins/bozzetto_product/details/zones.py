"""Regions over creases: the zones between creases, each of which is smooth."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import BSplineSurface, Trim
from bozzetto.plugin import cached_property
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.face_cuts import ring_of
from bozzetto_product.details.floor import Offset, offset_of
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.shell import Shell, is_crease, is_smooth

if TYPE_CHECKING:
    import shapely
    from scipy.spatial import cKDTree

BORDER: Final = 64
"""Places along a crease from which a zone is continued beyond it."""

SHARPEST: Final = -0.99
"""Cosine between normals beyond which a floor does not go on over a crease."""

JOINED: Final = 1e-9
"""Share of the extent of a region by which faces of a zone may seem to lie apart."""

FADES: Final = (
    "An edge under the outline is a crease in one part and smooth in another. Make it smooth, or "
    "a crease all along, first."
)


@dataclass(frozen=True, eq=False)
class CreaseEdge:
    """An edge at which two zones meet.

    Parameters
    ----------
    edge : int
        Of the shell that was cut.
    zones : (int, int)
        Of the face that runs it forward, and of the one that runs it back.
    sides : (Trim, Trim)
        Of these faces.
    surfaces : (BSplineSurface, BSplineSurface)
        Of them.
    """

    edge: int
    zones: tuple[int, int]
    sides: tuple[Trim, Trim]
    surfaces: tuple[BSplineSurface, BSplineSurface]

    def normals(self, at: Array) -> tuple[Array, Array]:
        """Return the unit normals on both sides at parameters of the edge, (n, 3) each."""
        one, two = (
            surface.normals(*side.curve.value(at).T)
            for surface, side in zip(self.surfaces, self.sides, strict=True)
        )
        return one, two


@dataclass(frozen=True, eq=False)
class Zone:
    """Faces of a region that meet smoothly.

    Parameters
    ----------
    chart : Chart
        Over the region.
    surfaces : tuple of BSplineSurface
        Of its faces.
    area : Polygon
        In the chart.
    border : (n, 2), (n, 3), (n, 3) float
        Places of its creases in the chart and in space, mm, with its normals there.
    """

    chart: Chart
    surfaces: tuple[BSplineSurface, ...]
    area: shapely.Polygon
    border: tuple[Array, Array, Array]

    @property
    def outline(self) -> Array:
        """The border of its area, without holes, (n, 2)."""
        return np.asarray(self.area.exterior.coords)[:-1]

    @cached_property
    def offset(self) -> Offset:
        """Places and normals over the chart; beyond its surfaces those of its tangent planes."""
        own = offset_of(self.surfaces, self.chart)
        flat, points, normals = self.border

        def places(at: Array) -> tuple[Array, Array]:
            found, up = own(at)
            missing = np.flatnonzero(~np.isfinite(found).all(axis=1))
            if len(missing):
                near = np.asarray(self._tree.query(at[missing])[1], int)
                way = (at[missing] - flat[near]) @ self.chart.axes[:2]
                n = normals[near]
                rise = (way * n).sum(axis=1) / (n @ self.chart.normal)
                found[missing] = points[near] + way - rise[:, None] * self.chart.normal
                up[missing] = n
            return found, up

        return places

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self.border[0])


@dataclass(frozen=True, eq=False)
class ZonedRegion:
    """A region in zones.

    Parameters
    ----------
    zones : tuple of Zone
    of_face : dict
        Number of the zone of each face inside.
    creases : tuple of CreaseEdge
    """

    zones: tuple[Zone, ...]
    of_face: dict[int, int]
    creases: tuple[CreaseEdge, ...]

    @cached_property
    def steepness(self) -> float:
        """How far from a crease floors of height one meet, at most."""
        least = 1.0
        for crease in self.creases:
            one, two = crease.normals(np.linspace(*crease.sides[0].curve.range, BORDER))
            least = min(least, float((one * two).sum(axis=1).min()))
        least = max(least, SHARPEST)
        return float(np.sqrt((1.0 - least) / (1.0 + least)))

    @cached_property
    def offset(self) -> Offset:
        """Places and normals over the chart, each of the zone that it is in, or nearest to."""
        import shapely

        def places(at: Array) -> tuple[Array, Array]:
            spots = shapely.points(at)
            gaps = np.stack([shapely.distance(zone.area, spots) for zone in self.zones])
            which = np.argmin(gaps, axis=0)
            found, up = np.empty((len(at), 3)), np.empty((len(at), 3))
            for number, zone in enumerate(self.zones):
                rows = which == number
                if rows.any():
                    found[rows], up[rows] = zone.offset(at[rows])
            return found, up

        return places


def creases_within(shell: Shell, chart: Chart, ring: Ring, faces: Sequence[int]) -> bool:
    """Whether a crease of faces seems to lie within an outline, seen in the chart."""
    import shapely

    area = shapely.Polygon(ring.polyline[:-1])
    shapely.prepare(area)
    own = set(faces)
    seen: set[int] = set()
    for number in faces:
        for trim in shell.faces[number].trims:
            if trim.edge is None or trim.edge in seen:
                continue
            seen.add(trim.edge)
            users = shell.users[trim.edge]
            if any(n not in own or shell.owners[n].is_wall for n, _ in users):
                continue
            if not is_crease(shell, trim.edge):
                continue
            line = shapely.LineString(chart.flat(shell.edges[trim.edge].polyline(8)[1]))
            if area.intersects(line):
                return True
    return False


def zones_of(shell: Shell, chart: Chart, inside: Iterable[int]) -> ZonedRegion:
    """Return the zones of faces of a shell.

    Raises
    ------
    UserError
        If a crease fades out inside.
    """
    from scipy.cluster.hierarchy import DisjointSet

    faces = sorted(inside)
    own = set(faces)
    sets = DisjointSet(faces)
    sharp: list[tuple[int, int, Trim, int, Trim]] = []
    for edge, users in shell.users.items():
        if len(users) != 2 or any(number not in own for number, _ in users):
            continue
        (one, first), (other, second) = users if users[0][1].forward else users[::-1]
        if is_smooth(shell, one, first, other, second):
            sets.merge(one, other)
        else:
            sharp.append((edge, one, first, other, second))
    roots = list(dict.fromkeys(sets[face] for face in faces))
    of_face = {face: roots.index(sets[face]) for face in faces}
    creases = tuple(
        CreaseEdge(
            edge,
            (of_face[one], of_face[other]),
            (first, second),
            (shell.faces[one].surface, shell.faces[other].surface),
        )
        for edge, one, first, other, second in sharp
    )
    if any(crease.zones[0] == crease.zones[1] for crease in creases):
        raise UserError(FADES)
    zones = [
        _zone(shell, chart, [f for f in faces if of_face[f] == number], number, creases)
        for number in range(len(roots))
    ]
    return ZonedRegion(tuple(zones), of_face, creases)


def _zone(
    shell: Shell, chart: Chart, faces: Sequence[int], number: int, creases: Sequence[CreaseEdge]
) -> Zone:
    import shapely

    areas = []
    for face in (shell.faces[k] for k in faces):
        rings = [chart.flat(face.surface.value(*ring_of(loop).T)) for loop in face.loops]
        areas.append(shapely.Polygon(rings[0], rings[1:]).buffer(0.0))
    near = JOINED * float(np.ptp(np.reshape([a.bounds for a in areas], (-1, 2)), axis=0).max())
    area = shapely.union_all([one.buffer(near, join_style="mitre") for one in areas])
    if area.geom_type != "Polygon":
        raise UserError(FADES)
    rows = []
    for crease in creases:
        for zone, side, surface in zip(crease.zones, crease.sides, crease.surfaces, strict=True):
            if zone == number:
                at = side.curve.value(np.linspace(*side.curve.range, BORDER))
                points = surface.value(*at.T)
                rows.append((chart.flat(points), points, surface.normals(*at.T)))
    border = tuple(np.concatenate(row) for row in zip(*rows, strict=True)) if rows else ()
    surfaces = tuple({id(s): s for s in (shell.faces[k].surface for k in faces)}.values())
    return Zone(chart, surfaces, area, border)  # type: ignore[arg-type]
