"""Hidden lines: which stretches of the edges and outlines of a net a view shows.

What is seen of an edge changes only where its picture crosses that of an outline or a rim
(Appel, "The notion of quantitative invisibility", 1967). So edges are cut there, and of each
piece one point is compared with the triangles that lie over it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.exchange.line_drawing.drawn_edges import Net

IN_FRONT: Final = 1e-5
"""By how much a triangle must be nearer to hide a point, as a share of the depth of everything."""

ON_SURFACE: Final = 6e-3
"""The same for drawn curves: they lie on surfaces, or nearly."""

ON_BORDER: Final = 1e-7
"""How far outside a triangle, barycentric, still lies on its border."""

EDGE_ON: Final = 1e-13
"""Area up to which a triangle is seen edge-on and hides nothing, as a share of the picture's."""

SHORTEST: Final = 1e-7
"""Pieces shorter than this share of an edge are none."""


@dataclass(frozen=True, eq=False)
class DrawnLine:
    """A line of a drawing.

    Attributes
    ----------
    points : (n, 2) float
        In the units of the picture, y down.
    visible : bool
        Whether nothing lies in front of it.
    name : str
        Of the part that it belongs to.
    """

    points: Array
    visible: bool
    name: str


def drawn_lines(net: Net, places: Array, depths: Array) -> list[DrawnLine]:
    """Return the lines of a net in a picture, seen and hidden ones.

    Parameters
    ----------
    net : Net
        What is drawn.
    places : (v, 2) float
        Where its points are in the picture, y down.
    depths : (v,) float
        How far away each is, in any measure in which straight lines of the picture are straight:
        of a perspective picture −1 / distance. Faces with a point that is not finite are left out.
    """
    seen = np.column_stack((places, depths))
    good = np.asarray(np.isfinite(seen).all(axis=1))
    shown = np.asarray(good[net.faces].all(axis=1))
    area = _turn(*np.moveaxis(np.where(good[:, None], places, 0.0)[net.faces], 1, 0))
    front: Flags = area < 0.0  # counter-clockwise from outside, and y points down
    first, second = net.sides.T
    two = second >= 0
    both = front[first] == front[second]
    outline: Flags = two & ~both & shown[first] & shown[second]
    outline &= ~_hollow(net)
    drawn: Flags = (net.sharp | outline) & shown[first]
    covering: Flags = outline | (~two & shown[first])
    numbers = np.flatnonzero(drawn)
    wires = good[net.wires].all(axis=1)
    ends_of = np.concatenate((net.edges[numbers], net.wires[wires]))
    own = np.concatenate((net.sides[numbers], np.full((int(wires.sum()), 2), -1)))
    name = np.concatenate((net.part[net.sides[numbers, 0]], net.wire[wires]))
    slack = np.where(own[:, 0] < 0, ON_SURFACE, IN_FRONT)
    if not len(ends_of):
        return []
    starts, ends = ends_of.T
    owner, low, high = _cut(places[starts], places[ends], places, net.edges[covering])
    middle = (0.5 * (low + high))[:, None]
    points = places[starts[owner]] * (1 - middle) + places[ends[owner]] * middle
    deep = depths[starts[owner]] * (1 - middle[:, 0]) + depths[ends[owner]] * middle[:, 0]
    hiding = np.flatnonzero(shown & (front | ~net.closed))
    hidden = _covered(net, places, depths, hiding, points, deep, own[owner], slack[owner])
    lines = _joined(places, ends_of, name, owner, low, high, ~hidden)
    return [DrawnLine(points, seen, net.names[number]) for points, seen, number in lines]


def _turn(a: Array, b: Array, c: Array) -> Array:
    u, v = b - a, c - a
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _hollow(net: Net) -> Flags:
    """Return at which edges two faces meet in a hollow: these are no outlines of a solid."""
    first, second = net.sides.T
    corners = net.points[net.faces[first]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    other = net.points[net.faces[second]].mean(axis=1) - net.points[net.edges[:, 0]]
    rises = np.einsum("ij,ij->i", normal, other) > 0.0
    return np.asarray(rises & (second >= 0) & net.closed[first])


def _cut(starts: Array, ends: Array, places: Array, covering: Index) -> tuple[Index, Array, Array]:
    """Cut segments where others cross them; return of which each piece is, and from where to where.

    Shares of the segments, 0 at their start, 1 at their end.
    """
    from shapely import STRtree, linestrings

    shares = [np.zeros(len(starts)), np.ones(len(starts))]
    owners = [np.arange(len(starts)), np.arange(len(starts))]
    if len(covering):
        tree = STRtree(linestrings(places[covering]))
        mine, other = tree.query(linestrings(np.stack((starts, ends), axis=1)))
        p, r = starts[mine], ends[mine] - starts[mine]
        q = places[covering[other, 0]]
        s = places[covering[other, 1]] - q
        across = r[:, 0] * s[:, 1] - r[:, 1] * s[:, 0]
        with np.errstate(all="ignore"):
            t = ((q - p)[:, 0] * s[:, 1] - (q - p)[:, 1] * s[:, 0]) / across
            u = ((q - p)[:, 0] * r[:, 1] - (q - p)[:, 1] * r[:, 0]) / across
        hit = (t > 0) & (t < 1) & (u >= -SHORTEST) & (u <= 1 + SHORTEST)
        shares.append(t[hit])
        owners.append(mine[hit])
    share, owner = np.concatenate(shares), np.concatenate(owners)
    order = np.lexsort((share, owner))
    share, owner = share[order], owner[order]
    kept = (owner[1:] == owner[:-1]) & (share[1:] - share[:-1] > SHORTEST)
    return owner[:-1][kept], share[:-1][kept], share[1:][kept]


def _covered(
    net: Net,
    places: Array,
    depths: Array,
    hiding: Index,
    points: Array,
    deep: Array,
    own: Index,
    slack: Array,
) -> Flags:
    """Return which points lie behind a triangle other than the two at their own edge."""
    from shapely import STRtree, box
    from shapely import points as as_points

    corners = places[net.faces[hiding]]
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    thinnest, grain = EDGE_ON * size * size, ON_BORDER * size
    low, high = corners.min(axis=1) - grain, corners.max(axis=1) + grain
    tree = STRtree(box(*low.T, *high.T))
    point, face = tree.query(as_points(points))
    a, b, c = np.moveaxis(corners[face], 1, 0)
    whole = _turn(a, b, c)
    spot = points[point]
    weights = np.stack((_turn(spot, b, c), _turn(a, spot, c), _turn(a, b, spot)))
    with np.errstate(all="ignore"):
        weights = weights / whole
    # What lies on the border of something nearer, such as its own far side, is hidden, too.
    inside = (weights >= -ON_BORDER).all(axis=0) & (np.abs(whole) > thinnest)
    number = hiding[face]
    inside &= (own[point] != number[:, None]).all(axis=1)
    over = (weights * depths[net.faces[number]].T).sum(axis=0)
    reach = float(np.ptp(depths[np.unique(net.faces[hiding])])) if len(hiding) else 0.0
    hides = inside & (over < deep[point] - slack[point] * max(reach, 1e-300))
    found = np.zeros(len(points), bool)
    found[point[hides]] = True
    return found


def _joined(
    places: Array,
    ends_of: Index,
    name: Index,
    edges: Index,
    low: Array,
    high: Array,
    visible: Flags,
) -> list[tuple[Array, bool, int]]:
    """Return pieces put together where two of one kind, and no third, meet in a point."""
    ends: dict[tuple[int, bool, int], list[int]] = {}
    keys: list[tuple[tuple[int, bool, int], tuple[int, bool, int]]] = []
    part = name[edges]
    pairs = []
    for number, (edge, seen, own, start, end) in enumerate(
        zip(edges.tolist(), visible.tolist(), part.tolist(), low.tolist(), high.tolist(),
            strict=True)
    ):  # fmt: skip
        a, b = ends_of[edge]
        here = (int(a), seen, own) if start == 0.0 else (-2 * number - 1, seen, own)
        there = (int(b), seen, own) if end == 1.0 else (-2 * number - 2, seen, own)
        if start > 0.0 and number and edges[number - 1] == edge and high[number - 1] == start:
            here = keys[-1][1] if keys[-1][1][1] == seen else here
        keys.append((here, there))
        pairs.append((places[a] * (1 - start) + places[b] * start,
                      places[a] * (1 - end) + places[b] * end))  # fmt: skip
        for key in (here, there):
            ends.setdefault(key, []).append(number)
    used = [False] * len(keys)
    lines = []
    for begin in range(len(keys)):
        if used[begin]:
            continue
        used[begin] = True
        row = [pairs[begin][0], pairs[begin][1]]
        for forward in (True, False):
            key = keys[begin][1 if forward else 0]
            while len(ends[key]) == 2:
                follower = next((k for k in ends[key] if not used[k]), None)
                if follower is None:
                    break
                used[follower] = True
                turned = keys[follower][1] == key
                place, key = pairs[follower][0 if turned else 1], keys[follower][0 if turned else 1]
                row = [*row, place] if forward else [place, *row]
        lines.append((np.array(row), bool(visible[begin]), int(part[begin])))
    return lines
