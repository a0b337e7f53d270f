"""Cameras and strokes in the frame of a body's drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes, is_one_view, on_sheet_of
from bozzetto.view import Camera
from bozzetto_polyhedron.model.state import Body, PolyhedronState

SLACK: Final = 1e-7
"""Difference between two cameras, relative to their distance, that moving a body and back makes."""


def is_same(one: Camera, other: Camera) -> bool:
    """Return whether two cameras show the same, up to a body's way there and back."""
    return is_one_view(one, other, SLACK)


def is_as_large(one: Camera, other: Camera) -> bool:
    """Return whether two cameras show the same, and show it as large on canvases of one height."""
    is_enlarged = one.kind == "orthographic" and abs(one.height - other.height) > SLACK * one.height
    return is_same(one, other) and not is_enlarged


def is_one_sheet(one: Camera, other: Camera) -> bool:
    """Return whether lines on the sheet of one camera are seen by the other as they were drawn.

    The view may have been moved and enlarged since, and its perspective switched on or off.
    """
    return bool(np.abs(one.axes - other.axes).max() < SLACK)


def is_one_picture(one: Camera, other: Camera) -> bool:
    """Return whether two cameras show a solid alike: the same, with perspective or without."""
    reach = SLACK * one.visible_height
    return is_same(one, other) or bool(
        one.kind != other.kind
        and abs(one.visible_height - other.visible_height) < reach
        and np.abs(np.subtract(one.target, other.target)).max() < reach
        and is_one_sheet(one, other)
    )


def camera_of(body: Body) -> Camera:
    """Return the camera of a body's drawing, in the frame of the drawing."""
    return body.strokes[0].camera


def view_of(body: Body) -> Camera:
    """Return the camera that sees the body, where it stands now, as it was drawn."""
    return camera_of(body).moved(body.placement)


def into_drawing(stroke: Stroke, body: Body) -> Stroke | None:
    """Return a stroke of the model's frame in that of a body's drawing; None in another view."""
    own = stroke if body.placement.is_identity else stroke.moved(body.placement.inverse())
    return on_sheet_of(own, camera_of(body)) if _shows_drawing(own.camera, body) else None


def where_seen(stroke: Stroke, state: PolyhedronState, seen: Sequence[PolyhedronState]) -> Stroke:
    """Return a stroke where that lies now on which it was drawn: a hand may be quicker than a view.

    Parameters
    ----------
    stroke : Stroke
        In the model's frame, drawn in the view of now or of a moment ago.
    state : PolyhedronState
        As it is now.
    seen : sequence of PolyhedronState
        As it was a moment ago, newest first, while the view showed drawings as they were drawn.
    """
    bodies = {body.id: body for body in state.shown(Body) if len(body.strokes)}
    if any(is_one_sheet(stroke.camera, view_of(body)) for body in bodies.values()):
        return stroke
    for earlier in seen:
        for before in earlier.shown(Body):
            now = bodies.get(before.id)
            if now is not None and is_one_sheet(stroke.camera, view_of(before)):
                return stroke.moved(way_of(before, now))
    return stroke


def way_of(before: Body, now: Body) -> Placement:
    """Return how a body was moved in space from an earlier state to one of now."""
    return now.placement.after(before.placement.inverse())


def drawing_seen(body: Body, camera: Camera) -> tuple[Stroke, ...] | None:
    """Return the strokes of a body's drawing as a view shows them; None where it shows none.

    A view in the model's frame gives strokes on its own canvas.
    """
    own = camera.moved(body.placement.inverse())
    if not _shows_drawing(own, body):
        return None
    return tuple(on_sheet_of(stroke, own) for stroke in body.strokes)


def _shows_drawing(camera: Camera, body: Body) -> bool:
    """Whether a view, in the frame of a drawing, shows it as it was drawn.

    A drawing that nobody turned yet is flat: it looks the same wherever the view was moved. A solid
    looks so in the view of its drawing alone.
    """
    shows = is_one_sheet if body.choice is None else is_one_picture
    return shows(camera, camera_of(body))


def with_stroke(body: Body, own: Stroke, seen: Camera) -> Body:
    """Return a body with one more stroke of its drawing.

    Where the perspective was switched on or off since, the drawing goes over to the view of now.

    Parameters
    ----------
    body : Body
        The body that is drawn on.
    own : Stroke
        On the canvas of the drawing; see `into_drawing`.
    seen : Camera
        Through which it was drawn, in the frame of the model.
    """
    camera = seen.moved(body.placement.inverse())
    if camera.kind == own.camera.kind:
        return replace(body, strokes=body.strokes.extended([own]))
    return replace(body, strokes=Strokes([on_sheet_of(s, camera) for s in (*body.strokes, own)]))


def on_sheet(body: Body, places: Array) -> Array:
    """Return places of a drawing (n, 2) px in space, on its sheet; mm, in the model's frame.

    The sheet is the plane through the target of the drawing's camera, square to its view.
    """
    camera = camera_of(body)
    return body.placement.points(camera.on_plane(places, camera.target, camera.axes[2]))
