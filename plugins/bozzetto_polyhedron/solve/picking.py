"""Corners and edges under the pen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import distances_to_polyline
from bozzetto.view import Camera
from bozzetto_polyhedron.model.changes import Join
from bozzetto_polyhedron.model.same_view import is_one_sheet, is_same, on_sheet, view_of
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.rounds.round_curves import RoundCurve
from bozzetto_polyhedron.solve.pipeline import Solved, solved
from bozzetto_polyhedron.solve.round_lines import is_column, round_lines

REACH: Final = 22.0
"""Distance from the pen to what it touches, px: half a finger."""


@dataclass(frozen=True, eq=False)
class Touched:
    """Thing under the pen.

    Parameters
    ----------
    body : Body
    found : Solved
    distance : float
        px.
    number : int
        Of the corner, or of the line, in the graph.
    """

    body: Body
    found: Solved
    distance: float
    number: int


@dataclass(frozen=True, eq=False)
class TouchedRound(Touched):
    """Rim or arc under the pen; its number is that of the corner nearest to it.

    Parameters
    ----------
    curve : RoundCurve
        As it was drawn.
    """

    curve: RoundCurve


def solids_in(state: PolyhedronState) -> list[Body]:
    """Return the bodies that can be drawn on and are shown by themselves, the chosen one first."""
    joined = {each.other for each in state.shown(Join)}
    return [
        body
        for body in state.chosen_first()
        if body.choice is not None and not (body.id in joined and _is_joined(body, state))
    ]


def _is_joined(body: Body, state: PolyhedronState) -> bool:
    """Whether a body has become part of another one."""
    owners = {each.body for each in state.shown(Join) if each.other == body.id}
    for other in state.shown(Body):
        if other.id in owners and len(other.strokes):
            changed = solved(other, state).changed
            if changed is not None and body.id in changed.joined:
                return True
    return False


def corner_at(state: PolyhedronState, camera: Camera, place: Array) -> Touched | None:
    """Return the nearest corner within reach, of any body."""
    best: Touched | None = None
    for body in _bodies(state):
        found = solved(body, state)
        away = np.linalg.norm(corner_places(body, found, camera) - place, axis=1)
        number = _smallest(away)
        if number >= 0 and away[number] <= (REACH if best is None else best.distance):
            best = Touched(body, found, float(away[number]), number)
    return best


def round_line_at(state: PolyhedronState, camera: Camera, place: Array) -> TouchedRound | None:
    """Return the nearest rim or arc within reach, of any body."""
    best: TouchedRound | None = None
    for body in _bodies(state):
        found = solved(body, state)
        if body.choice is None and not is_one_sheet(camera, view_of(body)):
            continue
        for line in round_lines(body, found):
            seen = camera.project(line.points)[0] if len(line.points) > 1 else line.points[:, :2]
            if len(seen) < 2 or not np.isfinite(seen).all() or not len(found.graph.places):
                continue
            away = float(distances_to_polyline(np.reshape(place, (1, 2)), seen)[0])
            if away <= (REACH if best is None else best.distance):
                middle = line.curve.drawn.mean(axis=0)
                number = _smallest(np.linalg.norm(found.graph.places - middle, axis=1))
                best = TouchedRound(body, found, away, number, line.curve)
    return best


def edge_at_place(state: PolyhedronState, camera: Camera, place: Array) -> Touched | None:
    """Return the nearest line within reach, of any body."""
    best: Touched | None = None
    for body in _bodies(state):
        found = solved(body, state)
        places = corner_places(body, found, camera)
        for number, line in enumerate(found.graph.lines):
            ends = places[line]
            if not np.isfinite(ends).all():
                continue
            away = float(distances_to_polyline(np.reshape(place, (1, 2)), ends)[0])
            if away <= (REACH if best is None else best.distance):
                best = Touched(body, found, away, number)
    return best


def corner_places(body: Body, found: Solved, camera: Camera) -> Array:
    """Return where the corners of a body are seen, (n, 2) px; NaN where they are not.

    Before a drawing is turned, they are there in the view of the drawing alone. What has nothing
    but cylinders has none.
    """
    view = view_of(body)
    if is_column(body):  # the box about it has corners that nobody drew
        return np.full((len(found.graph.places), 2), np.nan)
    if (is_one_sheet if body.choice is None else is_same)(camera, view):
        return camera.project(on_sheet(body, found.graph.places))[0]
    if found.base is not None:
        return camera.project(found.base.vertices)[0]
    if found.answer is not None:
        return camera.project(body.placement.points(found.answer.vertices))[0]
    return np.full((len(found.graph.places), 2), np.nan)


def _bodies(state: PolyhedronState) -> list[Body]:
    return state.chosen_first()


def _smallest(values: Array) -> int:
    """Return the number of the smallest value that is one; -1 where there is none."""
    known = np.where(np.isfinite(values), values, np.inf)
    return int(np.argmin(known)) if len(known) and np.isfinite(known.min()) else -1
