"""Solids upright on the ground, and the view that shows them there as they were drawn.

A drawing says how a solid looks, not where the ground is: as it comes from the sheet it leans. What
is turned on the ground is the whole sheet, so that drawings which are not solids yet come along.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Placement
from bozzetto_polyhedron.mechanism.pieces import sides_of
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.same_view import view_of
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solve.pipeline import solved

BELOW: Final = 1e-6
"""Distance in extents of the body by which a vertex may lie under the face it stands on."""


def standing_of(body: Body, made: PlanarBody) -> Placement | None:
    """Return how a body is moved to stand on z = 0; None where no face can carry it.

    It stands on the face that looks down most among those that all of it lies above, the longest
    edge of that face along an axis, and turns to the front (−y) what the drawing shows in front.

    Parameters
    ----------
    body : Body
        The drawing.
    made : PlanarBody
        What became of it, where it stands now.
    """
    number = foot_of(made)
    if number is None:
        return None
    rotation = upright(made, number, view_of(body).axes[2])
    turned = Placement(rotation).points(made.vertices)
    middle = 0.5 * (turned.min(axis=0) + turned.max(axis=0))
    x, y = np.asarray(body.strokes[0].camera.target)[:2] - middle[:2]
    return Placement(rotation, 1.0, (float(x), float(y), -float(turned[:, 2].min())))


def stood(before: PolyhedronState, after: PolyhedronState, body_id: str) -> PolyhedronState:
    """Return a state in which the sheet of a solid stands on the ground, or as it is.

    The first solid of a drawing, or the first box without a lid, decides where the ground is.
    Whatever becomes of it, it goes on standing as long as it stands. Nothing is moved that hangs
    together with other things, and no linkage.

    Parameters
    ----------
    before, after : PolyhedronState
        A change of the solid, which may be its first answer.
    body_id : str
        Which body it is.
    """
    body = after.node(body_id)
    if not isinstance(body, Body) or not _may_stand(after, body) or not _stands(before, body_id):
        return after
    found = solved(body, after)
    if found.body is None or not (found.body.closed or _has_floor(found.body)):
        return after
    way = standing_of(body, found.body)
    return after if way is None or way.is_identity else with_sheet_moved(after, body, way)


def with_sheet_moved(state: PolyhedronState, body: Body, way: Placement) -> PolyhedronState:
    """Return a state in which all drawings that lie where a body lies go the same way."""
    nodes = tuple(
        replace(each, placement=way.after(each.placement))
        if isinstance(each, Body) and each.placement == body.placement
        else each
        for each in state.nodes
    )
    return replace(state, nodes=nodes)


def foot_of(body: PlanarBody) -> int | None:
    """Return the face that looks down most among those with the whole body on one side."""
    slack = BELOW * float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    heights = body.vertices @ body.normals.T - body.offsets
    holds = heights.max(axis=0) <= slack
    if not holds.any():
        return None
    return int(np.argmin(np.where(holds, body.normals[:, 2], np.inf)))


def _has_floor(body: PlanarBody) -> bool:
    """Whether walls rise from every side of the face on which a sheet would stand, as in a box."""
    number = foot_of(body)
    if number is None:
        return False
    sides = {pair for rings in body.faces for pair in sides_of(rings)}
    return all((end, begin) in sides for begin, end in sides_of(body.faces[number]))


def _may_stand(state: PolyhedronState, body: Body) -> bool:
    """Whether a body is a solid by itself, whose sheet nobody has put anywhere else."""
    bodies = state.of_kind(Body)
    return (
        body.choice is not None
        and all(each.moves == "whole" and not each.anchors for each in bodies)
        and not state.fittings()
        and not state.of_kind(Followed)
        and state.moved is None
        and not any(each.choice is not None for each in bodies if each.id != body.id)
    )


def _stands(state: PolyhedronState, body_id: str) -> bool:
    """Whether a body was only drawn so far, or was put on the ground."""
    body = state.node(body_id)
    return isinstance(body, Body) and (body.choice is None) == body.placement.is_identity


def upright(body: PlanarBody, number: int, sight: Array) -> tuple[float, ...]:
    """Return the rotation, row by row, that turns a face down.

    The longest edge of the face comes along x or y, so that walls that are square to it become
    planes of the axes, and the eye comes to the front: to within 45° of −y, seen from above.

    Parameters
    ----------
    body : PlanarBody
        Where it lies now.
    number : int
        Of the face.
    sight : (3,) array
        The way in which it is looked at.
    """
    down = body.normals[number]
    ring = body.vertices[list(body.faces[number][0])]
    edges = np.roll(ring, -1, axis=0) - ring
    along = edges[int(np.argmax(np.linalg.norm(edges, axis=1)))]
    along = along - (along @ down) * down
    along = along / np.linalg.norm(along)
    rows = np.stack((along, np.cross(-down, along), -down))
    eye = rows @ -sight
    quarters = round(float(np.arctan2(eye[0], -eye[1])) / (0.5 * np.pi)) % 4
    for _ in range(quarters):  # exact: no sines of right angles
        rows = np.stack((rows[1], -rows[0], rows[2]))
    return tuple(float(value) for value in rows.ravel())
