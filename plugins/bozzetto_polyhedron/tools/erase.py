"""The eraser: it takes away strokes, before and after a drawing was turned into a solid."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes, distances_to_polyline, resample
from bozzetto.plugin import Context, Ink, Tool, override
from bozzetto_polyhedron.model.changes import Added, Change, Join
from bozzetto_polyhedron.model.same_view import into_drawing
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.change_lines import change_lines
from bozzetto_polyhedron.solve.followed import Sources
from bozzetto_polyhedron.solve.moving import NOTHING, moving
from bozzetto_polyhedron.solve.picking import corner_places
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.solve.spots import hung_on
from bozzetto_polyhedron.view.fittings import seen_ends

REACH: Final = 9.0
"""Half the width of the eraser, px."""

MOST: Final = 0.35
"""Share of a stroke that must be rubbed over for it to go."""

LOOKS: Final = 48
"""Places of a stroke that are looked at."""


class ErasingTool(Tool[PolyhedronState]):
    """A tool of the modeler: the pen's other end does the same with all of them."""

    @override
    def erase(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Take away what the path lies over."""
        return erased(state, ink.strokes[-1], context.sources)


class Erase(ErasingTool):
    """The eraser for those whose pen has no other end."""

    id = "erase"
    title = "Erase"
    icon = "icons/erase.svg"
    hint = "Rub along the lines that are to go."

    @override
    def draw(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Take away what the paths lie over."""
        for stroke in ink.strokes:
            state = erased(state, stroke, context.sources)
        return state


def erased(state: PolyhedronState, path: Stroke, sources: Sources = NOTHING) -> PolyhedronState:
    """Return the state without the strokes that a path was rubbed over.

    Raises
    ------
    UserError
        If there is nothing under it.
    """
    before = state
    for body in before.shown(Body):
        for change in before.changes_of(body):
            state = _without_rubbed(state, before, body, change, path)
    if state is not before:
        return state
    for body in before.shown(Body):
        rubbed = _rubbed(body, before, path)
        kept = [stroke for k, stroke in enumerate(body.strokes) if k not in rubbed]
        if not kept:
            own = (*state.measures_of(body), *state.slants_of(body), *state.changes_of(body))
            gone = [each.id for each in own]
            gone += [each.id for each in state.of_kind(Join) if each.other == body.id]
            gone += [each.id for each in hung_on(body.id, state)]
            state = state.without_nodes(body.id, *gone)
        elif rubbed:
            state = state.with_node(replace(body, strokes=Strokes(kept)))
    state = _without_fittings(state, before, path, sources)
    if state is before:
        raise UserError("There is no line under the eraser. Rub along the one that is to go.")
    return state


def _without_rubbed(
    state: PolyhedronState, before: PolyhedronState, body: Body, change: Change, path: Stroke
) -> PolyhedronState:
    """Return the state without the lines of a change that a path lies over."""
    rubbed = []
    for number, line in enumerate(change_lines(body, before, change)):
        if not len(line):
            continue
        places, _ = path.camera.project(line)
        if np.isfinite(places).all() and _is_over(path.points, places):
            rubbed.append(number)
    if not rubbed:
        return state
    if not isinstance(change, Added | Join) or len(rubbed) == len(change.strokes):
        return replace(state.without_nodes(change.id), selected=body.id)
    kept = [stroke for k, stroke in enumerate(change.strokes) if k not in rubbed]
    return state.with_node(replace(change, strokes=Strokes(kept)))


def _without_fittings(
    state: PolyhedronState, before: PolyhedronState, path: Stroke, sources: Sources
) -> PolyhedronState:
    """Return the state without the fittings that a path was rubbed over."""
    if not before.fittings():
        return state
    made = moving(before, sources)
    for fitting in before.fittings():
        ends = seen_ends(before, made, fitting)
        if ends is None:
            continue
        seen = path.camera.project(ends)[0]
        if np.isfinite(seen).all() and _is_over(path.points, seen):
            state = state.without_nodes(fitting.id)
    return state


def _rubbed(body: Body, state: PolyhedronState, path: Stroke) -> set[int]:
    """Return the numbers of the strokes of a body that a path lies over."""
    own = into_drawing(path, body)
    if own is not None:
        return {
            number
            for number, stroke in enumerate(body.strokes)
            if _is_over(own.points, stroke.points)
        }
    found = solved(body, state)
    places = corner_places(body, found, path.camera)
    covered = [
        number
        for number, line in enumerate(found.graph.lines)
        if np.isfinite(places[line]).all() and _is_over(path.points, places[line])
    ]
    return {stroke for number in covered for stroke in found.graph.strokes[number]}


def _is_over(path: Array, line: Array) -> bool:
    looked = resample(line, count=LOOKS) if len(line) > 1 else line
    return bool((distances_to_polyline(looked, path) <= REACH).mean() >= MOST)
