"""A mechanism where its motion has taken it."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Mesh
from bozzetto.scene import Item, Points, Shaded, shaded_part
from bozzetto_polyhedron.mechanism.assembly import Motion
from bozzetto_polyhedron.model.followed import Followed
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.solid.face_rings import area_vector
from bozzetto_polyhedron.solid.triangulation import face_triangles
from bozzetto_polyhedron.solve.moving import Moving
from bozzetto_polyhedron.solve.placing import followed_part
from bozzetto_polyhedron.view.drawing_layers import segments
from bozzetto_polyhedron.view.solid_layers import EDGE_WIDTH, faceted

ANCHOR_SIZE: Final = 12.0
"""Diameter of a corner that is held, px."""


BAR_WIDTH: Final = 3.0
"""Of bars that are flat, px."""

PIN_SIZE: Final = 7.0
"""Diameter of the corners of bars, px."""


def moved_vertices(state: PolyhedronState, made: Moving, body_id: str) -> Array:
    """Return the vertices of a body where they are now, (n, 3) mm."""
    return made.machine.moved(made.numbers[body_id], made.motion(state.moved))


def moved_items(body: Body, made: Moving, motion: Motion) -> list[Item]:
    """Return bars, plates or the whole of a body where its motion has taken it."""
    number = made.numbers[body.id]
    shape = made.machine.shapes[number]
    items: list[Item] = []
    for face, piece in zip(shape.faces, made.machine.plates[number], strict=False):
        holders = np.full(len(shape.vertices), int(piece))
        vertices = made.machine.moved(number, motion, holders)
        items += _plate(vertices, face, body)
    if not len(made.machine.plates[number]):
        vertices = made.machine.moved(number, motion)
        width = BAR_WIDTH if shape.moves == "flat" else EDGE_WIDTH
        items.append(segments(vertices[shape.edges], "ink", width))
        items.append(Points(vertices[np.unique(shape.edges)].astype(np.float32), size=PIN_SIZE))
    return items


def followed_items(part: Followed, made: Moving, motion: Motion) -> list[Item]:
    """Return a body of another object where its motion has taken it."""
    return list(shaded_part(followed_part(part, made, motion)))


def anchor_items(body: Body | Followed, made: Moving, motion: Motion) -> list[Item]:
    """Return marks at the corners that are held."""
    held = made.machine.shapes[made.numbers[body.id]].anchors
    if not held:
        return []
    vertices = made.machine.moved(made.numbers[body.id], motion)
    places = vertices[list(held)].astype(np.float32)
    return [Points(places, color="second", size=ANCHOR_SIZE, hidden="show")]


def _plate(vertices: Array, face: tuple[tuple[int, ...], ...], body: Body) -> list[Item]:
    normal = area_vector(vertices[list(face[0])])
    length = float(np.linalg.norm(normal))
    rings = [np.stack((vertices[list(r)], np.roll(vertices[list(r)], -1, axis=0)), 1) for r in face]
    items: list[Item] = [segments(np.concatenate(rings), "ink", EDGE_WIDTH, hidden="faint")]
    if length > 0.0:
        triangles = face_triangles(vertices, face, normal / length)
        mesh = faceted(Mesh(vertices.astype(np.float32), triangles.astype(np.int32)))
        items.append(Shaded(mesh, color=body.color or "clay"))
    return items
