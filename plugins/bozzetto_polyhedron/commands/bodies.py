"""Commands on bodies: a new one, on the ground, of sheet, with right angles."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Placement
from bozzetto.plugin import Context
from bozzetto_polyhedron.commands.answers import chosen_body
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solve.pipeline import solved

SHEET: Final = 0.02
"""Thickness of a sheet in extents of the body, where none is given yet."""

BELOW: Final = 1e-6
"""Distance in extents of the body by which a vertex may lie under the face it stands on."""


def begin_body(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with nothing chosen: the next stroke away from all drawings begins anew."""
    return replace(state, selected="")


def right_angles(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with right angles made exact, or left as drawn."""
    return replace(state, exact=not state.exact)


def unfolded(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state whose files get nets to cut and fold, or solids again."""
    return replace(state, files="solids" if state.files != "solids" else "nets")


def sheet(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with the chosen body of sheet metal, or solid again."""
    body = chosen_body(state)
    if body.wall > 0.0:
        return state.with_node(replace(body, wall=0.0))
    found = solved(body, state)
    if found.body is None:
        raise UserError(found.problem or "This drawing is no solid yet. Draw on.")
    extent = float(np.linalg.norm(np.ptp(found.body.vertices, axis=0)))
    return state.with_node(replace(body, wall=float(f"{SHEET * extent:.1g}")))


def on_the_ground(state: PolyhedronState, context: Context) -> PolyhedronState:
    """Return the state with the chosen body standing on z = 0.

    It stands on the face that looks down most among those that all of it lies above.
    """
    body = chosen_body(state)
    found = solved(body, state)
    if found.body is None:
        raise UserError(found.problem or "This drawing is no solid yet. Draw on.")
    number = foot_of(found.body)
    if number is None:
        raise UserError("This body has no face to stand on. Turn it with the object's handles.")
    rotation = upright(found.body, number)
    turned = Placement(rotation).points(found.body.vertices)
    middle = 0.5 * (turned.min(axis=0) + turned.max(axis=0))
    target = np.asarray(body.strokes[0].camera.target)
    x, y = (float(target[k] - middle[k]) for k in (0, 1))
    standing = Placement(rotation, 1.0, (x, y, -float(turned[:, 2].min())))
    return state.with_node(replace(body, placement=standing.after(body.placement)))


def foot_of(body: PlanarBody) -> int | None:
    """Return the face that looks down most among those with the whole body on one side."""
    slack = BELOW * float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    heights = body.vertices @ body.normals.T - body.offsets
    holds = heights.max(axis=0) <= slack
    if not holds.any():
        return None
    return int(np.argmin(np.where(holds, body.normals[:, 2], np.inf)))


def upright(body: PlanarBody, number: int) -> tuple[float, ...]:
    """Return the rotation, row by row, that turns a face down and the longest edge of it along x.

    So walls that are square to it become planes of the world's axes.
    """
    down = body.normals[number]
    ring = body.vertices[list(body.faces[number][0])]
    edges = np.roll(ring, -1, axis=0) - ring
    along = edges[int(np.argmax(np.linalg.norm(edges, axis=1)))]
    along = along - (along @ down) * down
    return _rows(along / np.linalg.norm(along), -down)


def _rows(x_axis: Array, z_axis: Array) -> tuple[float, ...]:
    turn = np.stack((x_axis, np.cross(z_axis, x_axis), z_axis))
    return tuple(float(value) for value in turn.ravel())
