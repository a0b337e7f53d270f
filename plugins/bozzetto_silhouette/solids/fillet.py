"""Fillets: closed meshes that are united with two bodies, or taken away, to make a blend.

Only the surroundings of creases are polygonized, each by cells that suit its own reach. The
bodies keep their meshes, and what is far from a crease is not looked at.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.plugin import cached_property, remembered
from bozzetto_silhouette.implicit.composite import Composite, signature
from bozzetto_silhouette.implicit.fillet_solid import DEPTH, FilletSolid, Layers, layers_each
from bozzetto_silhouette.inflation.manifold_check import as_manifold, original_numbers
from bozzetto_silhouette.inflation.solidify import Checkpoint, ignore
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.isotropic_remeshing import unit
from bozzetto_silhouette.solids.batched_answers import each
from bozzetto_silhouette.solids.body import Body, meet, places_in
from bozzetto_silhouette.solids.polygonize import Surface, Wanted, extracted

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

SPARSE = 8
"""Of so many vertices of a fillet one is led to the crease first: mostly it gets there."""

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


class Blend:
    """A blend of two solids, whose fillets are made when they are asked for.

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
    """

    def __init__(self, solid: Composite, box: Array, bodies: Sequence[Body], step: float) -> None:
        self.solid = solid
        self.box = box
        self.bodies = tuple(body for body in bodies if meet(body.bounds, box))
        self.step = step

    @cached_property
    def key(self) -> Hashable:
        """Key of what the fillets depend on, by the bodies: their vertices are not looked at."""
        boxes = self.box, self.solid.first.bounds, self.solid.second.bounds
        marks = tuple(body.mark for body in self.bodies)
        return signature(self.local), marks, self.step, *(some.tobytes() for some in boxes)

    @cached_property
    def local(self) -> Composite:
        """The solid with what matters around its box."""
        margin = np.array([[-self.solid.reach], [self.solid.reach]])
        return self.solid.within(self.box + margin, BEYOND * self.solid.reach)

    @cached_property
    def bounds(self) -> Array:
        """A box (2, 3) around the fillets."""
        low, high = self.solid.bounds
        return np.stack([np.maximum(low, self.box[0]), np.minimum(high, self.box[1])])


def fillets_of(
    blends: Sequence[Blend], checkpoint: Checkpoint = ignore
) -> list[tuple[Fillet, ...]]:
    """Return what each of some blends adds to its sharp result, or takes away.

    What is not remembered is made all at once.

    Parameters
    ----------
    blends : sequence of Blend
        Of any composites.
    checkpoint : callable
        Called with (fraction, step) between steps; may raise `Cancelled`.

    Returns
    -------
    list of tuples of Fillet
        Closed meshes. Those of a union are to be united with it; those of a carved solid are to
        be taken away, and those of an intersection, too.
    """
    return each(_between, partial(_all_between, checkpoint=checkpoint), blends)


# By the bodies, so that their vertices are not looked at again. Where one was made anew just as it
# was, the fillets are found by these.
@remembered(limit=512, key=lambda blend: blend.key)
def _between(blend: Blend) -> tuple[Fillet, ...]:
    return _all_between([blend], ignore)[0]


def _all_between(blends: Sequence[Blend], checkpoint: Checkpoint) -> list[tuple[Fillet, ...]]:
    creases = [_crease(blend) for blend in blends]
    known = [crease for crease in creases if crease is not None]
    made = iter(each(_made, partial(_all_made, checkpoint=checkpoint), known))
    return [() if crease is None else next(made) for crease in creases]


class _Crease(NamedTuple):
    """Where two solids may be blended.

    Attributes
    ----------
    solid : Composite
    places : (n, 3) float array
        On the surfaces, where the blend may be felt.
    step : float
    """

    solid: Composite
    places: Array
    step: float


def _crease(blend: Blend) -> _Crease | None:
    """Return where a blend may be felt; None where it is not."""
    solid = blend.solid
    places = places_in(blend.bodies, blend.box)
    near = places[solid.felt(places)]
    if not len(near):
        return None
    near = near[np.lexsort(near.T)]
    around = np.stack([near.min(axis=0) - solid.reach, near.max(axis=0) + solid.reach])
    return _Crease(blend.local.within(around, BEYOND * solid.reach), near, blend.step)


def _depends_on(crease: _Crease) -> Hashable:
    """Return what a fillet depends on: the same, whatever was done to the rest of the tree."""
    solid, places, step = crease
    return signature(solid), step, len(places), places.sum(axis=0).tobytes()


@remembered(limit=512, key=_depends_on)
def _made(crease: _Crease) -> tuple[Fillet, ...]:
    return _all_made([crease], ignore)[0]


def _all_made(creases: Sequence[_Crease], checkpoint: Checkpoint) -> list[tuple[Fillet, ...]]:
    checkpoint(0.6, "blend")
    owners, thin, wanted = [], [], []
    for k, zones in enumerate(_zones(creases)):
        solid, _, step = creases[k]
        for zone in zones:
            longest = float(np.ptp(zone.box, axis=0).max())
            cell = max(FINENESS * zone.reach, FINEST * step, longest / MOST_CELLS)
            local = solid.within(zone.box, BEYOND * solid.reach)
            owners.append(k)
            thin.append(local)
            wanted.append(Wanted(FilletSolid(local, step, cell), zone.box, cell))
    surfaces = extracted(wanted, checkpoint)
    surfaces = _on_creases(surfaces, thin, [some.step for some in wanted])
    found: list[list[Fillet]] = [[] for _ in creases]
    for k, surface, some in zip(owners, surfaces, wanted, strict=True):
        if len(surface.faces):
            found[k].append(Fillet(surface, some.step))
    return [tuple(fillets) for fillets in found]


def _zones(creases: Sequence[_Crease]) -> Iterator[list[_Zone]]:
    """Find where each blend tells, from places on the surfaces."""
    places = [some.places[:: len(some.places) // MOST_PLACES + 1] for some in creases]
    sampled = layers_each([some.solid for some in creases], places)
    for crease, points, found in zip(creases, places, sampled, strict=True):
        yield _told(points, found, crease.step)


def _told(places: Array, sampled: Layers, step: float) -> list[_Zone]:
    """Find where a blend tells, from places on the surfaces; zones whose boxes meet are one."""
    first, second, blended, reach = sampled
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


def _on_creases(
    surfaces: Sequence[Surface], solids: Sequence[Composite], cells: Sequence[float]
) -> list[Surface]:
    """Keep the pieces of fillets where both solids meet; none bridges a gap between them.

    What merges may bridge it.
    """
    pieces, meets, points = [], [], []
    for surface, solid in zip(surfaces, solids, strict=True):
        a, b = surface.faces[:, :2].ravel(), surface.faces[:, 1:].ravel()
        count, piece = connected_pieces(a, b, len(surface.vertices))
        pieces.append(piece)
        meets.append(np.full(count, solid.operation == "merge"))
        points.append(surface.vertices.copy())
    for turn in range(2 * CLIMBS):
        every_nth = SPARSE if turn < CLIMBS else 1
        left = {
            k: some
            for k in range(len(surfaces))
            if len(some := np.flatnonzero(~meets[k][pieces[k]])[::every_nth])
        }
        asked = [points[k][some] for k, some in left.items()]
        every = layers_each([solids[k] for k in left], asked)
        for (k, some), places, sampled in zip(left.items(), asked, every, strict=True):
            higher, within = _uphill(places, sampled)
            meets[k][pieces[k][some[within > -TOUCHING * cells[k]]]] = True
            points[k][some] = higher
    return [
        _part(surface, known[piece])
        for surface, known, piece in zip(surfaces, meets, pieces, strict=True)
    ]


def _uphill(points: Array, sampled: Layers) -> tuple[Array, Array]:
    """Go a step further into both solids; return the places, and how far within both they were.

    Between sides that face each other across a gap no way leads into both.
    """
    first, second, _, reach = sampled
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
