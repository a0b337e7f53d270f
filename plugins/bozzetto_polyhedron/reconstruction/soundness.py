"""How far a completed drawing is from a solid of which only the visible lines were drawn.

Its faces follow from its lines, but for parts that two corners join, which may be turned over. They
are planes if depths exist for which all are. Seen from one side or the other, they hide what was
added and nothing that was drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.graph.planar_embedding import (
    Ring,
    components,
    embedded_faces,
    neighbors_of,
)
from bozzetto_polyhedron.reconstruction.affine_depth import affine_depth
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.lifting import embeddings
from bozzetto_polyhedron.reconstruction.parallel_classes import parallel_classes
from bozzetto_polyhedron.reconstruction.visibility import hidden_shares

UNEVEN: Final = (0.1, 20.0)
"""Singular value up to which faces are planes, and in units of the noise if that is more: right
ones have 0.09 at most with 1 % of jitter, whose noise is 0.0046."""


def seen_otherwise(drawing: Drawing, points: Array, lines: Index, hidden: Array) -> float | None:
    """Return the share of the length of all lines that a solid shows otherwise than they are drawn.

    Parameters
    ----------
    drawing : Drawing
        Of the visible lines.
    points : (n, 2) array
        Corners of the whole solid in its picture.
    lines : (m, 2) array of int
        Its lines.
    hidden : (m,) array
        Share of each that was not drawn.

    Returns
    -------
    float or None
        1 where no solid has these lines; None where they are in several parts, so that they do not
        tell the faces.
    """
    neighbors = neighbors_of(lines)
    if len(components(neighbors)) != 1:
        return None
    rings = embedded_faces(neighbors)
    if rings is None:
        return 1.0
    whole = replace(drawing, points=points, lines=np.sort(lines, axis=1), light=hidden)
    return min((_misfit(whole, each) for each in embeddings(rings)), default=1.0)


def _misfit(whole: Drawing, rings: Sequence[Ring]) -> float:
    """Return that share with these faces, from whichever side; 1 if they lie in no planes."""
    faces = [(ring,) for ring in rings]
    corners = sorted({corner for ring in rings for corner in ring})
    found = affine_depth(whole, parallel_classes(whole), corners, faces)
    if found.residual > max(UNEVEN[0], UNEVEN[1] * whole.noise):
        return 1.0
    spread = np.std(whole.points) / max(float(np.std(found.depths)), 1e-12)
    lengths = whole.lengths / max(float(whole.lengths.sum()), 1e-12)
    seen = hidden_shares(whole, found.depths * spread, faces)
    return min(float(lengths @ np.abs(each - whole.light)) for each in seen)
