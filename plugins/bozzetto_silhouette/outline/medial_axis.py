"""The skeleton: axis of the triangulated outline, pruned, with exact radii.

Terminal, sleeve and junction triangles after Prasad, "Morphological analysis of shapes",
1997, and Igarashi et al., "Teddy", 1999; pruning by covered discs after Kukelova and
Durikovic, "SketchCo", 2007.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry import Triangulation, ring_links, triangulate
from bozzetto_silhouette.numerics.grouping import connected_pieces
from bozzetto_silhouette.numerics.triangle_circles import circumcircles, incircles, side_lengths
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.outline.signed_distance import RimDistance

STUB = 0.06
"""A leaf is pruned when its disc sticks out of a larger one by less than this share of the
larger radius. (The paper compares with the neighbour on the axis; then the outcome depends on
how densely the axis is sampled.)"""

INSCRIBED = 0.15
"""A triangle's circumcircle counts as inscribed when its radius agrees with the distance to
the outline to this share."""

COINCIDENT = 2e-3
"""Centres closer than this share of the size are one: on a circular arc all are."""

SPLIT = 2.0
"""Edges longer than this many radii are split: the fit needs the freedom."""


TIP = 0.4
"""The last piece of a limb, in radii: towards a free end the kernel has only one side, and a
weight of its own makes up for that."""


@dataclass(frozen=True, eq=False)
class Skeleton:
    """A graph of balls.

    Attributes
    ----------
    nodes : (n, 3) float array
        x, y and radius of the inscribed ball.
    edges : (m, 2) int array
        Pairs of nodes.
    """

    nodes: Array
    edges: Index

    @property
    def degrees(self) -> Index:
        """Number of edges at each node, (n,)."""
        return np.bincount(self.edges.ravel(), minlength=len(self.nodes))

    def transformed(self, scale: float, shift: Array) -> Skeleton:
        """Return the skeleton of the outline scaled, then shifted."""
        nodes = self.nodes * scale
        nodes[:, :2] += shift
        return Skeleton(nodes, self.edges)

    def heights(self, xy: Array) -> Array:
        """Return the height of the union of the balls above points (k, 2); 0 outside of all."""
        gap2 = ((xy[:, None, :] - self.nodes[None, :, :2]) ** 2).sum(axis=2)
        best: Array = np.sqrt(np.maximum(self.nodes[:, 2] ** 2 - gap2, 0.0).max(axis=1))
        return best


def _centres(mesh: Triangulation, distance: RimDistance) -> tuple[Array, Array]:
    """Return one ball for every triangle: centre (t, 2) and radius (t,).

    The circumcentre is a point of the medial axis as long as its circle is inscribed. On
    sparse samples it may not be; then a sleeve takes the middle of its two chords, a
    terminal triangle its incentre and a junction the circumcentre clamped into it.
    """
    p, sides = mesh.points, mesh.sides
    corners = p[mesh.triangles]
    circumcentre, circle = circumcircles(corners)
    radius = distance(circumcentre).distance
    good = np.abs(radius - circle) <= INSCRIBED * circle

    middle = 0.5 * (corners + np.roll(corners, -1, axis=1))
    inner = (sides >= 0)[..., None]
    between = (middle * inner).sum(axis=1) / np.maximum(inner.sum(axis=1), 1)
    # Barycentric coordinates of the circumcentre; negative ones lie beyond a side.
    square = side_lengths(corners) ** 2
    weight = np.maximum(square * (square.sum(axis=1, keepdims=True) - 2.0 * square), 0.0)
    weight /= np.maximum(weight.sum(axis=1, keepdims=True), 1e-300)
    clamped = (corners * weight[..., None]).sum(axis=1)
    incentre, _ = incircles(corners)
    kind = (sides >= 0).sum(axis=1)[:, None]
    spare = np.where(kind == 2, between, np.where(kind == 3, clamped, incentre))
    centre = np.where(good[:, None], circumcentre, spare)
    exact = distance(centre[~good]).distance
    radius[~good] = np.maximum(exact, 0.0)
    return centre, radius


def _merged(nodes: Array, edges: Index, closer: float) -> tuple[Array, Index]:
    """Contract edges shorter than `closer`; the larger ball of each cluster stays."""
    a, b = edges.T
    short = np.hypot(*(nodes[a] - nodes[b])[:, :2].T) < closer
    count, label = connected_pieces(a[short], b[short], len(nodes))
    order = np.argsort(nodes[:, 2])
    keeper = np.zeros(count, dtype=np.intp)
    keeper[label[order]] = order
    links = np.sort(label[edges], axis=1)
    links = np.unique(links[links[:, 0] != links[:, 1]], axis=0)
    return nodes[keeper], links.astype(np.intp)


def _hidden(nodes: Array) -> Flags:
    """Mark balls that stick out of a larger one, itself not hidden, by less than `STUB`."""
    x, y, radius = nodes.T
    hidden = np.zeros(len(nodes), dtype=bool)
    # One ball at a time: a table of all pairs would not fit for a hundred thousand samples.
    for k in np.argsort(-radius, kind="stable").tolist():
        if not hidden[k]:
            within = np.hypot(x - x[k], y - y[k]) + radius <= (1.0 + STUB) * radius[k]
            within[k] = False
            hidden |= within
    return hidden


def _pruned(nodes: Array, edges: Index) -> Skeleton:
    """Remove leaves and twigs that add nothing to the union of the balls."""
    hidden = _hidden(nodes).tolist()
    neighbours: list[set[int]] = [set() for _ in nodes]
    for a, b in edges.tolist():
        neighbours[a].add(b)
        neighbours[b].add(a)
    alive = [True] * len(nodes)

    leaves = [i for i, n in enumerate(neighbours) if len(n) == 1]
    while leaves:
        i = leaves.pop()
        if not alive[i] or len(neighbours[i]) != 1:
            continue
        (j,) = neighbours[i]
        if hidden[i]:
            neighbours[j].discard(i)
            neighbours[i].clear()
            alive[i] = False
            leaves.append(j)

    keep = np.flatnonzero(alive)
    number = np.full(len(nodes), -1, dtype=np.intp)
    number[keep] = np.arange(len(keep))
    pairs = {(min(a, b), max(a, b)) for a in keep.tolist() for b in neighbours[a]}
    links = np.array(sorted(pairs), dtype=np.intp).reshape(-1, 2)
    return Skeleton(nodes[keep], number[links])


def chordal_axis(outline: Outline) -> Skeleton:
    """Compute the pruned axis of an outline, one node for each triangle.

    Parameters
    ----------
    outline : Outline
        Sampled evenly enough that its edges are not much longer than limbs are thick.
    """
    parts, links, offset = [], [], 0
    for outer in outline.outers:
        holes = tuple(outline.rings[j] for j in outline.holes_of(outer))
        mesh = triangulate(outline.rings[outer], holes)
        after, _ = ring_links([len(r) for r in (outline.rings[outer], *holes)])
        centre, radius = _centres(mesh, RimDistance(mesh.points, after))
        closer = COINCIDENT * float(np.ptp(mesh.points, axis=0).max())
        axis = _pruned(*_merged(np.column_stack([centre, radius]), mesh.across, closer))
        parts.append(axis.nodes)
        links.append(axis.edges + offset)
        offset += len(axis.nodes)
    return Skeleton(np.concatenate(parts), np.concatenate(links))


def chains(skeleton: Skeleton) -> list[list[int]]:
    """Split the graph into chains between ends and junctions; rings come closed."""
    neighbours: list[list[int]] = [[] for _ in skeleton.nodes]
    for a, b in skeleton.edges.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    done: set[tuple[int, int]] = set()
    chains = []

    def walk(start: int, following: int) -> None:
        path = [start, following]
        while len(neighbours[path[-1]]) == 2 and path[-1] != start:
            one, two = neighbours[path[-1]]
            path.append(two if one == path[-2] else one)
        done.update(itertools.pairwise(path))
        done.update(zip(path[1:], path[:-1], strict=True))
        chains.append(path)

    for special in (True, False):
        for node, around in enumerate(neighbours):
            if special and len(around) == 2:
                continue
            for other in around:
                if (node, other) not in done:
                    walk(node, other)
    return chains


def _douglas_peucker(chain: Array, tolerance: float) -> list[int]:
    """Return the indices of the vertices kept of an open polyline (n, d)."""
    keep, stack = {0, len(chain) - 1}, [(0, len(chain) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        base = chain[b] - chain[a]
        square = float(base @ base)
        offset = chain[a + 1 : b] - chain[a]
        t = np.clip(offset @ base / square, 0.0, 1.0) if square > 0 else np.zeros(b - a - 1)
        away = ((offset - t[:, None] * base) ** 2).sum(axis=1)
        worst = int(away.argmax())
        # Thin limbs bend within their own thickness: the tolerance follows the radius.
        if away[worst] > min(tolerance, 0.25 * chain[a + 1 + worst, 2]) ** 2:
            middle = a + 1 + worst
            keep.add(middle)
            stack += [(a, middle), (middle, b)]
    return sorted(keep)


def _tip(row: Array, end: int, inwards: int) -> int:
    """Return the node of a chain (n, 3) about `TIP` radii from its free end."""
    away = np.hypot(*(row[:, :2] - row[end, :2]).T)[::inwards]
    far = int(np.argmax(away >= TIP * row[end, 2]))
    return end + inwards * far


def simplified(axis: Skeleton, tolerance: float) -> Skeleton:
    """Simplify an axis by Douglas-Peucker in (x, y, r), then split long edges.

    Parameters
    ----------
    axis : Skeleton
        A chordal axis.
    tolerance : float
        Allowed deviation in position and radius, in the unit of the skeleton.
    """
    nodes: list[Array] = []
    edges: list[tuple[int, int]] = []
    number: dict[int, int] = {}

    def node_of(old: int) -> int:
        if old not in number:
            number[old] = len(nodes)
            nodes.append(axis.nodes[old])
        return number[old]

    ends = axis.degrees
    for chain in chains(axis):
        row = axis.nodes[chain]
        if chain[0] == chain[-1]:
            half = len(chain) // 2
            kept = _douglas_peucker(row[: half + 1], tolerance)
            kept += [half + k for k in _douglas_peucker(row[half:], tolerance)[1:]]
        else:
            kept = _douglas_peucker(row, tolerance)
        for at, inwards in ((0, 1), (-1, -1)):
            if ends[chain[at]] == 1:
                kept.append(_tip(row, len(row) - 1 if at else 0, inwards))
        kept = sorted(set(kept))
        for i, j in itertools.pairwise(kept):
            a, b = row[i], row[j]
            length = float(np.hypot(*(b - a)[:2]))
            # Splits fall on the axis itself, not on the chord that replaced it.
            pieces = min(int(np.ceil(length / (SPLIT * max(min(a[2], b[2]), tolerance)))), j - i, 8)
            stops = [i + round(k * (j - i) / pieces) for k in range(1, pieces)]
            path = [node_of(chain[i])]
            for stop in stops:
                path.append(node_of(chain[stop]))
            path.append(node_of(chain[j]))
            edges += [(p, q) for p, q in itertools.pairwise(path) if p != q]
    connected = {k for edge in axis.edges.tolist() for k in edge}
    for old in range(len(axis.nodes)):
        if old not in connected:
            node_of(old)
    unique = sorted({(min(e), max(e)) for e in edges})
    return with_lone_balls(np.array(nodes), np.array(unique, dtype=np.intp).reshape(-1, 2))


def with_lone_balls(nodes: Array, edges: Index) -> Skeleton:
    """Return a skeleton with a short segment for every ball without one, as in a disc."""
    lone = np.setdiff1d(np.arange(len(nodes)), edges)
    shift = np.column_stack([0.1 * nodes[lone, 2], np.zeros((len(lone), 2))])
    longer = np.concatenate([nodes, nodes[lone] + shift])
    longer[lone] -= shift
    short = np.column_stack([lone, len(nodes) + np.arange(len(lone))])
    return Skeleton(longer, np.concatenate([edges, short]).astype(np.intp))
