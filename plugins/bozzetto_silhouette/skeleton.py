"""The skeleton: chordal axis of the triangulated outline, pruned, with exact radii.

Terminal, sleeve and junction triangles after Prasad, "Morphological analysis of shapes",
1997, and Igarashi et al., "Teddy", 1999; pruning by covered discs after Kukelova and
Durikovic, "SketchCo", 2007.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.distance import RimDistance, ring_links
from bozzetto_silhouette.outline import Outline
from bozzetto_silhouette.triangulation import Triangulation, constrained_delaunay

__all__ = ["Skeleton", "chordal_axis", "simplified", "skeleton_of"]

Points = NDArray[np.float64]
Indices = NDArray[np.intp]

COVERED = 0.85
"""A leaf is pruned when its disc is covered to this share by its neighbour's."""

STUB = 0.05
"""A leaf is pruned when it sticks out of its neighbour's disc by less than this share of
the neighbour's radius; a whole branch when it sticks out of the junction by `TWIG`."""
TWIG = 0.10

SPLIT = 2.0
"""Edges longer than this many radii are split: the fit needs the freedom."""


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

    nodes: Points
    edges: Indices

    @property
    def degrees(self) -> Indices:
        """Number of edges at each node, (n,)."""
        return np.bincount(self.edges.ravel(), minlength=len(self.nodes))

    def transformed(self, scale: float, shift: Points) -> Skeleton:
        """The skeleton of the outline scaled, then shifted."""
        nodes = self.nodes * scale
        nodes[:, :2] += shift
        return Skeleton(nodes, self.edges)

    def heights(self, xy: Points) -> Points:
        """Height of the union of the balls above points (k, 2); 0 outside of all."""
        gap2 = ((xy[:, None, :] - self.nodes[None, :, :2]) ** 2).sum(axis=2)
        best: Points = np.sqrt(np.maximum(self.nodes[:, 2] ** 2 - gap2, 0.0).max(axis=1))
        return best


def _axis_nodes(mesh: Triangulation) -> tuple[Points, Indices]:
    """Chord midpoints, terminal incentres and junction centres, with their edges."""
    p, sides = mesh.points, mesh.sides
    chord_count = len(mesh.chords)
    middles = p[mesh.chords].mean(axis=1) if chord_count else np.zeros((0, 2))
    kind = (sides >= 0).sum(axis=1)

    sleeve = sides[kind == 2]
    links = [sleeve[sleeve >= 0].reshape(-1, 2)]
    centres = []
    number = chord_count
    corner = p[mesh.triangles]
    for wanted in (0, 1, 3):
        rows = np.flatnonzero(kind == wanted)
        if not len(rows):
            continue
        a, b, c = corner[rows].transpose(1, 0, 2)
        # Side lengths opposite to a, b, c.
        la, lb, lc = (np.hypot(*(u - v).T)[:, None] for u, v in ((b, c), (c, a), (a, b)))
        incentre = (la * a + lb * b + lc * c) / (la + lb + lc)
        if wanted == 3:
            # Barycentric weights of the circumcentre; outside the triangle the clamped
            # weights give the nearest sensible point.
            wa = la**2 * (lb**2 + lc**2 - la**2)
            wb = lb**2 * (lc**2 + la**2 - lb**2)
            wc = lc**2 * (la**2 + lb**2 - lc**2)
            wa, wb, wc = (np.maximum(w, 0.0) for w in (wa, wb, wc))
            centre = (wa * a + wb * b + wc * c) / np.maximum(wa + wb + wc, 1e-300)
        else:
            centre = incentre
        own = number + np.arange(len(rows))
        number += len(rows)
        centres.append(centre)
        chord = sides[rows]
        owner = np.broadcast_to(own[:, None], chord.shape)
        links.append(np.stack([owner[chord >= 0], chord[chord >= 0]], axis=1))
    nodes = np.concatenate([middles, *centres])
    return nodes, np.concatenate(links).astype(np.intp)


def _pruned(nodes: Points, edges: Indices) -> Skeleton:
    """Remove leaves and twigs that add nothing to the union of the balls."""
    x, y, r = (column.tolist() for column in nodes.T)
    neighbours: list[set[int]] = [set() for _ in x]
    for a, b in edges.tolist():
        neighbours[a].add(b)
        neighbours[b].add(a)
    alive = [True] * len(x)

    def apart(i: int, j: int) -> float:
        return float(np.hypot(x[i] - x[j], y[i] - y[j]))

    def cut(i: int) -> int:
        j = neighbours[i].pop()
        neighbours[j].discard(i)
        alive[i] = False
        return j

    leaves = [i for i, n in enumerate(neighbours) if len(n) == 1]
    while leaves:
        i = leaves.pop()
        if not alive[i] or len(neighbours[i]) != 1:
            continue
        (j,) = neighbours[i]
        d = apart(i, j)
        covered = (r[j] + r[i] - d) >= COVERED * 2.0 * r[i]
        if covered or d + r[i] - r[j] < STUB * r[j]:
            leaves.append(cut(i))

    changed = True
    while changed:
        changed = False
        for leaf in [i for i, n in enumerate(neighbours) if alive[i] and len(n) == 1]:
            path, previous, here = [leaf], -1, leaf
            while len(neighbours[here] - {previous}) == 1 and (
                here == leaf or len(neighbours[here]) == 2
            ):
                (following,) = neighbours[here] - {previous}
                previous, here = here, following
                path.append(here)
            if len(neighbours[here]) < 3:
                continue
            out = max(apart(k, here) + r[k] - r[here] for k in path[:-1])
            if out < TWIG * r[here]:
                for k in path[:-1]:
                    cut(k)
                changed = True

    keep = np.flatnonzero(alive)
    number = np.full(len(x), -1, dtype=np.intp)
    number[keep] = np.arange(len(keep))
    pairs = {(min(a, b), max(a, b)) for a in keep.tolist() for b in neighbours[a]}
    links = np.array(sorted(pairs), dtype=np.intp).reshape(-1, 2)
    return Skeleton(nodes[keep], number[links])


def chordal_axis(outline: Outline) -> Skeleton:
    """The pruned chordal axis of an outline, one node for each chord.

    Parameters
    ----------
    outline : Outline
        Sampled evenly enough that its edges are not much longer than limbs are thick.
    """
    parts, links, offset = [], [], 0
    for outer in outline.outers:
        holes = tuple(outline.rings[j] for j in outline.holes_of(outer))
        mesh = constrained_delaunay(outline.rings[outer], holes)
        nodes, edges = _axis_nodes(mesh)
        after, _ = ring_links([len(r) for r in (outline.rings[outer], *holes)])
        radius = RimDistance(mesh.points, after)(nodes).distance
        axis = _pruned(np.column_stack([nodes, np.maximum(radius, 0.0)]), edges)
        parts.append(axis.nodes)
        links.append(axis.edges + offset)
        offset += len(axis.nodes)
    return Skeleton(np.concatenate(parts), np.concatenate(links))


def _chains(skeleton: Skeleton) -> list[list[int]]:
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
        done.update(zip(path[:-1], path[1:], strict=True))
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


def _douglas_peucker(chain: Points, tolerance: float) -> list[int]:
    """Indices of the vertices kept of an open polyline (n, d)."""
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


def simplified(axis: Skeleton, tolerance: float) -> Skeleton:
    """Fewer, longer edges: Douglas-Peucker in (x, y, r), then long edges split.

    Parameters
    ----------
    axis : Skeleton
        A chordal axis.
    tolerance : float
        Allowed deviation in position and radius, in the unit of the skeleton.
    """
    nodes: list[Points] = []
    edges: list[tuple[int, int]] = []
    number: dict[int, int] = {}

    def node_of(old: int) -> int:
        if old not in number:
            number[old] = len(nodes)
            nodes.append(axis.nodes[old])
        return number[old]

    for chain in _chains(axis):
        row = axis.nodes[chain]
        if chain[0] == chain[-1]:
            half = len(chain) // 2
            kept = _douglas_peucker(row[: half + 1], tolerance)
            kept += [half + k for k in _douglas_peucker(row[half:], tolerance)[1:]]
        else:
            kept = _douglas_peucker(row, tolerance)
        for i, j in zip(kept[:-1], kept[1:], strict=True):
            a, b = row[i], row[j]
            length = float(np.hypot(*(b - a)[:2]))
            # Splits fall on the axis itself, not on the chord that replaced it.
            pieces = min(int(np.ceil(length / (SPLIT * max(min(a[2], b[2]), tolerance)))), j - i, 8)
            stops = [i + round(k * (j - i) / pieces) for k in range(1, pieces)]
            path = [node_of(chain[i])]
            for stop in stops:
                path.append(node_of(chain[stop]))
            path.append(node_of(chain[j]))
            edges += [(p, q) for p, q in zip(path[:-1], path[1:], strict=True) if p != q]
    connected = {k for edge in axis.edges.tolist() for k in edge}
    for old in range(len(axis.nodes)):
        if old not in connected:
            # A lone ball, as in a disc: a short segment stands for it.
            x, y, r = axis.nodes[old]
            nodes += [np.array([x - 0.1 * r, y, r]), np.array([x + 0.1 * r, y, r])]
            edges.append((len(nodes) - 2, len(nodes) - 1))
    unique = sorted({(min(e), max(e)) for e in edges})
    return Skeleton(np.array(nodes), np.array(unique, dtype=np.intp).reshape(-1, 2))


def skeleton_of(outline: Outline, *, tolerance: float) -> Skeleton:
    """Chordal axis of an outline, simplified; see `chordal_axis` and `simplified`."""
    return simplified(chordal_axis(outline), tolerance)
