"""Parts as an untidy hand draws them: lines gone over again, in two, and beyond their corners."""

from __future__ import annotations

import numpy as np

from tests.plugins.polyhedron.hand import SIZE, Hand, strokes_of
from tests.plugins.polyhedron.objects import TO_CANVAS, Polyhedron, view

HAND = Hand(retraced=0.15, split=0.1, overshot=0.3)


def untidy(solid: Polyhedron | None, seed: int):
    """Return the strokes of a part, where its corners are (px), and its edges."""
    assert solid is not None
    seen = view(solid, seed)
    assert seen is not None
    edges = [(int(a), int(b)) for a, b in solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    strokes = strokes_of(seen.plane * TO_CANVAS, edges, HAND, seed, hidden)
    return strokes, seen.plane * TO_CANVAS * SIZE + 200.0, edges
