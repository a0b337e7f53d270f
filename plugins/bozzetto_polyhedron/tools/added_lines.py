"""A stroke that meets a solid is added to it, whatever the view; one between two joins them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.ink import Stroke, Strokes, on_canvas
from bozzetto_polyhedron.drawing_on.body_hits import Met, met_by
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.model.changes import Added, Join
from bozzetto_polyhedron.model.same_view import camera_of, into_drawing, is_as_large
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solve.changes import MEETS
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.solve.pipeline import changed_until, solved, with_change

_RANK: Final = ("corner", "edge", "face", "")

DOT: Final = 3.0
"""Extent of ink, px, below which it is no line."""


def with_added(state: PolyhedronState, stroke: Stroke) -> PolyhedronState | None:
    """Return the state with a stroke added to the solid that it meets; None where it meets none.

    Nothing is added while another drawing is in hand, or where a drawing seen in its own view is
    not yet right: the stroke belongs to that drawing then.

    Raises
    ------
    UserError
        If it meets a solid and is too short for a line.
    """
    chosen = state.body_of_chosen()
    solids = solids_in(state)
    if not solids or solids[0].id != chosen or np.ptp(stroke.points, axis=0).max() < DOT:
        return None
    ends = [_ends_on(body, state, stroke) for body in solids]
    if _mends(solids[0], state, stroke, ends[0][1]):
        return None
    pair = _pair(ends)
    if pair is not None:
        return _joined(state, solids[pair[0]], solids[pair[1]], stroke)
    for body, (_, met, loose) in zip(solids, ends, strict=True):
        if any(met) or loose:
            return _added(state, body, stroke)
    return None


def _ends_on(
    body: Body, state: PolyhedronState, stroke: Stroke
) -> tuple[Changed, tuple[Met | None, Met | None], bool]:
    """Return a solid, what of it both ends of a stroke meet, and whether one meets a loose line."""
    made = changed_until(body, state)
    own = _own(body, stroke)
    first, last = (met_by(made.body, own.camera, own.points[k], MEETS) for k in (0, -1))
    loose = False
    if len(made.points):
        seen, _ = own.camera.project(made.points)
        away = np.linalg.norm(seen[:, None] - own.points[[0, -1]][None], axis=2)
        loose = bool((away < MEETS).any())
    return made, (first, last), loose


def _own(body: Body, stroke: Stroke) -> Stroke:
    """Return a stroke of the model's frame in that of a body's drawing."""
    return stroke if body.placement.is_identity else stroke.moved(body.placement.inverse())


def _mends(
    body: Body, state: PolyhedronState, stroke: Stroke, met: tuple[Met | None, Met | None]
) -> bool:
    """Whether a stroke belongs to the drawing of a body: it is not right yet, or drawn over."""
    own = into_drawing(stroke, body)
    if own is None:
        return False
    found = solved(body, state)
    if found.graph.health or found.base is None or not found.base.closed:
        return True
    first, last = met
    if first is None or last is None or found.changed is None:
        return False
    return _is_along_edge(found.changed.body.faces, first, last)


def _is_along_edge(faces: Sequence[tuple[tuple[int, ...], ...]], first: Met, last: Met) -> bool:
    """Whether what both ends meet lies on one edge."""
    edges = [frozenset(edge) for edge in edges_of(faces).tolist()]

    def at(met: Met) -> set[frozenset[int]]:
        if met.case == "edge":
            return {edges[met.number]}
        if met.case == "corner":
            return {edge for edge in edges if met.number in edge}
        return set()

    return bool(at(first) & at(last))


def _pair(
    ends: Sequence[tuple[Changed, tuple[Met | None, Met | None], bool]],
) -> tuple[int, int] | None:
    """Return the two solids that a stroke runs between; None where both ends are on one.

    Where one is seen over the other, a corner is meant rather than an edge, and that rather than
    a face; else the one that is chosen.
    """
    owners = []
    for end in (0, 1):
        hits = [met[end] for _, met, _ in ends]
        cases = ["" if hit is None else hit.case for hit in hits]
        best = min(range(len(ends)), key=lambda k: _RANK.index(cases[k]))
        if not cases[best]:
            return None
        owners.append(best)
    one, two = owners
    return (min(one, two), max(one, two)) if one != two else None


def _added(state: PolyhedronState, body: Body, stroke: Stroke) -> PolyhedronState:
    own = _own(body, stroke)
    changes = state.changes_of(body)
    last = changes[-1] if changes else None
    if isinstance(last, Added) and is_as_large(last.strokes[0].camera, own.camera):
        camera = last.strokes[0].camera
        strokes = last.strokes.extended([on_canvas(own, camera)])
        return with_change(state, body, replace(last, strokes=strokes))
    camera = camera_of(body) if is_as_large(own.camera, camera_of(body)) else own.camera
    change = Added(
        id=state.unused_id(),
        name=state.unused_name("Lines"),
        body=body.id,
        strokes=Strokes([on_canvas(own, camera)]),
    )
    return with_change(state, body, change)


def _joined(state: PolyhedronState, first: Body, second: Body, stroke: Stroke) -> PolyhedronState:
    for join in state.changes_of(first):
        if isinstance(join, Join) and join.other == second.id:
            longer = replace(join, strokes=join.strokes.extended([stroke]))
            return with_change(state, first, longer)
    change = Join(
        id=state.unused_id(),
        name=state.unused_name("Joint"),
        body=first.id,
        other=second.id,
        strokes=Strokes([stroke]),
    )
    return with_change(state, first, change)
