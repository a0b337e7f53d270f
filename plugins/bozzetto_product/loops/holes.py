"""Holes: loops within the surface of another one from which other surfaces leave.

The outline of a bore, a pocket or a boss lies within a face, and the wall is on it. There the face
ends: the loop is an outline of the face, and no surface of its own. What lies within a hole in the
same plane is a surface again. A loop from which nothing leaves divides nothing, and stays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import cached_property
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.network.flat_places import OFF_PLANE, plane_through
from bozzetto_product.network.half_edges import half_edges
from bozzetto_product.network.net import Loop
from bozzetto_product.network.outlines import joined_outlines, outlines_of, reversed_outline

if TYPE_CHECKING:
    import shapely

EXACT: Final = 0.5 * OFF_PLANE
"""Distance from a plane, as share of the size of a loop, up to which a surface with holes fills it;
half of it, for there may be several holes."""

ROUGH: Final = 1e-4
"""The same up to which a loop is meant to lie in a plane, into which files are put
(`flattening`)."""

LEAVING: Final = 1e-4
"""Distance from a plane, as share of the size of a loop in it, above which a surface leaves it."""

WALLED: Final = 0.5
"""Share of the length of a loop with walls above which it is a hole: one wall may be missing."""


@dataclass(frozen=True, eq=False)
class Ring:
    """An outline, and the plane that it lies in.

    Parameters
    ----------
    sampled : SampledNet
    flat : float
        Distance from a plane, as share of its size, up to which it lies in it.
    outline : Loop
    points : (n, 3) float
        Once round, mm.
    nodes, edges : frozenset of int
        Those that it goes through.
    """

    sampled: SampledNet
    flat: float
    outline: Loop
    points: Array
    nodes: frozenset[int]
    edges: frozenset[int]

    @classmethod
    def of(cls, sampled: SampledNet, flat: float, outline: Loop) -> Ring:
        """Return the ring of an outline."""
        halves = half_edges(outline)
        lines = [sampled.lines[half // 2][:: 1 - 2 * (half % 2)][:-1] for half in halves]
        nodes = frozenset(int(sampled.tails[half]) for half in halves) - {-1}
        edges = frozenset(edge for edge, _ in outline)
        return cls(sampled, flat, outline, np.vstack(lines), nodes, edges)

    @cached_property
    def box(self) -> tuple[Array, Array]:
        """Least and greatest coordinates, (3,) each."""
        return self.points.min(axis=0), self.points.max(axis=0)

    @cached_property
    def area(self) -> Array:
        """Vector of the area of the ring, (3,)."""
        points = self.points - self.points.mean(axis=0)
        return np.asarray(0.5 * cross_product(points, np.roll(points, -1, axis=0)).sum(axis=0))

    @cached_property
    def size(self) -> float:
        """Length of that vector, mm²."""
        return float(np.linalg.norm(self.area))

    @cached_property
    def _controls(self) -> Array:
        """Control points of its edges, (n, 3)."""
        net = self.sampled.net
        return np.vstack([net.edges[edge].spline.control_points for edge, _ in self.outline])

    @property
    def length(self) -> float:
        """Diagonal of the box around it, mm."""
        return float(np.linalg.norm(self.box[1] - self.box[0]))

    @cached_property
    def reach(self) -> float:
        """Distance from its plane up to which something lies in it, mm."""
        return self.flat * self.length

    @cached_property
    def plane(self) -> tuple[Array, Array] | None:
        """A place in its plane, and the unit normal of it; None where it lies in none."""
        return plane_through(self._controls, self.flat)

    def off(self, points: Array) -> float:
        """Return the greatest distance of points from its plane, mm; infinite without one."""
        if self.plane is None:
            return float("inf")
        middle, normal = self.plane
        return float(np.abs((points - middle) @ normal).max())

    @cached_property
    def axes(self) -> Array:
        """Two unit vectors in its plane, (2, 3)."""
        assert self.plane is not None
        return axes_across(self.plane[1])

    @cached_property
    def inside(self) -> shapely.Polygon | None:
        """Region that it encloses in its plane; None where it crosses itself."""
        import shapely

        polygon = shapely.Polygon(self.points @ self.axes.T)
        return polygon if polygon.is_valid else None

    def is_round(self, other: Ring) -> bool:
        """Whether another ring lies within it in its plane, and does not touch it."""
        if self.nodes & other.nodes or self.edges & other.edges:
            return False
        if self.off(other.points) > self.reach or self.inside is None:
            return False
        if plane_through(np.vstack((self._controls, other._controls)), self.flat) is None:
            return False
        import shapely

        ring = shapely.LinearRing(other.points @ self.axes.T)
        return bool(ring.is_simple and self.inside.contains_properly(ring))


def axes_across(normal: Array) -> Array:
    """Return two unit vectors in the plane across a unit normal, (2, 3)."""
    x = np.eye(3)[int(np.argmin(np.abs(normal)))]
    x = x - (x @ normal) * normal
    x = x / np.linalg.norm(x)
    return np.stack((x, cross_product(normal, x)))


class _Rings:
    """Rings, the greatest area first, and the ones round another one."""

    def __init__(self, rings: Sequence[Ring]) -> None:
        self.rings = sorted(rings, key=lambda ring: -ring.size)
        self._low = np.reshape([ring.box[0] - ring.reach for ring in self.rings], (-1, 3))
        self._high = np.reshape([ring.box[1] + ring.reach for ring in self.rings], (-1, 3))

    def around(self, ring: Ring) -> list[Ring]:
        """Return the rings that a ring lies within, the greatest area first."""
        low, high = ring.box
        held = (self._low <= low) & (self._high >= high)
        rows = [self.rings[k] for k in np.flatnonzero(held.all(axis=1)).tolist()]
        return [other for other in rows if other is not ring and other.is_round(ring)]


def with_holes(
    sampled: SampledNet,
    loops: Sequence[Loop],
    fixed: int,
    others: Sequence[Loop],
    flat: float = EXACT,
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
    flat : float
        Distance from a plane, as share of its size, up to which a loop lies in it.

    Returns
    -------
    list of Loop or None
        None for each that is a hole of another one.
    """
    every = [
        [Ring.of(sampled, flat, each) for each in outlines_of(sampled.net, one)] for one in loops
    ]
    users = outline_users(every)
    rims = [row[0] for row in every]
    possible = unused_rings(sampled, others, users, flat)
    walled = _walled(rims, rims[fixed:], possible, users)
    if not walled:
        return list(loops)
    owners = {id(hole): row[0] for row in every for hole in row[1:]}
    own, bound, maybe = (set(map(id, each)) for each in (rims, rims[:fixed], walled))
    known = [ring for row in every for ring in row]
    rings = _Rings([*known, *(ring for ring in walled if id(ring) not in own)])
    found: dict[int, list[Ring]] = {}
    for ring in rings.rings:
        if id(ring) in maybe:
            inner = [o for o in rings.around(ring) if id(o) in own or id(o) in owners]
            home = inner[-1]
            if id(home) not in owners and id(home) not in bound:
                owners[id(ring)] = home
                found.setdefault(id(home), []).append(ring)
    return [
        None
        if number >= fixed and id(row[0]) in owners
        else joined_outlines((loop, *(_clockwise(row[0], h) for h in found.get(id(row[0]), ()))))
        for number, (loop, row) in enumerate(zip(loops, every, strict=True))
    ]


def outline_users(every: Sequence[Sequence[Ring]]) -> dict[int, list[Ring]]:
    """Return the outlines of surfaces at each edge, for those of each surface."""
    users: dict[int, list[Ring]] = {}
    for row in every:
        for ring in row:
            for edge in ring.edges:
                users.setdefault(edge, []).append(ring)
    return users


def unused_rings(
    sampled: SampledNet, loops: Sequence[Loop], users: Mapping[int, Sequence[Ring]], flat: float
) -> list[Ring]:
    """Return the rings of loops that are no surfaces and have one at most at each edge."""
    return [
        Ring.of(sampled, flat, loop)
        for loop in loops
        if all(len(users.get(edge, ())) < 2 for edge, _ in loop)
    ]


def share_of_walls(ring: Ring, users: Mapping[int, Sequence[Ring]]) -> float:
    """Return the share of a ring's length on which one other surface stands; 0 where two do."""
    walled = 0.0
    for edge in ring.edges:
        count = sum(other is not ring for other in users.get(edge, ()))
        if count > 1:
            return 0.0
        walled += float(ring.sampled.lengths[edge]) * count
    return walled / float(ring.sampled.lengths[list(ring.edges)].sum())


def _walled(
    rims: Sequence[Ring],
    free: Sequence[Ring],
    others: Sequence[Ring],
    users: Mapping[int, Sequence[Ring]],
) -> list[Ring]:
    """Return the rings with walls within the outline of a surface: no two others share an edge.

    Parameters
    ----------
    rims : sequence of Ring
        The outlines of all surfaces.
    free, others : sequence of Ring
        Those of surfaces that may be holes, and rings that are of no surface.
    users : mapping of int to sequence of Ring
        The outlines of surfaces at each edge.
    """
    homes = _Rings(rims)
    taken = set[int]()
    made = []
    for number, ring in enumerate([*free, *others]):
        around = homes.around(ring)
        if around and _has_walls(ring, around[-1], users) and ring.edges.isdisjoint(taken):
            made.append(ring)
            taken |= ring.edges if number >= len(free) else set()
    return made


def with_clockwise_holes(sampled: SampledNet, outlines: Sequence[Loop]) -> Loop:
    """Return the loop of some outlines: the largest first, and the others run against it."""
    rings = [Ring.of(sampled, EXACT, outline) for outline in outlines]
    rim = max(rings, key=lambda ring: ring.size)
    holes = (_clockwise(rim, ring) for ring in rings if ring is not rim)
    return joined_outlines((rim.outline, *holes))


def _has_walls(ring: Ring, home: Ring, users: Mapping[int, Sequence[Ring]]) -> bool:
    """Whether surfaces that leave the plane of its home stand on most of a ring, and no others."""
    others = (o for edge in ring.edges for o in users.get(edge, ()) if o is not ring)
    return share_of_walls(ring, users) > WALLED and all(
        home.off(other.points) > LEAVING * home.length for other in others
    )


def _clockwise(outline: Ring, hole: Ring) -> Loop:
    """Return a hole so that it runs against the outline round it."""
    against = float(outline.area @ hole.area) < 0.0
    return hole.outline if against else reversed_outline(hole.outline)
