"""Holes in surfaces that bend: loops that lie within another one's surface; see `holes`.

Where a surface goes between its curves is not known exactly: a loop is taken to lie in it if it is
much nearer to it than the surfaces reach that leave from it. Of two such loops with one wall, as
the foot and the top of a low boss, only the nearer one is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final, Protocol

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import signed_area
from bozzetto_product.loops.holes import (
    EXACT,
    LEAVING,
    WALLED,
    Ring,
    axes_across,
    outline_users,
    share_of_walls,
    unused_rings,
)
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.network.net import Loop
from bozzetto_product.network.outlines import joined_outlines, outlines_of, reversed_outline

if TYPE_CHECKING:
    import shapely

NEAR: Final = 0.03
"""Distance from a surface, as share of the size of its loop, up to which a loop may lie in it."""

LEAVES: Final = 2.0
"""How many times as far as the loop is from it another surface must reach from that surface: of the
top of a boss its wall reaches once as far."""

STEEP: Final = 0.3
"""Sine of the angle to the surface at which most curves of the surfaces that leave it begin."""

BULGE: Final = 0.36
"""How far a surface may reach out of the box of its outline, as share of its diagonal: a half
sphere does by .354."""


class BentSurface(Protocol):
    """Fill of a loop, and the plane over which it lies."""

    @property
    def outline(self) -> shapely.Polygon:
        """Region that the loop encloses in that plane."""

    def farthest(self, points: Array) -> float:
        """Return the distance from the surface of the point farthest from it, mm."""

    def feet(self, points: Array) -> tuple[Array, Array]:
        """Return the places in the plane that are nearest to points, (n, 2), and normals."""


SurfaceOf = Callable[[int], BentSurface | None]
"""From the number of a loop to its surface; None where there is none that bends."""


def with_bent_holes(
    sampled: SampledNet,
    loops: Sequence[Loop],
    fixed: int,
    others: Sequence[Loop],
    surface_of: SurfaceOf,
) -> list[Loop | None]:
    """Return loops with the holes that are in surfaces that bend; see `holes.with_holes`.

    Parameters
    ----------
    sampled, loops, fixed, others
        See `holes.with_holes`. Holes that lie in planes are in the loops already.
    surface_of : callable
        Called for few of the loops.
    """
    every = [
        [Ring.of(sampled, EXACT, each) for each in outlines_of(sampled.net, one)] for one in loops
    ]
    users = outline_users(every)
    free = [row[0] for row in every[fixed:] if len(row) == 1]
    walled = [
        ring
        for ring in (*free, *unused_rings(sampled, others, users, EXACT))
        if share_of_walls(ring, users) > WALLED
    ]
    best: dict[int, tuple[float, int]] = {}
    for number in range(fixed, len(loops)):
        for k, off in _within(every[number], walled, users, partial(surface_of, number)):
            best[k] = min(best.get(k, (np.inf, 0)), (off, number))
    own = {id(row[0]): number for number, row in enumerate(every)}
    holes: dict[int, list[Ring]] = {}
    gone, taken = set[int](), set[int]()
    for k in sorted(best, key=lambda k: -walled[k].length):
        ring, home = walled[k], best[k][1]
        if home in gone or (id(ring) not in own and not ring.edges.isdisjoint(taken)):
            continue
        taken |= ring.edges
        holes.setdefault(home, []).append(ring)
        gone |= {own[id(ring)]} if id(ring) in own else set()
    made: list[Loop | None] = [
        None if number in gone else loop for number, loop in enumerate(loops)
    ]
    for number, rings in holes.items():
        surface = surface_of(number)
        if surface is not None and number not in gone:
            rows = (_clockwise(surface, ring) for ring in rings)
            made[number] = joined_outlines((loops[number], *rows))
    return made


def _within(
    home: Sequence[Ring],
    rings: Sequence[Ring],
    users: Mapping[int, Sequence[Ring]],
    surface_of: Callable[[], BentSurface | None],
) -> Iterator[tuple[int, float]]:
    """Yield the numbers of rings that lie in a surface, and their distances from it, mm.

    None lies within another one of them, or in a hole that the surface has.
    """
    import shapely

    rim = home[0]
    near = [
        k
        for k, ring in enumerate(rings)
        if ring.size < rim.size
        and all(ring.nodes.isdisjoint(o.nodes) and ring.edges.isdisjoint(o.edges) for o in home)
        and _is_over(rim, ring)
    ]
    surface = surface_of() if near else None
    if surface is None:
        return
    region = surface.outline
    for hole in home[1:]:
        region = region.difference(shapely.Polygon(surface.feet(hole.points)[0]))
    found = []
    for k in near:
        off = surface.farthest(rings[k].points)
        if off <= NEAR * rim.length and _is_left(rings[k], surface, off, users):
            flat = shapely.LinearRing(surface.feet(rings[k].points)[0])
            if flat.is_simple and region.contains_properly(flat):
                found.append((shapely.Polygon(flat), k, off))
    found.sort(key=lambda row: -row[0].area)
    for number, (polygon, k, off) in enumerate(found):
        if not any(other.intersects(polygon) for other, *_ in found[:number]):
            yield k, off


def _is_over(rim: Ring, ring: Ring) -> bool:
    """Whether a ring may lie in a surface by where it is: over its outline, and not too high."""
    import shapely

    reach = BULGE * rim.length
    low, high = ring.box
    if (low < rim.box[0] - reach).any() or (high > rim.box[1] + reach).any():
        return False
    up = rim.area / max(rim.size, 1e-300)
    axes = axes_across(up)
    hull = shapely.MultiPoint(rim.points @ axes.T).convex_hull
    return bool(hull.covers(shapely.MultiPoint(ring.points @ axes.T)))


def _is_left(
    ring: Ring, surface: BentSurface, off: float, users: Mapping[int, Sequence[Ring]]
) -> bool:
    """Whether all surfaces on a ring leave the surface in which it lies, and not along it.

    The inner side of a thin wall lies along the outer one.
    """
    least = max(LEAVES * off, LEAVING * ring.length)
    others = {id(o): o for edge in ring.edges for o in users.get(edge, ()) if o is not ring}
    if any(surface.farthest(other.points) <= least for other in others.values()):
        return False
    sampled = ring.sampled
    walls = frozenset(edge for other in others.values() for edge in other.edges) - ring.edges
    leaving = [half for node in ring.nodes for half in sampled.outgoing[node] if half // 2 in walls]
    if not leaving:
        return True
    normals = surface.feet(sampled.lines.reshape(-1, 3)[_starts(sampled, leaving)])[1]
    steep = np.abs((sampled.leaving[leaving] * normals).sum(axis=1)) >= STEEP
    return bool(2 * int(steep.sum()) > len(leaving))


def _starts(sampled: SampledNet, halves: Sequence[int]) -> list[int]:
    """Return the numbers of the points at which half edges begin, among those of all edges."""
    count = sampled.lines.shape[1]
    return [half // 2 * count + (count - 1) * (half % 2) for half in halves]


def _clockwise(surface: BentSurface, hole: Ring) -> Loop:
    """Return a hole so that it runs clockwise over the surface round it."""
    flat, _ = surface.feet(hole.points)
    return hole.outline if signed_area(flat) < 0.0 else reversed_outline(hole.outline)
