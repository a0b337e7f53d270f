"""Faces that were told to keep the angle that was drawn, with all that are parallel to them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.model.state import Slant
from bozzetto_polyhedron.reconstruction.answer import Answer
from bozzetto_polyhedron.solve.measured_edges import NEAR, PARALLEL, face_normal


def slanted_faces(slants: Iterable[Slant], graph: LineGraph, answer: Answer) -> tuple[int, ...]:
    """Return the faces of an answer that keep their angles; what is gone is left out."""
    found: set[int] = set()
    normals = [face_normal(answer.vertices, rings) for rings in answer.faces]
    for slant in slants:
        face = face_at(slant, graph, answer)
        if face is not None:
            found |= {k for k, n in enumerate(normals) if abs(n @ normals[face]) > PARALLEL}
    return tuple(sorted(found))


def face_at(slant: Slant, graph: LineGraph, answer: Answer) -> int | None:
    """Return the face whose corners lie where those of a face were, if it is still there."""
    if not len(graph.places) or not slant.corners:
        return None
    reach = NEAR * float(np.linalg.norm(np.ptp(graph.places, axis=0)))
    away = np.linalg.norm(graph.places[:, None] - np.array(slant.corners)[None], axis=2)
    corners = {int(k) for k in away.argmin(axis=0)[away.min(axis=0) <= reach]}
    shared = [len(corners & set(rings[0])) / len(corners | set(rings[0])) for rings in answer.faces]
    best = int(np.argmax(shared)) if shared else -1
    return best if best >= 0 and shared[best] > 0.5 else None
