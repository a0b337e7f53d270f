"""The skeleton by the rules of SketchCo (Kukelova and Durikovic, 2007), to compare with.

A terminal triangle gives its incircle, a junction its circumcircle, a sleeve the better
overlapping of the two; the ball has the radius of that circle. Centres whose disc is
covered to 85 % by a neighbour's are redundant and are dropped.

The paper does not say how overlap is measured. Here a circle overlaps by its radius less
twice what of the radius sticks out of the outline. A junction whose circumcentre lies
outside of the outline takes its incircle.
"""

from __future__ import annotations

import heapq

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Triangulation, ring_links, triangulate
from bozzetto_silhouette.numerics.triangle_circles import circumcircles, covered_share, incircles
from bozzetto_silhouette.outline.medial_axis import Skeleton, with_lone_balls
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.outline.signed_distance import RimDistance

REDUNDANT = 0.85
"""Share of a disc that a neighbour's has to cover for the centre to be dropped."""


def paper_skeleton(outline: Outline) -> Skeleton:
    """Compute the skeleton of a sampled outline by the paper's rules.

    Parameters
    ----------
    outline : Outline
        Sampled about as densely as for `chordal_axis`.
    """
    nodes, links, offset = [], [], 0
    for outer in outline.outers:
        rings = [outline.rings[outer], *(outline.rings[j] for j in outline.holes_of(outer))]
        mesh = triangulate(rings[0], tuple(rings[1:]))
        after, _ = ring_links([len(ring) for ring in rings])
        balls = _balls(mesh, RimDistance(mesh.points, after))
        kept, edges = _without_redundant(balls, mesh.across)
        nodes.append(kept)
        links.append(edges + offset)
        offset += len(kept)
    return with_lone_balls(np.concatenate(nodes), np.concatenate(links))


def _balls(mesh: Triangulation, distance: RimDistance) -> Array:
    """Return one ball for every triangle: x, y and radius, (t, 3)."""
    corners = mesh.points[mesh.triangles]
    around, wide = circumcircles(corners)
    inside, narrow = incircles(corners)
    depth = distance(around).distance
    chords = (mesh.sides >= 0).sum(axis=1)
    sticks_out = np.maximum(wide - depth, 0.0), np.maximum(narrow - distance(inside).distance, 0.0)
    better = wide - 2.0 * sticks_out[0] >= narrow - 2.0 * sticks_out[1]
    outer = np.where(chords == 3, depth > 0.0, (chords == 2) & better)
    centre = np.where(outer[:, None], around, inside)
    return np.column_stack([centre, np.where(outer, wide, narrow)])


def _without_redundant(nodes: Array, edges: Index) -> tuple[Array, Index]:
    """Contract covered nodes into the neighbour that covers them most, smallest first.

    The neighbour has to cover what was contracted into them before, too: else one node would
    swallow a whole limb, step by step.
    """
    neighbours: list[set[int]] = [set() for _ in nodes]
    for a, b in edges.tolist():
        neighbours[a].add(b)
        neighbours[b].add(a)
    swallowed = [[i] for i in range(len(nodes))]
    alive = np.ones(len(nodes), dtype=bool)
    queue = [(r, i) for i, r in enumerate(nodes[:, 2].tolist())]
    heapq.heapify(queue)
    while queue:
        _, i = heapq.heappop(queue)
        if not alive[i] or not neighbours[i]:
            continue
        near = np.array(sorted(neighbours[i]))
        share = _least_covered(nodes[swallowed[i]], nodes[near])
        best = int(share.argmax())
        if share[best] < REDUNDANT:
            continue
        alive[i] = False
        heir = int(near[best])
        swallowed[heir] += swallowed[i]
        for j in neighbours[i]:
            neighbours[j].discard(i)
            if j != heir:
                neighbours[j].add(heir)
                neighbours[heir].add(j)
                heapq.heappush(queue, (float(nodes[j, 2]), j))
        neighbours[i].clear()
        heapq.heappush(queue, (float(nodes[heir, 2]), heir))
    number = np.cumsum(alive) - 1
    pairs = sorted({(i, j) for i, around in enumerate(neighbours) for j in around if i < j})
    return nodes[alive], number[np.array(pairs, dtype=np.intp).reshape(-1, 2)].astype(np.intp)


def _least_covered(discs: Array, others: Array) -> Array:
    """Return for each of the other balls (k, 3) the least share of any disc (n, 3) it covers."""
    one, two = discs[:, None, :], others[None, :, :]
    gap = np.hypot(one[..., 0] - two[..., 0], one[..., 1] - two[..., 1])
    shape = gap.shape
    radius, other = np.broadcast_to(one[..., 2], shape), np.broadcast_to(two[..., 2], shape)
    least: Array = covered_share(gap, radius, other).min(axis=0)
    return least
