"""Fillets: closed meshes that are united with two bodies, or taken away, to make a blend.

Only the surroundings of creases are polygonized, each by cells that suit its own reach. The
bodies keep their meshes, and what is far from a crease is not looked at.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.plugin import cached_property, remembered
from bozzetto_silhouette.implicit.composite import Composite, signature
from bozzetto_silhouette.implicit.fillet_solid import DEPTH, FilletSolid, layers
from bozzetto_silhouette.inflation.manifold_check import as_manifold, original_numbers
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.isotropic_remeshing import unit
from bozzetto_silhouette.solids.body import Body, meet, places_in
from bozzetto_silhouette.solids.polygonize import Surface, extract

if TYPE_CHECKING:
    from manifold3d import Manifold

FINENESS = 0.25
"""Cells as a share of the reach: a quarter circle gets about six."""

FINEST = 0.45
"""The same as a share of the spacing of the meshes, at least: smaller fillets are not seen."""

NARROW = 0.1
"""Share of the places along a crease where the reach may be smaller than the cells suit."""

MARGIN = 0.3
"""How far beyond the vertices where it tells a blend may be felt, as a share of the reach."""

MOST_CELLS = 160
"""Cells along the longest side of what is polygonized at a time."""

MOST_PLACES = 2500
"""Vertices that are asked for where a crease runs."""

CLIMBS = 12
"""Steps on the way from a place of a fillet to the crease."""

TOUCHING = 0.1
"""Gap, in cells, across which solids count as touching."""

STRIDE = 0.15
"""Length of such a step, as a share of the reach."""

BEYOND = 1.0
"""Values that a fillet meets, in reaches: those beyond are not blended."""


@dataclass(frozen=True, eq=False)
class Fillet:
    """A closed mesh around a crease.

    Attributes
    ----------
    surface : Surface
    cell : float
        Edge of the cells that it was polygonized in.
    """

    surface: Surface
    cell: float

    @cached_property
    def manifold(self) -> Manifold:
        """The mesh as manifold3d sees it."""
        return as_manifold(self.surface.vertices, self.surface.faces)

    @cached_property
    def box(self) -> Array:
        """Corners of the box around it, (2, 3)."""
        vertices = self.surface.vertices
        return np.stack([vertices.min(axis=0), vertices.max(axis=0)])

    @cached_property
    def numbers(self) -> set[int]:
        """The numbers under which manifold3d keeps its faces apart from others."""
        return original_numbers(self.manifold)


class _Zone(NamedTuple):
    """The surroundings of a crease: a box (2, 3), and the least reach that counts there."""

    box: Array
    reach: float


def common_box(first: Array, second: Array, margin: float) -> Array:
    """Return the box (2, 3) that two boxes have in common, larger by a margin on every side."""
    low, high = np.maximum(first[0], second[0]), np.minimum(first[1], second[1])
    return np.stack([low - margin, high + margin])


def fillets_between(
    solid: Composite,
    box: Array,
    bodies: Sequence[Body],
    step: float,
    checkpoint: Checkpoint = ignore,
) -> tuple[Fillet, ...]:
    """Return what the blend of a composite adds to the sharp result, or takes away.

    Parameters
    ----------
    solid : Composite
        With a blend above 0.
    box : (2, 3) float array
        Where both solids can be, and two reaches more.
    bodies : sequence of Body
        Of which both consist.
    step : float
        Spacing of the finer of the two meshes.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    tuple of Fillet
        Closed meshes. Those of a union are to be united with it; those of a carved solid are to
        be taken away, and those of an intersection, too.
    """
    near = tuple(body for body in bodies if meet(body.bounds, box))
    margin = np.array([[-solid.reach], [solid.reach]])
    local = solid.within(box + margin, BEYOND * solid.reach)
    return _between(solid, local, box, near, step, checkpoint)


def _asked_between(
    solid: Composite,
    local: Composite,
    box: Array,
    bodies: tuple[Body, ...],
    step: float,
    checkpoint: Checkpoint,
) -> Hashable:
    boxes = box, solid.first.bounds, solid.second.bounds
    marks = tuple(body.mark for body in bodies)
    return signature(local), marks, step, *(some.tobytes() for some in boxes)


# By the bodies, so that their vertices are not looked at again. Where one was made anew just as it
# was, the fillets are found by these.
@remembered(limit=512, key=_asked_between)
def _between(
    solid: Composite,
    local: Composite,
    box: Array,
    bodies: tuple[Body, ...],
    step: float,
    checkpoint: Checkpoint,
) -> tuple[Fillet, ...]:
    places = places_in(bodies, box)
    near = places[solid.felt(places)]
    if not len(near):
        return ()
    near = near[np.lexsort(near.T)]
    around = np.stack([near.min(axis=0) - solid.reach, near.max(axis=0) + solid.reach])
    return _made(local.within(around, BEYOND * solid.reach), near, step, checkpoint)


def _depends_on(solid: Composite, places: Array, step: float, checkpoint: Checkpoint) -> Hashable:
    """Return what a fillet depends on: the same, whatever was done to the rest of the tree."""
    return signature(solid), step, len(places), places.sum(axis=0).tobytes()


@remembered(limit=512, key=_depends_on)
def _made(
    solid: Composite, places: Array, step: float, checkpoint: Checkpoint
) -> tuple[Fillet, ...]:
    found = []
    for zone in _zones(solid, places[:: len(places) // MOST_PLACES + 1], step):
        checkpoint(0.6, "blend")
        longest = float(np.ptp(zone.box, axis=0).max())
        cell = max(FINENESS * zone.reach, FINEST * step, longest / MOST_CELLS)
        thin = FilletSolid(solid.within(zone.box, BEYOND * solid.reach), step, cell)
        surface = extract(thin, zone.box, cell, checkpoint)
        if solid.operation != "merge":
            surface = _on_creases(surface, solid, cell)
        if len(surface.faces):
            found.append(Fillet(surface, cell))
    return tuple(found)


def _zones(solid: Composite, places: Array, step: float) -> list[_Zone]:
    """Find where the blend tells, from places on the surfaces; zones whose boxes meet are one."""
    first, second, blended, reach = layers(solid, places)
    sharp = np.maximum(first.value, second.value)
    told = (sharp < DEPTH * reach) & (blended.value - sharp > 1e-3 * reach)
    told &= blended.value > -0.25 * reach
    points, reach = places[told], reach[told]
    if not len(points):
        return []
    pitch = max(float(np.quantile(reach, 0.5)), 2.0 * step)
    cells, cell = np.unique(np.floor(points / pitch).astype(np.int64), axis=0, return_inverse=True)
    near = np.argwhere(np.abs(cells[:, None] - cells).max(axis=2) <= 2)
    _, piece = connected_pieces(near[:, 0], near[:, 1], len(cells))
    number = piece[cell.ravel()]
    boxes, least = [], []
    for k in np.unique(number):
        mine = points[number == k]
        least.append(float(np.quantile(reach[number == k], NARROW)))
        margin = MARGIN * float(reach[number == k].max()) + 2.0 * max(
            FINEST * step, FINENESS * least[-1]
        )
        boxes.append(np.stack([mine.min(axis=0) - margin, mine.max(axis=0) + margin]))
    return _merged([_Zone(box, r) for box, r in zip(boxes, least, strict=True)])


def _merged(zones: list[_Zone]) -> list[_Zone]:
    """Join zones whose boxes meet until none do."""
    while True:
        pair = next(
            (
                (i, j)
                for i, j in combinations(range(len(zones)), 2)
                if (zones[i].box[0] <= zones[j].box[1]).all()
                and (zones[j].box[0] <= zones[i].box[1]).all()
            ),
            None,
        )
        if pair is None:
            return zones
        other, one = zones.pop(pair[1]), zones[pair[0]]
        low = np.minimum(one.box[0], other.box[0])
        high = np.maximum(one.box[1], other.box[1])
        zones[pair[0]] = _Zone(np.stack([low, high]), min(one.reach, other.reach))


def _on_creases(surface: Surface, solid: Composite, cell: float) -> Surface:
    """Keep the pieces of a fillet where both solids meet; none bridges a gap between them."""
    if not len(surface.faces):
        return surface
    a, b = surface.faces[:, :2].ravel(), surface.faces[:, 1:].ravel()
    pieces, piece = connected_pieces(a, b, len(surface.vertices))
    meets = np.zeros(pieces, dtype=bool)
    points = surface.vertices.copy()
    for _ in range(CLIMBS):
        left = np.flatnonzero(~meets[piece])
        if not len(left):
            break
        higher, within = _uphill(points[left], solid)
        meets[piece[left[within > -TOUCHING * cell]]] = True
        points[left] = higher
    return _part(surface, meets[piece])


def _uphill(points: Array, solid: Composite) -> tuple[Array, Array]:
    """Go a step further into both solids; return the places, and how far within both they were.

    Between sides that face each other across a gap no way leads into both.
    """
    first, second, _, reach = layers(solid, points)
    lower = np.where((first.value < second.value)[:, None], first.gradient, second.gradient)
    level = np.abs(first.value - second.value) < 0.5 * STRIDE * reach
    both = 0.5 * (unit(first.gradient) + unit(second.gradient))
    way = np.where(level[:, None], both, unit(lower))
    return points + STRIDE * reach[:, None] * way, np.minimum(first.value, second.value)


def _part(surface: Surface, kept: Flags) -> Surface:
    """Return some of the vertices (v,) of a surface, and their faces."""
    number = np.cumsum(kept) - 1
    faces = number[surface.faces[kept[surface.faces[:, 0]]]].astype(np.int32)
    return Surface(surface.vertices[kept], faces, surface.normals[kept])
