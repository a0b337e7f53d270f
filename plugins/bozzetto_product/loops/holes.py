"""Holes: loops within the surface of another one from which other surfaces leave.

The outline of a bore, a pocket or a boss lies within a face, and the wall is on it. There the face
ends: the loop is an outline of the face, and no surface of its own. What lies within a hole in the
same plane is a surface again. A loop from which nothing leaves divides nothing, and stays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import cached_property
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.network.half_edges import half_edges
from bozzetto_product.network.net import Loop
from bozzetto_product.network.outlines import joined_outlines, outlines_of, reversed_outline

if TYPE_CHECKING:
    import shapely

FLAT: Final = 1e-4
"""Distance from a plane, as share of the size of a loop, up to which a loop is meant to lie in it:
what files are put into planes by (`flattening`)."""

WALLED: Final = 0.5
"""Share of the length of a loop with walls above which it is a hole: one wall may be missing."""


@dataclass(frozen=True, eq=False)
class _Ring:
    """An outline as points in space.

    Parameters
    ----------
    outline : Loop
    points : (n, 3) float
        Once round, mm.
    nodes : frozenset of int
        Those that it goes through.
    """

    outline: Loop
    points: Array
    nodes: frozenset[int]

    @classmethod
    def of(cls, sampled: SampledNet, outline: Loop) -> _Ring:
        """Return the ring of an outline."""
        halves = half_edges(outline)
        lines = [sampled.lines[half // 2][:: 1 - 2 * (half % 2)][:-1] for half in halves]
        nodes = frozenset(int(sampled.tails[half]) for half in halves) - {-1}
        return cls(outline, np.vstack(lines), nodes)

    @cached_property
    def edges(self) -> frozenset[int]:
        """The numbers of its edges."""
        return frozenset(edge for edge, _ in self.outline)

    @cached_property
    def middle(self) -> Array:
        """Mean of the points, (3,)."""
        return np.asarray(self.points.mean(axis=0))

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around it, mm."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    @cached_property
    def area(self) -> Array:
        """Vector of the area of the ring, (3,)."""
        points = self.points - self.middle
        return np.asarray(0.5 * cross_product(points, np.roll(points, -1, axis=0)).sum(axis=0))

    @cached_property
    def normal(self) -> Array:
        """Unit normal of the area, (3,)."""
        return np.asarray(self.area / max(float(np.linalg.norm(self.area)), 1e-300))

    def holds(self, points: Array) -> bool:
        """Whether points lie in its plane."""
        return bool(np.abs((points - self.middle) @ self.normal).max() <= FLAT * self.size)

    @cached_property
    def axes(self) -> Array:
        """Two unit vectors in the plane of its area, (2, 3); counter-clockwise as it runs."""
        x = np.eye(3)[int(np.argmin(np.abs(self.normal)))]
        x = x - (x @ self.normal) * self.normal
        x = x / np.linalg.norm(x)
        return np.stack((x, cross_product(self.normal, x)))

    def flat(self, points: Array) -> Array:
        """Return points in its plane, (n, 2)."""
        return np.asarray((points - self.middle) @ self.axes.T)

    @cached_property
    def inside(self) -> shapely.Polygon | None:
        """What it encloses in its plane; None where it lies in none, or crosses itself."""
        import shapely

        if not self.holds(self.points):
            return None
        polygon = shapely.Polygon(self.flat(self.points))
        return polygon if polygon.is_valid and polygon.area > 0.0 else None

    def is_round(self, other: _Ring) -> bool:
        """Whether another ring lies within it in its plane, and does not touch it."""
        if self.nodes & other.nodes or self.edges & other.edges or other.size >= self.size:
            return False
        if self.inside is None or other.inside is None or not self.holds(other.points):
            return False
        import shapely

        return bool(self.inside.contains_properly(shapely.LinearRing(self.flat(other.points))))


def with_holes(
    sampled: SampledNet, loops: Sequence[Loop], fixed: int, others: Sequence[Loop]
) -> list[Loop | None]:
    """Return loops with the holes in them.

    Parameters
    ----------
    sampled : SampledNet
        The net.
    loops : sequence of Loop
        All surfaces.
    fixed : int
        How many of the first ones stay as they are.
    others : sequence of Loop
        Loops of one outline that are no surfaces and may be holes, the likeliest first.

    Returns
    -------
    list of Loop or None
        None for each that is a hole of another one.
    """
    every = [[_Ring.of(sampled, each) for each in outlines_of(sampled.net, one)] for one in loops]
    users: dict[int, list[_Ring]] = {}
    for rings in every:
        for ring in rings:
            for edge in ring.edges:
                users.setdefault(edge, []).append(ring)
    surfaces = {id(rings[0]): number for number, rings in enumerate(every)}
    held = {id(ring) for rings in every[:fixed] for ring in rings}
    free = [rings[0] for rings in every[fixed:] if _has_walls(sampled, rings[0], users)]
    taken = set[int]()
    for loop in others:
        if all(len(users.get(edge, ())) < 2 for edge, _ in loop):
            ring = _Ring.of(sampled, loop)
            if ring.edges.isdisjoint(taken) and _has_walls(sampled, ring, users):
                taken |= ring.edges
                free.append(ring)
    if not free:
        return list(loops)
    walled = {id(ring) for ring in free}
    rings = [ring for row in every for ring in row if id(ring) not in walled] + free
    rings = sorted(
        (ring for ring in rings if ring.inside is not None),
        key=lambda ring: -float(np.linalg.norm(ring.area)),
    )
    # Holes of surfaces that are fixed are known; all others are what is round them.
    owners = {id(ring): row[0] for row in every[:fixed] for ring in row[1:]}
    for number, ring in enumerate(rings):
        if id(ring) not in walled or id(ring) in held:
            continue
        around = [other for other in rings[:number] if other.is_round(ring)]
        around = [other for other in around if id(other) in surfaces or id(other) in owners]
        home = around[-1] if around else None
        if home is not None and id(home) not in owners and id(home) not in held:
            owners[id(ring)] = home
    made: list[Loop | None] = []
    for number, row in enumerate(every):
        holes = [ring for ring in rings if owners.get(id(ring)) is row[0] and number >= fixed]
        if number >= fixed and id(row[0]) in owners:
            made.append(None)
        else:
            made.append(joined_outlines((loops[number], *(_clockwise(row[0], h) for h in holes))))
    return made


def with_clockwise_holes(sampled: SampledNet, outlines: Sequence[Loop]) -> Loop:
    """Return the loop of some outlines: the largest first, and the others run against it."""
    rings = [_Ring.of(sampled, outline) for outline in outlines]
    rim = max(rings, key=lambda ring: float(np.linalg.norm(ring.area)))
    holes = (_clockwise(rim, ring) for ring in rings if ring is not rim)
    return joined_outlines((rim.outline, *holes))


def _has_walls(sampled: SampledNet, ring: _Ring, users: dict[int, list[_Ring]]) -> bool:
    """Whether surfaces that leave the plane of a ring stand on most of it, and no others do."""
    if ring.inside is None:
        return False
    walled = 0.0
    for edge in ring.edges:
        others = [other for other in users.get(edge, ()) if other is not ring]
        if len(others) > 1 or any(ring.holds(other.points) for other in others):
            return False
        walled += float(sampled.lengths[edge]) * len(others)
    return walled > WALLED * float(sampled.lengths[list(ring.edges)].sum())


def _clockwise(outline: _Ring, hole: _Ring) -> Loop:
    """Return a hole so that it runs against the outline round it."""
    against = float(outline.normal @ hole.area) < 0.0
    return hole.outline if against else reversed_outline(hole.outline)
