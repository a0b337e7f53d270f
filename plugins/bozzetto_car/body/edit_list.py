"""The row of what was done to a body by hand: drags that add up, edits that are taken back.

Only a row of drags at its end is ever changed: before a stroke or a treatment a drag means
something else than after it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from bozzetto_car.state import BentEdge, MovedNode, TracedEdges, Treatment

Edit = TracedEdges | MovedNode | BentEdge | Treatment
Edits = tuple[Edit, ...]


def dragged(edits: Edits, drag: MovedNode | BentEdge) -> Edits:
    """With one more drag; a node, or a tangent, that was dragged just before is so only once.

    Moves of a node add up, of a tangent the last one counts. So a row does not grow as long as
    somebody drags the same few handles to and fro.
    """
    first = len(edits)
    while first and _is_drag(edits[first - 1], drag):
        first -= 1
    kept, row = edits[:first], list(edits[first:])
    for number, edit in enumerate(row):
        if isinstance(edit, MovedNode) and isinstance(drag, MovedNode) and edit.node == drag.node:
            x, y, z = np.add(edit.by, drag.by).tolist()
            row[number] = replace(edit, by=(x, y, z))
            return (*kept, *row)
        if isinstance(edit, BentEdge) and isinstance(drag, BentEdge):
            if (edit.edge, edit.end) == (drag.edge, drag.end):
                del row[number]
                break
    return (*kept, *row, drag)


def _is_drag(edit: Edit, other: Edit) -> bool:
    """Whether an edit is a drag in the same world as another."""
    return isinstance(edit, MovedNode | BentEdge) and edit.dimensions == other.dimensions


def without_last_of(edits: Edits, edges: Iterable[str]) -> Edits | None:
    """Without the last stroke or drag that bent one of some edges; None if there is none.

    Parameters
    ----------
    edits : tuple of edits
    edges : iterable of str
        Names of edges.
    """
    names = {*edges}
    for number in reversed(range(len(edits))):
        edit = edits[number]
        bent = (
            edit.edges
            if isinstance(edit, TracedEdges)
            else (edit.edge,)
            if isinstance(edit, BentEdge)
            else ()
        )
        if names.intersection(bent):
            return edits[:number] + edits[number + 1 :]
    return None
