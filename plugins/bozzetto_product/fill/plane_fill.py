"""Fills of loops that lie in a plane: one rectangle of it, trimmed by the outlines of the loop."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Flags, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Brep, BSplineSurface, Mesh, triangulate
from bozzetto.plugin import cached_property, override
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.fill_brep import plane_brep_of, plane_parameters
from bozzetto_product.fill.fill_mesh import boundary_samples
from bozzetto_product.fill.half_sides import HalfSide, Side
from bozzetto_product.fill.loop_frame import LoopSides
from bozzetto_product.fill.normal_field import across
from bozzetto_product.fill.patch_fill import PatchFill, patch_fill
from bozzetto_product.fill.ring_triangles import Inside, even_triangles
from bozzetto_product.network.flat_places import plane_through
from bozzetto_product.network.net import Loop

if TYPE_CHECKING:
    import shapely

LEAST_WIDTH: Final = 1e-6
"""Least area of a loop, as share of the square of its size: below it there is no plane to find."""

RING_SAMPLES: Final = 33
"""Places along each piece of an edge at which crossings are looked for."""

SHORT_CHORD: Final = 0.02
"""Length of the first edge's chord, as share of the size, below which it tells no direction."""

MOST_INSIDE: Final = 2500
"""About how many vertices a mesh has inside: a plane needs no more, however long its border."""

KNOTS: Final = np.array((0.0, 0.0, 1.0, 1.0))
"""Those of a rectangle in u and in v."""


@dataclass(frozen=True, eq=False)
class PlaneFill(Fill):
    """A plane within a loop.

    Parameters
    ----------
    loop, sides, spacing, key
        See `Fill`; the sides of holes come behind those of the outline.
    patches : tuple of BSplineSurface
        The rectangle around the loop.
    starts : tuple of int
        First side of each outline.
    """

    starts: tuple[int, ...] = (0,)

    @property
    def outlines(self) -> tuple[tuple[Side, ...], ...]:
        """The sides of the outline round the plane, and those of each hole in it."""
        ends = itertools.pairwise((*self.starts, len(self.sides)))
        return tuple(self.sides[a:b] for a, b in ends)

    @property
    def plane(self) -> BSplineSurface:
        """The rectangle around the loop; u runs along the chord of the first edge."""
        return self.patches[0]

    @property
    @override
    def size(self) -> float:
        """Diagonal of the rectangle, mm."""
        net = self.plane.control_points
        return float(np.linalg.norm(net[1, 1] - net[0, 0]))

    @cached_property
    def normal(self) -> Array:
        """Unit, (3,)."""
        net = self.plane.control_points
        normal = cross_product(net[1, 0] - net[0, 0], net[0, 1] - net[0, 0])
        return np.asarray(normal / np.linalg.norm(normal))

    @cached_property
    @override
    def mesh(self) -> Mesh:
        """Triangles with normals; vertices on an edge are those of all fills that have it."""
        borders = [boundary_samples(sides, self.spacing)[1] for sides in self.outlines]
        border = np.concatenate(borders)
        rings = [self._flat(each) for each in borders]
        inside = _polygon(rings)
        steps = [np.linalg.norm(ring - np.roll(ring, -1, axis=0), axis=1) for ring in rings]
        apart = float(np.concatenate(steps).mean())
        apart = max(apart, float(np.sqrt(inside.area / MOST_INSIDE)))
        centre = rings[0].mean(axis=0)
        if len(rings) > 1:
            centre = np.array(inside.representative_point().coords[0])
        made = even_triangles(rings, apart, centre, _inside(inside))
        if made is None:
            made = rings[0][:0], triangulate(rings[0], tuple(rings[1:])).triangles
        inner, triangles = made
        net = self.plane.control_points
        x, y = net[1, 0] - net[0, 0], net[0, 1] - net[0, 0]
        shares = inner / (np.linalg.norm(x), np.linalg.norm(y))
        vertices = np.concatenate((border, net[0, 0] + shares @ np.stack((x, y))))
        normals = np.broadcast_to(self.normal, vertices.shape)
        return Mesh(
            vertices.astype(np.float32), triangles.astype(np.int32), normals.astype(np.float32)
        )

    @cached_property
    @override
    def brep(self) -> Brep:
        """The plane as one face; its edges are the pieces of the loop's edges."""
        return plane_brep_of(self.outlines, self.plane, "surface")

    @property
    @override
    def folded(self) -> bool:
        """A plane never is."""
        return False

    @property
    @override
    def has_holes(self) -> bool:
        """Whether it has more outlines than one."""
        return len(self.starts) > 1

    @cached_property
    @override
    def bent(self) -> PatchFill | None:
        """The same surface as patches, which can be bent; None where these would fold.

        And where it has holes, for patches have one outline.
        """
        if self.has_holes:
            return None
        try:
            fill = patch_fill(LoopSides.of(self.sides), self.loop, self.spacing, self.key)
        except UserError:
            return None
        return None if fill.folded else fill

    @override
    def places_beside(self, half: HalfSide, number: int, at: Array) -> tuple[Array, Array]:
        """Return places of the plane beside half a side, and its normal; see `Fill`."""
        del number
        places = half.value(at)
        off = (places - self.plane.control_points[0, 0]) @ self.normal
        places = places - off[:, None] * self.normal
        return places, np.broadcast_to(self.normal, places.shape)

    def nearest_within(self, points: Array) -> Array:
        """Return u and v, (n, 2), of the places within the plane that are nearest to points."""
        import shapely

        at = plane_parameters(self.plane, points)
        flat = at * self._lengths
        outline = _polygon([self._flat(_ring_of(sides)) for sides in self.outlines])
        out = np.flatnonzero(~_inside(outline)(flat))
        if len(out):
            ways = shapely.shortest_line(outline, shapely.points(flat[out]))
            at[out] = shapely.get_coordinates(ways)[::2] / self._lengths
        return np.clip(at, 0.0, 1.0)

    @cached_property
    def _lengths(self) -> Array:
        net = self.plane.control_points
        sides = np.stack((net[1, 0] - net[0, 0], net[0, 1] - net[0, 0]))
        return np.asarray(np.linalg.norm(sides, axis=1))

    def _flat(self, points: Array) -> Array:
        """Return points in the plane's own coordinates, mm, (n, 2)."""
        return plane_parameters(self.plane, points) * self._lengths


def plane_fill(
    outlines: Sequence[Sequence[Side]], loop: Loop, spacing: float, key: bytes
) -> PlaneFill | None:
    """Fill a loop by its plane.

    Parameters
    ----------
    outlines : sequence of sequence of Side
        The sides of its outline, and of each hole.
    loop, spacing, key
        See `Fill`.

    Returns
    -------
    PlaneFill or None
        None where the loop lies in no plane, encloses no area, or crosses itself, be it only as the
        mesh has it.
    """
    sides = tuple(side for each in outlines for side in each)
    points = np.concatenate([half.points for side in sides for half in side.halves])
    lying = plane_through(points)
    if lying is None:
        return None
    middle, normal = lying
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    x = _direction(outlines[0], normal, size)
    corners = np.stack((x, cross_product(normal, x)))
    inside = _polygon([(_ring_of(each) - middle) @ corners.T for each in outlines])
    if not inside.is_valid or inside.area <= LEAST_WIDTH * size**2:
        return None
    borders = [boundary_samples(each, spacing)[1] for each in outlines]
    if not _polygon([(border - middle) @ corners.T for border in borders]).is_valid:
        return None
    if not inside.exterior.is_ccw:
        corners[1] = -corners[1]
    flat = (points - middle) @ corners.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    net = np.array(
        [[middle + (u, v) @ corners for v in (low[1], high[1])] for u in (low[0], high[0])]
    )
    plane = BSplineSurface((1, 1), KNOTS, KNOTS, net)
    starts = tuple(itertools.accumulate((len(each) for each in outlines[:-1]), initial=0))
    return PlaneFill(loop, sides, (plane,), spacing, key, starts)


def _direction(sides: Sequence[Side], normal: Array, size: float) -> Array:
    """Return a unit vector in the plane: along the first edge, or an axis where that is closed."""
    chord = np.zeros(3)
    for piece in (piece for side in sides for half in side.halves for piece in half.pieces):
        if piece.half_edge == 0:
            ends = piece.piece.curve.control_points[[0, -1]]
            chord += (ends[1] - ends[0]) * (1.0 if piece.forward else -1.0)
    if float(np.linalg.norm(chord)) < SHORT_CHORD * size:
        chord = np.eye(3)[np.argmin(np.abs(normal))]
    return np.asarray(across(chord[None], normal[None])[0])


def _ring_of(sides: Sequence[Side]) -> Array:
    """Return places once round a loop, (n, 3)."""
    rows = []
    for side in sides:
        for half in side.halves:
            share = np.linspace(0.0, 1.0, RING_SAMPLES)[:-1]
            steps = np.diff(half.breaks)
            at = (half.breaks[:-1, None] + steps[:, None] * share).ravel()
            places = half.value(at) if half.onward else half.value(np.append(at, 1.0))[:0:-1]
            rows.append(places)
    return np.concatenate(rows)


def _polygon(rings: Sequence[Array]) -> shapely.Polygon:
    """Return what is within the first of some rings, and outside of the others."""
    import shapely

    return shapely.Polygon(rings[0], rings[1:])


def _inside(outline: shapely.Polygon) -> Inside:
    import shapely

    shapely.prepare(outline)

    def inside(places: Array) -> Flags:
        return np.asarray(shapely.contains_xy(outline, places[:, 0], places[:, 1]))

    return inside
