"""Which body a stroke belongs to, and bodies of a whole drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes, on_sheet_of
from bozzetto_polyhedron.model.same_view import into_drawing, is_one_sheet, with_stroke
from bozzetto_polyhedron.model.state import Body, Choice, PolyhedronState

BESIDE: Final = 0.1
"""Distance from a drawing, in its extents, within which a stroke belongs to it."""

GROWING: Final = 0.5
"""The same, in heights of the canvas, for the body that is being drawn and was not turned yet: its
next line may be the far side."""

TOUCH: Final = 0.02
"""Distance of two ends, in heights of the canvas, at which a stroke makes one drawing of two."""

IN_PLACE: Final = Placement()

FEWEST: Final = 6
"""Strokes of the smallest solid, a tetrahedron: fewer are no drawing of their own."""

DOT: Final = 3.0
"""Extent of ink, px, below which it is no line."""


def with_strokes(state: PolyhedronState, strokes: Sequence[Stroke]) -> PolyhedronState:
    """Return the state with strokes in the bodies that they belong to, or in new ones.

    Raises
    ------
    UserError
        If a stroke is a dot.
    """
    for stroke in strokes:
        if float(np.linalg.norm(np.ptp(stroke.points, axis=0))) < DOT:
            raise UserError(
                "This is a dot. Draw an edge from corner to corner.",
                places=[(float(stroke.x[0]), float(stroke.y[0]))],
            )
        state = _with_stroke(state, stroke)
    return state


def new_body(
    state: PolyhedronState,
    strokes: Sequence[Stroke],
    choice: Choice | None = None,
    placement: Placement = IN_PLACE,
) -> PolyhedronState:
    """Return the state with one more body, selected, of strokes of one view.

    Parameters
    ----------
    state : PolyhedronState
        A model.
    strokes : sequence of Stroke
        In the frame of the new drawing.
    choice : Choice, optional
        Of the solid that the drawing shows; None until somebody turns it.
    placement : Placement
        Where the sheet of the drawing lies now.
    """
    camera = strokes[0].camera
    return state.with_node(
        Body(
            id=state.unused_id(),
            name=state.unused_name("Body"),
            strokes=Strokes([on_sheet_of(stroke, camera) for stroke in strokes]),
            choice=choice,
            placement=placement,
        )
    )


def drawings_in(strokes: Sequence[Stroke]) -> list[list[Stroke]]:
    """Return the strokes of each body of a whole drawing, in the order drawn.

    Strokes of one view with one name are one body. Of the others, those of one view are together
    whose bounding boxes overlap, a little enlarged: a hole lies inside what it is a hole of.
    """
    named: list[list[Stroke]] = []
    for stroke in strokes:
        if not stroke.group:
            continue
        for body in named:
            if body[0].group == stroke.group and is_one_sheet(stroke.camera, body[0].camera):
                body.append(stroke)
                break
        else:
            named.append([stroke])
    return [*named, *_apart([stroke for stroke in strokes if not stroke.group])]


def parted(
    state: PolyhedronState, body: Body, place: Array | None = None
) -> tuple[PolyhedronState, Body]:
    """Return the state with drawings that lie beside one another in bodies of their own.

    Parameters
    ----------
    state : PolyhedronState
        With the body in it.
    body : Body
        Left as it is where somebody turned or held it.
    place : (2,) array, optional
        Of its drawing, px: the drawing there keeps the body; without, the one that was begun first.

    Returns
    -------
    PolyhedronState, Body
        The second value is the body of the drawing at the place, with all marks that are no
        drawing.
    """
    groups = _apart(list(body.strokes)) if _is_begun(body) else []
    drawings = [group for group in groups if len(group) >= FEWEST]
    if len(drawings) < 2:
        return state, body
    own = drawings[0] if place is None else min(drawings, key=lambda each: _away(each, place))
    others = [stroke for group in drawings if group is not own for stroke in group]
    gone = {id(stroke) for stroke in others}
    for group in drawings:
        if group is not own:
            part = replace(body, id=state.unused_id(), name=state.unused_name("Body"))
            state = state.with_node(replace(part, strokes=Strokes(group)))
    rest = [stroke for stroke in body.strokes if id(stroke) not in gone]
    body = replace(body, strokes=Strokes(rest))
    return state.with_node(body), body


def _away(strokes: Sequence[Stroke], place: Array) -> float:
    """Return the distance of ink from a place, px."""
    points = np.concatenate([each.points for each in strokes])
    return float(np.linalg.norm(points - place, axis=1).min())


def _with_stroke(state: PolyhedronState, stroke: Stroke) -> PolyhedronState:
    sheet: tuple[Stroke, Placement] | None = None
    for body in _candidates(state):
        own = into_drawing(stroke, body)
        if own is None:
            continue
        sheet = sheet or (own, body.placement)
        if _is_near(body, own, stroke, body.id == state.selected):
            body = with_stroke(body, own, stroke.camera)
            return _with_what_it_touches(state.with_node(body), body, own, stroke)
    own, placement = sheet or (stroke, IN_PLACE)
    return new_body(state, [own], placement=placement)


def _with_what_it_touches(
    state: PolyhedronState, body: Body, own: Stroke, drawn: Stroke
) -> PolyhedronState:
    """Return the state with one body of all drawings of one sheet at which a stroke of one ends.

    Lines of one drawing may begin far from one another. Only drawings that nobody turned yet are
    joined; the one that was begun first stays, and is chosen.

    Parameters
    ----------
    state : PolyhedronState
        With the stroke in it.
    body : Body
        To which the stroke belongs.
    own, drawn : Stroke
        The stroke on the canvas of the body, and on the one on which it was drawn.
    """
    reach = TOUCH * _seen_height(drawn, own)
    numbers = [each.id for each in state.of_kind(Body)]
    others = [each for each in state.shown(Body) if each.id != body.id and _is_begun(each)]
    for other in others if _is_begun(body) else ():
        if other.placement != body.placement:
            continue
        strokes = [into_drawing(each, replace(body, placement=IN_PLACE)) for each in other.strokes]
        others_here = [each for each in strokes if each is not None]
        if len(others_here) < len(strokes) or not _touches(own, others_here, reach):
            continue
        first, second = sorted((body, other), key=lambda each: numbers.index(each.id))
        moved = [into_drawing(s, replace(first, placement=IN_PLACE)) for s in second.strokes]
        ink = [*first.strokes, *(each for each in moved if each is not None)]
        body = replace(first, strokes=Strokes(ink))
        state = state.without_nodes(second.id).with_node(body)
    return state


def _is_begun(body: Body) -> bool:
    """Whether a body is nothing but lines that nobody turned or held yet."""
    return body.choice is None and body.moves == "whole" and not body.anchors and not body.guessed


def _seen_height(drawn: Stroke, own: Stroke) -> float:
    """Return how high the canvas on which a stroke was drawn is on that of its body, px."""
    canvas = own.camera
    return canvas.viewport[1] * drawn.camera.visible_height / canvas.visible_height


def _touches(stroke: Stroke, others: Sequence[Stroke], reach: float) -> bool:
    """Whether an end of a stroke is within reach of an end of another one, px."""
    ends = stroke.points[[0, -1]]
    places = np.concatenate([each.points[[0, -1]] for each in others])
    apart = np.linalg.norm(ends[:, None] - places, axis=2)
    return bool(apart.min() <= reach)


def _candidates(state: PolyhedronState) -> list[Body]:
    """Return the bodies that are shown, the chosen one first, then the newest."""
    bodies = [body for body in reversed(state.shown(Body)) if len(body.strokes)]
    return sorted(bodies, key=lambda body: body.id != state.selected)


def _is_near(body: Body, own: Stroke, drawn: Stroke, is_chosen: bool) -> bool:
    """Whether a stroke, on the canvas of a body and as it was drawn, belongs to its drawing."""
    low, high = _box([each.points for each in body.strokes])
    reach = BESIDE * float(np.linalg.norm(high - low))
    if is_chosen and body.choice is None:
        reach = max(reach, GROWING * _seen_height(drawn, own))
    inside = np.clip(own.points, low, high)
    return bool(np.linalg.norm(own.points - inside, axis=1).min() <= reach)


def _apart(strokes: Sequence[Stroke]) -> list[list[Stroke]]:
    """Return strokes in groups of one view whose boxes overlap."""
    groups: list[list[Stroke]] = []
    for stroke in strokes:
        group = [stroke]
        while touched := [other for other in groups if _overlap(group, other)]:
            groups = [other for other in groups if other not in touched]
            group = [each for part in (*touched, group) for each in part]
        groups.append(group)
    order = {id(stroke): number for number, stroke in enumerate(strokes)}
    return [sorted(group, key=lambda each: order[id(each)]) for group in groups]


def _overlap(one: Sequence[Stroke], other: Sequence[Stroke]) -> bool:
    camera = one[0].camera
    if not is_one_sheet(camera, other[0].camera):
        return False
    boxes = [_box([on_sheet_of(each, camera).points for each in group]) for group in (one, other)]
    reach = BESIDE * max(float(np.linalg.norm(high - low)) for low, high in boxes)
    (low, high), (low_other, high_other) = boxes
    return bool((low - reach <= high_other).all() and (low_other - reach <= high).all())


def _box(paths: Sequence[Array]) -> tuple[Array, Array]:
    points = np.vstack(paths)
    return points.min(axis=0), points.max(axis=0)
