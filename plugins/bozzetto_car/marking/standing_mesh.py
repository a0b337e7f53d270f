"""Stand the mesh of a car where templates stand, and take the points that its file names.

The world of a car is x rearward from the nose, y to the right, z up from the ground, mm. A mesh is
turned so that it lies along x on its wheels, whatever axes its file has; its plane of symmetry
halves its width, its lowest place is the ground and its foremost one the nose. Which of its ends
that is, the marks of the wheels tell.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Shapes, closest_on_mesh, meshed
from bozzetto_car.marking.points_on_mesh import on_its_wheels, with_point
from bozzetto_car.state import CarMesh
from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template

MOST_TRIANGLES: Final = 1_000_000
"""Most triangles of the mesh of a car: it is part of the document."""

SAMPLED: Final = 500
"""Places of a mesh by which its symmetry is judged."""

END: Final = 0.25
"""Share of the height of a car, at either end, in which its width is compared."""

LENGTHS: Final = (1500.0, 12000.0)
"""Least and greatest length of a car, mm: what is beyond was read in another unit."""


def standing_mesh(shapes: Shapes, part_id: str, name: str) -> CarMesh:
    """Return the mesh of a car, standing as a template does.

    Parameters
    ----------
    shapes : Shapes
        In mm. Parts that are called like nodes of the bundled templates (``C1``, ``WF``;
        of a pair ``S1`` or ``S1.R``) mark these with their middle and are no part of the car.
    part_id, name : str
        Of the part of the car's state that it becomes.

    Raises
    ------
    UserError
        If there are no faces or too many, or its size is not that of a car.
    """
    parts = list(meshed(shapes).meshes())
    known = _templates_by_node()
    named = [part for part in parts if part.name.partition(".")[0] in known]
    body = [part.mesh for part in parts if part not in named and len(part.mesh.faces)]
    if not body:
        raise UserError("This holds no faces, so no car's mesh. Choose a mesh of a body.")
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in body[:-1])])
    vertices = np.concatenate([mesh.vertices for mesh in body]).astype(float)
    faces = np.concatenate([m.faces + start for m, start in zip(body, starts, strict=True)])
    if len(faces) > MOST_TRIANGLES:
        raise UserError(
            f"This mesh has {len(faces):,} triangles, more than the {MOST_TRIANGLES:,} that a car "
            "can have. Make it simpler first."
        )
    used = vertices[np.unique(faces)]
    turn = _upright(Mesh((vertices - used.mean(axis=0)).astype(np.float32), faces.astype(np.int32)))
    turned = used @ turn.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    length = float(high[0] - low[0])
    if not LENGTHS[0] <= length <= LENGTHS[1]:
        raise UserError(
            f"This mesh is {length:.4g} mm long, and so no car. Import it in its own unit first."
        )
    origin = np.array([low[0], 0.5 * (low[1] + high[1]), low[2]])

    def standing(places: Array) -> Array:
        return np.asarray(places @ turn.T - origin)

    mesh = Mesh(standing(vertices).astype(np.float32), faces.astype(np.int32))
    made = CarMesh(id=part_id, name=name, mesh=mesh)
    for part in named:
        node = part.name.partition(".")[0]
        made = with_point(made, known[node], node, standing(part.mesh.bounds.mean(axis=0)))
    return on_its_wheels(made, bundled(TEMPLATES[0]))


def _upright(mesh: Mesh) -> Array:
    """Return the turn (3, 3) that stands the mesh of a car along x on its wheels.

    A car is longest along its length. Of the two other axes it is symmetric along its width, and
    along its height it gets narrower from the middle upward.
    """
    used = mesh.vertices[np.unique(mesh.faces)].astype(float)
    sizes = np.ptp(used, axis=0)
    length = int(np.argmax(sizes))
    others = [axis for axis in range(3) if axis != length]
    some = used[:: max(1, len(used) // SAMPLED)]
    uneven = []
    for axis in others:
        image = some.copy()
        image[:, axis] = used[:, axis].min() + used[:, axis].max() - some[:, axis]
        uneven.append(closest_on_mesh(mesh, image).distances.mean() / sizes[axis])
    across, height = others if uneven[0] <= uneven[1] else others[::-1]
    share = (used[:, height] - used[:, height].min()) / sizes[height]
    wide = np.abs(used[:, across] - 0.5 * (used[:, across].min() + used[:, across].max()))
    ends = (wide[share > 1.0 - END].max(), wide[share < END].max())
    turn = np.zeros((3, 3))
    turn[0, length] = 1.0
    turn[2, height] = 1.0 if ends[0] <= ends[1] else -1.0
    turn[1] = np.cross(turn[2], turn[0])
    return turn


def _templates_by_node() -> dict[str, Template]:
    """Return a bundled template that has a node, by its name without a side."""
    found: dict[str, Template] = {}
    for template in map(bundled, TEMPLATES):
        for node in template.names:
            found.setdefault(node.partition(".")[0], template)
    return found
