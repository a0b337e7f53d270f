"""Placements of the parts: moved since they were drawn, in groups that were moved too.

Everything the pen does to a part is done where the part stands now and kept where it was drawn:
strokes are carried back by `stroke_in`, outlines are carried out by `placement_of`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Placement
from bozzetto.ink import Stroke
from bozzetto.plugin import Part as AnyPart
from bozzetto.plugin import remembered
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto.view import Camera, Rays
from bozzetto_silhouette.model.state import Cut, Group, Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.solids.part_solid import body_of

PICKED_CELLS = 64
"""Resolution of the solids that the pen is held against: that of the preview, which has been
worked out before anybody can point at it."""


def groups_around(state: SilhouetteState, node: Part | Group) -> list[Group]:
    """Return the groups that a node is in, the innermost first."""
    groups = {other.id: other for other in state.nodes if isinstance(other, Group)}
    found: list[Group] = []
    within = node.within
    while within in groups:
        group = groups.pop(within)  # each once: a file may hold groups that go round in a ring
        found.append(group)
        within = group.within
    return found


def carried(state: SilhouetteState, node: Part | Group) -> Placement:
    """Return the motion of a node since it was drawn, groups included, in the model's frame."""
    moved = node.pose
    for group in groups_around(state, node):
        moved = group.pose.after(moved)
    return moved


def placement_of(state: SilhouetteState, part: Part) -> Placement:
    """Return the placement from a part's object frame to the model's frame."""
    return carried(state, part).after(part.sheet.placement)


def is_shown(state: SilhouetteState, node: Part | Group) -> bool:
    """Whether a node and all groups around it are switched on."""
    return any(other.id == node.id for other in state.shown(AnyPart))


def shown_parts(state: SilhouetteState) -> tuple[Part, ...]:
    """Return the parts that can be seen and touched, in the order of the tree."""
    return state.shown(Part)


def outlined_parts(state: SilhouetteState) -> tuple[Part, ...]:
    """Return the shown parts that have a closed outline; the line of a cut is open."""
    return tuple(part for part in shown_parts(state) if not isinstance(part, Cut))


def stroke_in(state: SilhouetteState, part: Part, stroke: Stroke) -> Stroke:
    """Carry a stroke drawn over a part as it stands now to where the part was drawn.

    Raises
    ------
    UserError
        If the camera would stand beyond all bounds there.
    """
    moved = carried(state, part)
    return stroke if moved.is_identity else stroke.moved(moved.inverse())


def on_sheet(state: SilhouetteState, part: Part, stroke: Stroke) -> Array:
    """Project a stroke drawn over a part as it stands now onto the part's sheet; (n, 2), mm.

    NaN where the line of sight misses the sheet.
    """
    there = stroke_in(state, part, stroke)
    return part.sheet.from_pixels(there.points, there.camera)


def drawn_rings(state: SilhouetteState, part: Part) -> list[Array]:
    """Return the rings of a part's outline where they stand now; (n, 3) each, mm, model's frame.

    Raises
    ------
    UserError
        If the part's ink is no outline.
    """
    place = placement_of(state, part)
    return [
        place.points(np.column_stack([ring, np.zeros(len(ring))]))
        for ring in outline_of(part).rings
    ]


def drawn_profile(state: SilhouetteState, part: Part) -> list[Array]:
    """Return a profile's strokes where its part stands now; (n, 3) each, mm, model's frame.

    They lie in the plane upright on the sheet, through the middle of the part, that the hand
    looked at; what was drawn out of sight of it is left out.

    Raises
    ------
    UserError
        If the part's ink is no outline.
    """
    middle = part.sheet.to_world(np.mean(outline_of(part).bounds, axis=0)[None])[0]
    normal, found = part.sheet.normal, []
    for stroke in part.profile:
        facing = stroke.camera.axes[2] - (stroke.camera.axes[2] @ normal) * normal
        if np.linalg.norm(facing) > 0.0:
            line = stroke.camera.on_plane(stroke.points, middle, facing)
            found.append(carried(state, part).points(line[np.isfinite(line).all(axis=1)]))
    return found


# Kept as they are, so that the tree of boxes in each is built once.
@remembered(limit=64, key=lambda part: part.recipe)
def _at_home(part: Part) -> Mesh:
    body = body_of(part, PICKED_CELLS)
    return Mesh(body.vertices.astype(np.float32), body.faces)


def distances_under(state: SilhouetteState, part: Part, pixels: ArrayLike, camera: Camera) -> Array:
    """Measure how far before the eye a part's surface lies under canvas positions.

    Parameters
    ----------
    state : SilhouetteState
        The parts as they stand now.
    part : Part
        The one that is looked at.
    pixels : (n, 2) array_like
        Canvas positions.
    camera : Camera
        What they are seen through.

    Returns
    -------
    (n,) float
        mm along the line of sight; inf beside the part, and for a part that has no surface.
    """
    rays = camera.rays(pixels)
    try:
        mesh = _at_home(replace(part, pose=Placement()))
    except UserError:
        return np.full(len(rays.origins), np.inf)
    back = carried(state, part).inverse()
    scene = Scene((Layer("part", (Shaded(mesh),)),))
    hits = cast_rays(scene, Rays(back.points(rays.origins), back.directions(rays.directions)))
    return hits.distance / back.scale
