"""The eraser: it takes away strokes, before and after a drawing was turned into a solid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes, distances_to_polyline, resample
from bozzetto.plugin import Context, Ink, Tool, override
from bozzetto_polyhedron.model.changes import Added, Change, Join
from bozzetto_polyhedron.model.same_view import drawing_seen
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solve.change_lines import change_lines
from bozzetto_polyhedron.solve.followed import Sources
from bozzetto_polyhedron.solve.moving import NOTHING, moving
from bozzetto_polyhedron.solve.picking import corner_places
from bozzetto_polyhedron.solve.pipeline import solved
from bozzetto_polyhedron.solve.round_lines import round_lines
from bozzetto_polyhedron.solve.spots import hung_on
from bozzetto_polyhedron.view.fittings import seen_ends

Takes = Callable[[Array, Array], bool]
"""Whether a path, (n, 2) px, takes a line, (m, 2) px."""

REACH: Final = 9.0
"""Half the width of the eraser, px."""

MOST: Final = 0.35
"""Share of a stroke that must be rubbed over for it to go."""

ENDS: Final = 0.08
"""Share of a line at either end where a path that crosses it may mean another line there."""

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
    hint = "Rub along the lines that are to go, or strike them out."
    group = "Corrections"

    @override
    def draw(self, state: PolyhedronState, ink: Ink, context: Context) -> PolyhedronState:
        """Take away what the paths lie over."""
        for stroke in ink.strokes:
            state = erased(state, stroke, context.sources)
        return state


def erased(state: PolyhedronState, path: Stroke, sources: Sources = NOTHING) -> PolyhedronState:
    """Return the state without the strokes that a path was rubbed over.

    Where it lies along none, those go that it crosses.

    Raises
    ------
    UserError
        If there is nothing under it.
    """
    for takes in (_is_over, _crosses):
        found = _without_taken(state, path, sources, takes)
        if found is not state:
            return found
    raise UserError(
        "There is no line under the eraser. Rub along the one that is to go, or across it."
    )


def _without_taken(
    before: PolyhedronState, path: Stroke, sources: Sources, takes: Takes
) -> PolyhedronState:
    """Return the state without what a path takes: what was drawn on bodies, else their strokes."""
    state = before
    for body in before.shown(Body):
        for change in before.changes_of(body):
            state = _without_rubbed(state, before, body, change, path, takes)
    if state is not before:
        return state
    for body in before.shown(Body):
        rubbed = _rubbed(body, before, path, takes)
        kept = [stroke for k, stroke in enumerate(body.strokes) if k not in rubbed]
        if not kept:
            own = (*state.measures_of(body), *state.round_sizes_of(body), *state.slants_of(body))
            own = (*own, *state.openings_of(body), *state.changes_of(body))
            gone = [each.id for each in own]
            gone += [each.id for each in state.of_kind(Join) if each.other == body.id]
            gone += [each.id for each in hung_on(body.id, state)]
            state = state.without_nodes(body.id, *gone)
        elif rubbed:
            state = state.with_node(replace(body, strokes=Strokes(kept)))
    return _without_fittings(state, before, path, sources, takes)


def _without_rubbed(
    state: PolyhedronState,
    before: PolyhedronState,
    body: Body,
    change: Change,
    path: Stroke,
    takes: Takes,
) -> PolyhedronState:
    """Return the state without the lines of a change that a path takes."""
    rubbed = []
    for number, line in enumerate(change_lines(body, before, change)):
        if not len(line):
            continue
        places, _ = path.camera.project(line)
        if np.isfinite(places).all() and takes(path.points, places):
            rubbed.append(number)
    if not rubbed:
        return state
    if not isinstance(change, Added | Join) or len(rubbed) == len(change.strokes):
        return replace(state.without_nodes(change.id), selected=body.id)
    kept = [stroke for k, stroke in enumerate(change.strokes) if k not in rubbed]
    return state.with_node(replace(change, strokes=Strokes(kept)))


def _without_fittings(
    state: PolyhedronState,
    before: PolyhedronState,
    path: Stroke,
    sources: Sources,
    takes: Takes,
) -> PolyhedronState:
    """Return the state without the fittings that a path takes."""
    if not before.fittings():
        return state
    made = moving(before, sources)
    for fitting in before.fittings():
        ends = seen_ends(before, made, fitting)
        if ends is None:
            continue
        seen = path.camera.project(ends)[0]
        if np.isfinite(seen).all() and takes(path.points, seen):
            state = state.without_nodes(fitting.id)
    return state


def _rubbed(body: Body, state: PolyhedronState, path: Stroke, takes: Takes) -> set[int]:
    """Return the numbers of the strokes of a body that a path takes."""
    drawn = drawing_seen(body, path.camera)
    if drawn is not None:
        return {n for n, stroke in enumerate(drawn) if takes(path.points, stroke.points)}
    found = solved(body, state)
    places = corner_places(body, found, path.camera)
    covered = [
        number
        for number, line in enumerate(found.graph.lines)
        if np.isfinite(places[line]).all() and takes(path.points, places[line])
    ]
    rubbed = {stroke for number in covered for stroke in found.graph.strokes[number]}
    for line in round_lines(body, found):
        seen = path.camera.project(line.points)[0] if len(line.points) > 1 else np.zeros((0, 2))
        if len(seen) and np.isfinite(seen).all() and takes(path.points, seen):
            rubbed |= line.curve.strokes
    return rubbed


def _crosses(path: Array, line: Array) -> bool:
    """Whether a path runs across a line, not at its ends."""
    if len(path) < 2 or len(line) < 2:
        return False
    line = resample(line, count=LOOKS)
    along, across = np.diff(line, axis=0)[None], np.diff(path, axis=0)[:, None]
    apart = path[:-1, None] - line[None, :-1]
    area = along[..., 0] * across[..., 1] - along[..., 1] * across[..., 0]
    area = np.where(area == 0.0, np.inf, area)
    at_line = (apart[..., 0] * across[..., 1] - apart[..., 1] * across[..., 0]) / area
    at_path = (apart[..., 0] * along[..., 1] - apart[..., 1] * along[..., 0]) / area
    met = (at_line >= 0.0) & (at_line < 1.0) & (at_path >= 0.0) & (at_path <= 1.0)
    met &= np.isfinite(area)
    shares = (np.arange(LOOKS - 1) + at_line) / (LOOKS - 1)
    return bool((met & (shares > ENDS) & (shares < 1.0 - ENDS)).any())


def _is_over(path: Array, line: Array) -> bool:
    looked = resample(line, count=LOOKS) if len(line) > 1 else line
    return bool((distances_to_polyline(looked, path) <= REACH).mean() >= MOST)
