"""The list of edits by hand: drags are merged, edits are taken back.

Only the drags at the end of the list are ever changed: a drag before a stroke or a treatment has
another meaning than one after it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from bozzetto.view import triple
from bozzetto_car.state import BentEdge, MovedNode, TracedEdges, Treatment

Edit = TracedEdges | MovedNode | BentEdge | Treatment
Edits = tuple[Edit, ...]


def add_drag(edits: Edits, drag: MovedNode | BentEdge) -> Edits:
    """Return the edits with one more drag, merged with a recent drag of the same node or tangent.

    Moves of a node add up; of a tangent the last one counts. So the list does not grow while a
    person drags the same few handles back and forth.
    """
    first = len(edits)
    while first and _is_drag(edits[first - 1], drag):
        first -= 1
    kept, row = edits[:first], list(edits[first:])
    for number, edit in enumerate(row):
        if isinstance(edit, MovedNode) and isinstance(drag, MovedNode) and edit.node == drag.node:
            row[number] = replace(edit, by=triple(np.add(edit.by, drag.by)))
            return (*kept, *row)
        if isinstance(edit, BentEdge) and isinstance(drag, BentEdge):
            if (edit.edge, edit.end) == (drag.edge, drag.end):
                del row[number]
                break
    return (*kept, *row, drag)


def _is_drag(edit: Edit, other: Edit) -> bool:
    """Whether an edit is a drag in the same dimensions as another."""
    if not isinstance(edit, MovedNode | BentEdge):
        return False
    return (edit.dimensions, edit.kept) == (other.dimensions, other.kept)


def without_last_of(edits: Edits, edges: Iterable[str]) -> Edits | None:
    """Return the edits without the last one that bent any of some edges; None if there is none.

    Parameters
    ----------
    edits : tuple of edits
        All edits, oldest first.
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
