"""The solid in clay with crisp edges."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Mesh
from bozzetto.scene import Item, Label, Lines, Shaded
from bozzetto_polyhedron.drawing_on.changed import Changed
from bozzetto_polyhedron.drawing_on.cylinders import smooth_edges
from bozzetto_polyhedron.model.round_sizes import RimSize, RoundSize
from bozzetto_polyhedron.model.state import Body, Measure
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.hand_over import mesh_of
from bozzetto_polyhedron.solve.pipeline import Solved
from bozzetto_polyhedron.view.drawing_layers import segments

EDGE_WIDTH, CHOSEN_WIDTH = 1.8, 2.4
"""Widths of edges, px; of the body that is chosen."""

SHEET_OPACITY: Final = 0.6
"""Of faces that were added and bound no volume yet."""


def solid_items(body: Body, found: Solved, is_chosen: bool) -> list[Item]:
    """Return faces and edges of a body in the model's frame."""
    if found.changed is None:
        return []
    made = found.changed
    items: list[Item] = []
    if found.mesh is not None:
        items.append(Shaded(faceted(found.mesh), color=body.color or "clay"))
    edges = crisp_edges(made)
    if len(edges) and body.wall == 0.0:
        width = CHOSEN_WIDTH if is_chosen else EDGE_WIDTH
        items.append(segments(made.body.vertices[edges], "ink", width, hidden="faint"))
    return items


def crisp_edges(made: Changed) -> Index:
    """Return the edges of a body without those between the sides of a cylinder, (m, 2)."""
    edges = edges_of(made.body.faces)
    smooth = smooth_edges(made.body, made.circles)
    return np.array([e for e in edges.tolist() if tuple(e) not in smooth], np.intp).reshape(-1, 2)


def added_items(body: Body, found: Solved) -> list[Item]:
    """Return lines that were added and bound no volume yet, with the faces that they bound."""
    made = found.changed
    if made is None:
        return []
    items: list[Item] = []
    if made.sheet is not None:
        with suppress(UserError):
            mesh = faceted(mesh_of(made.sheet))
            items.append(Shaded(mesh, color=body.color or "clay", opacity=SHEET_OPACITY))
    if len(made.lines):
        items.append(segments(made.points[made.lines], "accent", EDGE_WIDTH))
    return items


def wire_items(body: Body, found: Solved) -> list[Item]:
    """Return the lines in space where they bound no faces: there is still something to turn."""
    if found.answer is None or not len(found.graph.lines):
        return []
    places = body.placement.points(found.answer.vertices)
    return [segments(places[found.graph.lines], "ink", EDGE_WIDTH)]


def measure_item(measure: Measure, ends: Array) -> Label:
    """Return a dimension beside the middle of its edge."""
    x, y, z = (float(value) for value in ends.mean(axis=0))
    return Label((x, y, z), f"{measure.length:.6g} mm", color="accent", size=13.0)


def round_size_item(size: RoundSize, points: Array) -> Label:
    """Return the diameter, and the depth where there is one, in the middle of a rim or an arc."""
    x, y, z = (float(value) for value in points.mean(axis=0))
    words = [f"diameter {size.diameter:.6g} mm"] if size.diameter else []
    if isinstance(size, RimSize) and size.depth:
        words.append(f"depth {size.depth:.6g} mm")
    return Label((x, y, z), ", ".join(words) or "as drawn", color="accent", size=13.0)


def page_items(curves: Sequence[Curve]) -> list[Item]:
    """Return the faces laid flat as they will be written."""
    return [
        Lines(
            curve.control_points.astype(np.float32),
            color="ghost" if curve.name.endswith("folds") else "ink",
            width=1.2,
        )
        for curve in curves
    ]


def faceted(mesh: Mesh) -> Mesh:
    """Return a mesh whose triangles share no vertices, so that every face is flat."""
    corners = mesh.vertices[mesh.faces].astype(float)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    faces = np.arange(3 * len(corners), dtype=np.int32).reshape(-1, 3)
    vertices = corners.reshape(-1, 3).astype(np.float32)
    return Mesh(vertices, faces, np.repeat(normals, 3, axis=0).astype(np.float32))
