"""Strokes from one body to another that join them.

Strokes from every corner of a face to the corners of the other body's face are the edges of a
bridge between them. A stroke from face to face makes one of bodies that overlap. Any other one says
where they touch: the other body comes along the line of sight, which no drawing of its own tells,
until the end of the stroke lies in the face that it began at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.body_hits import Met, met_by
from bozzetto_polyhedron.drawing_on.copies import joined, moved
from bozzetto_polyhedron.solid.boolean import combined
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import shells_of, volume_of

FEWEST_LINKS: Final = 3
"""Strokes from corner to corner, fewer than which bound no bridge."""

EDGE_ON: Final = 0.1
"""Cosine between the line of sight and the normal of a face below which nothing slides onto it."""

OVERLAP: Final = 1e-9
"""Share of the smaller volume that two bodies must share to count as joined already."""


@dataclass(frozen=True, eq=False)
class Joined:
    """Result of joining two bodies.

    Parameters
    ----------
    body : PlanarBody or None
        Both as one; None where there are not strokes enough yet.
    shift : (3,) float64
        How far the second one came, mm.
    lines : (m, 2, 3) float64
        The strokes in space, where there are not enough yet.
    told : str
        What is missing; "" where nothing is.
    """

    body: PlanarBody | None
    shift: Array = field(default_factory=lambda: np.zeros(3))
    lines: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))
    told: str = ""


def joined_by(
    first: PlanarBody,
    second: PlanarBody,
    strokes: Sequence[tuple[Array, Camera]],
    reach: float,
) -> Joined:
    """Join two bodies by strokes from the first to the second.

    Parameters
    ----------
    first, second : PlanarBody
        Closed, in one frame.
    strokes : sequence of ((n, 2) float, Camera)
        Each with its camera; in either direction.
    reach : float
        Distance within which ends meet corners and edges, px.

    Raises
    ------
    UserError
        If a stroke does not run from one to the other, or they would not touch.
    """
    links = [_link(first, second, stroke, camera, reach) for stroke, camera in strokes]
    if all(one.case == two.case == "corner" for one, two in links):
        if _shares(first, second):
            return Joined(combined(first, second, "union"))
        lines = np.array([(one.point, two.point) for one, two in links])
        if len(links) < FEWEST_LINKS:
            return Joined(None, lines=lines, told=_MORE)
        try:
            return Joined(joined(first, second, [(one.number, two.number) for one, two in links]))
        except UserError as problem:
            return Joined(None, lines=lines, told=str(problem))
    one, two = links[-1]
    if one.case == two.case == "face" and _shares(first, second):
        return Joined(combined(first, second, "union"))
    shift = _slide(first, one, two, strokes[-1][1])
    whole = combined(first, moved(second, shift), "union")
    if len(shells_of(whole.faces)) >= len(shells_of(first.faces)) + len(shells_of(second.faces)):
        raise UserError(
            "The two bodies would not touch. Draw the line to where they meet, or turn the view."
        )
    return Joined(whole, shift)


_MORE: Final = (
    "Lines run from one body to the other: draw one from every corner of a face to a corner of "
    "the other face, and they become one."
)


def _link(
    first: PlanarBody, second: PlanarBody, stroke: Array, camera: Camera, reach: float
) -> tuple[Met, Met]:
    """Return what the ends of a stroke meet of the first body, and of the second."""
    for ends in (stroke[[0, -1]], stroke[[-1, 0]]):
        one, two = (
            met_by(body, camera, place, reach)
            for body, place in zip((first, second), ends, strict=True)
        )
        if one is not None and two is not None:
            return one, two
    raise UserError("This line does not run from one body to the other any more. Erase it.")


def _shares(first: PlanarBody, second: PlanarBody) -> bool:
    """Whether two bodies overlap or touch along a face."""
    apart = np.maximum(
        first.vertices.min(axis=0) - second.vertices.max(axis=0),
        second.vertices.min(axis=0) - first.vertices.max(axis=0),
    )
    if (apart > OVERLAP * np.ptp(first.vertices, axis=0).max()).any():
        return False
    whole = combined(first, second, "union")
    pieces = len(shells_of(first.faces)) + len(shells_of(second.faces))
    gained = volume_of(first) + volume_of(second) - volume_of(whole)
    least = OVERLAP * min(volume_of(first), volume_of(second))
    return gained > least or len(shells_of(whole.faces)) < pieces


def _slide(first: PlanarBody, one: Met, two: Met, camera: Camera) -> Array:
    """Return the way along the line of sight that takes a point into the face another lies in."""
    sights = camera.rays(camera.project(two.point[None])[0]).directions
    sight = sights[0]
    facing = first.normals[list(one.faces)] @ sight
    number = int(np.argmin(facing))
    if facing[number] > -EDGE_ON:
        raise UserError("This face is seen edge-on. Turn the view, and draw the line again.")
    face = one.faces[number]
    gap = float(first.offsets[face] - first.normals[face] @ two.point)
    return np.asarray(sight * gap / float(first.normals[face] @ sight))
