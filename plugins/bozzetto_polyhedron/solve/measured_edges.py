"""Edges that dimensions were typed at, and the two faces that each of them sets apart."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.model.fittings import Place
from bozzetto_polyhedron.model.state import Dimension, Measure
from bozzetto_polyhedron.reconstruction.answer import Answer, Rings

PARALLEL: Final = 0.97
"""Cosine between the normals of faces that are meant parallel: 14°, as the exact planes take it."""

NEAR: Final = 0.05
"""Distance from the place of a corner to where a dimension was typed, in extents of the drawing,
beyond which that corner is gone."""


def dimensions_of(
    measures: Iterable[Measure], graph: LineGraph, answer: Answer
) -> tuple[Dimension, ...]:
    """Return typed dimensions by the faces of an answer; what is gone with its edge is left out."""
    found = []
    for measure in measures:
        edge = edge_at(graph, measure.begin, measure.end)
        faces = None if edge is None else faces_apart(answer, edge)
        if faces is not None:
            found.append(Dimension(faces, measure.length))
    return tuple(found)


def edge_at(graph: LineGraph, begin: Place, end: Place) -> tuple[int, int] | None:
    """Return the two corners that lie where an edge was, if they still do."""
    if not len(graph.places):
        return None
    reach = NEAR * float(np.linalg.norm(np.ptp(graph.places, axis=0)))
    ends = []
    for place in (begin, end):
        away = np.linalg.norm(graph.places - place, axis=1)
        ends.append(int(np.argmin(away)))
        if away[ends[-1]] > reach:
            return None
    return (ends[0], ends[1]) if ends[0] != ends[1] else None


def faces_apart(answer: Answer, edge: tuple[int, int]) -> tuple[int, int] | None:
    """Return two parallel faces, one at each end of an edge, that are furthest apart along it.

    The first one is that at the first corner; None where there are none.
    """
    along = answer.vertices[edge[1]] - answer.vertices[edge[0]]
    length = float(np.linalg.norm(along))
    if length == 0.0:
        return None
    normals = [face_normal(answer.vertices, rings) for rings in answer.faces]
    at = [
        [k for k, rings in enumerate(answer.faces) if any(corner in ring for ring in rings)]
        for corner in edge
    ]
    best, steepest = None, 1.0 - PARALLEL
    for first in at[0]:
        for second in at[1]:
            steep = abs(float(normals[first] @ along)) / length
            alike = abs(float(normals[first] @ normals[second]))
            if first != second and alike > PARALLEL and steep > steepest:
                best, steepest = (first, second), steep
    return best


def face_normal(vertices: Array, rings: Rings) -> Array:
    """Return the unit normal of a face by Newell's sum over its outer ring; zeros without area."""
    points = vertices[list(rings[0])]
    total = np.cross(points - points[0], np.roll(points, -1, axis=0) - points[0]).sum(axis=0)
    length = float(np.linalg.norm(total))
    return np.asarray(total / length if length > 0.0 else np.zeros(3))
