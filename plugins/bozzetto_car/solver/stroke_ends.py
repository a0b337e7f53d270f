"""Marks that are sharpened by the ends of strokes: so strokes have a say in cameras and shape.

A stroke along an edge whose nodes follow it begins and ends at nodes, and a pen is steadier than a
finger that touches a point. A node's place in a sketch is the mean of its mark and of the ends of
strokes there, weighted by the inverse of their variances. An end that is far from the mark does not
reach the node: its weight falls with the distance, continuously, as Geman and McClure's does.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from bozzetto_car.state import Mark, Sketch, TracedEdges

STEADY: Final = 4.0
"""Variance of a mark per variance of the end of a stroke."""

FAR: Final = 0.005
"""Distance of an end from its mark, in diagonals of the picture, at which it has a quarter of its
weight."""


def sharpened(sketch: Sketch, edits: Iterable[object]) -> Sketch:
    """Return a sketch whose marks are what they and the strokes on it tell of the nodes.

    Parameters
    ----------
    sketch : Sketch
        The sketch as a person has marked it.
    edits : iterable
        Edits of the body. Strokes count that were drawn on this sketch along edges that they name,
        with nodes that follow, on a body that was not stretched, before anything was dragged or
        treated: that stays where it was put, whatever is traced later.
    """
    marked = {mark.node: (mark.u, mark.v) for mark in sketch.marks}
    ends: dict[str, list[tuple[float, float]]] = {}
    for edit in edits:
        if not isinstance(edit, TracedEdges):
            break
        if (
            edit.sketch == sketch.id
            and edit.nodes_follow
            and edit.edges
            and not edit.dimensions.given()
        ):
            for node, place in _ends(edit, marked):
                ends.setdefault(node, []).append(place)
    if not ends:
        return sketch
    far = FAR * math.hypot(*sketch.size)
    marks = tuple(
        _mean(mark, sorted(ends[mark.node]), far) if mark.node in ends else mark
        for mark in sketch.marks
    )
    return replace(sketch, marks=marks)


def _ends(
    edit: TracedEdges, marked: dict[str, tuple[float, float]]
) -> list[tuple[str, tuple[float, float]]]:
    """Return the marked nodes at which a stroke begins and ends, with its places there, px."""
    stroke = edit.strokes[0]
    first, last = ((float(stroke.x[k]), float(stroke.y[k])) for k in (0, -1))
    one, other = _outer_nodes(edit.edges)
    along, against = ([(one, first), (other, last)], [(one, last), (other, first)])
    kept = [[(node, place) for node, place in row if node in marked] for row in (along, against)]
    return min(kept, key=lambda row: sum(math.dist(marked[node], place) for node, place in row))


def _outer_nodes(edges: tuple[str, ...]) -> tuple[str, str]:
    """Return the nodes at both ends of a row of edges that are named by their nodes."""
    rows = [name.split("-", 1) for name in edges]
    if len(rows) == 1:
        return rows[0][0], rows[0][-1]
    one = next((node for node in rows[0] if node not in rows[1]), rows[0][0])
    other = next((node for node in rows[-1] if node not in rows[-2]), rows[-1][-1])
    return one, other


def _mean(mark: Mark, ends: list[tuple[float, float]], far: float) -> Mark:
    own = (mark.u, mark.v)
    weights = [STEADY / (1.0 + (math.dist(own, end) / far) ** 2) ** 2 for end in ends]
    total = 1.0 + sum(weights)
    u, v = (
        (own[axis] + sum(w * end[axis] for w, end in zip(weights, ends, strict=True))) / total
        for axis in (0, 1)
    )
    return replace(mark, u=u, v=v)
