"""Reflection: what is drawn is drawn on the other side of the plane of symmetry, too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Mesh, Placement, closest_on_mesh
from bozzetto.plugin import Context
from bozzetto.scene import Item, Layer, Lines, Scene, Shaded
from bozzetto_silhouette.model.sketch_plane import Sheet
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of, points_on_sheet, surrounds
from bozzetto_silhouette.solids.part_solid import body_of
from bozzetto_silhouette.solids.placements import carried, outlined_parts, stroke_in
from bozzetto_silhouette.tools.arrange import after_motion
from bozzetto_silhouette.tools.insert_node import NOTHING, volume_left
from bozzetto_silhouette.view.drag_motion import mirrored
from bozzetto_silhouette.view.picking import TOUCHED_CELLS

UP = (0.0, 0.0, 1.0)
"""The world's."""

SAME = 0.02
"""Distance of a mirror image from the surface of its part below which they are one, as a share of
the part's size: a hand that draws over the middle comes as near."""

FLAT = 1e-6
"""Sine of an angle, and share of a length, below which a sheet lies in a plane."""


def reflections(context: Context) -> list[Placement]:
    """Return the reflection in the plane of symmetry, and in the upright plane that crosses it."""
    point, normal = np.asarray(context.symmetry_point), np.asarray(context.symmetry_normal)
    across = np.cross(normal, UP)
    planes = [normal, across] if np.linalg.norm(across) > 0.0 else [normal]
    return [mirrored(point, plane) for plane in planes]


def reflection_of(sheet: Sheet, context: Context) -> Placement:
    """Return the reflection for what is drawn on a sheet.

    It is the plane of symmetry's; a sheet in that plane has its left and its right.
    """
    every = reflections(context)
    normal = np.asarray(context.symmetry_normal) / np.linalg.norm(context.symmetry_normal)
    away = np.subtract(sheet.origin, context.symmetry_point)
    parallel = np.linalg.norm(np.cross(normal, sheet.normal)) < FLAT
    lies_in = parallel and abs(away @ normal) <= FLAT * (1.0 + np.linalg.norm(away))
    return every[-1] if lies_in else every[0]


def twin_of(state: SilhouetteState, part: Part, image: Placement) -> Part | None:
    """Return the mirror image of a part; None where the part is its own."""
    twin = _image_of(state, part, image)
    return None if _is_alike(part, twin) else twin


def _image_of(state: SilhouetteState, part: Part, image: Placement) -> Part:
    """Return the mirror image of a part as a part of its own."""
    name = f"{part.name} mirrored"
    taken = any(node.name == name for node in state.nodes)
    return replace(
        after_motion(state, part, image),
        id=state.unused_id(),
        name=state.unused_name(name) if taken else name,
    )


def with_twin(state: SilhouetteState, part: Part, twin: Part) -> SilhouetteState:
    """Add a twin right after its part."""
    place = next(k for k, node in enumerate(state.nodes) if node.id == part.id) + 1
    return replace(state, nodes=(*state.nodes[:place], twin, *state.nodes[place:]))


def reflected(
    before: SilhouetteState, after: SilhouetteState, new: Part, context: Context
) -> SilhouetteState:
    """Draw the mirror image of what was just drawn.

    Parameters
    ----------
    before, after : SilhouetteState
        Without it, and with it: a part of its own, or a hole in one.
    new : Part
        What was drawn, as a part.
    context : Context
        With the plane of symmetry.
    """
    image = reflection_of(new.sheet, context)
    part = next((part for part in after.parts if part.id == new.id), None)
    if part is not None:
        twin = twin_of(after, part, image)
        return after if twin is None else with_twin(after, part, twin)
    if len(after.nodes) < len(before.nodes):  # drawn around several, which have no images
        return after
    strokes = tuple(stroke.moved(image) for stroke in new.strokes)
    for old in outlined_parts(after):
        if np.linalg.norm(np.cross(carried(after, old).directions(old.sheet.normal)[0],
                                   image.directions(new.sheet.normal)[0])) > FLAT:  # fmt: skip
            continue
        hole = tuple(stroke_in(after, old, stroke) for stroke in strokes)
        whole = replace(old, strokes=old.strokes.extended(hole))
        try:
            inside = np.concatenate(points_on_sheet(hole, old.sheet))
            if surrounds(outline_of(old), inside):
                outline_of(whole)
                return after.with_node(whole)
        except UserError:  # it meets its own image: one hole across the plane
            continue
    return after


def with_reflected_tool(
    before: SilhouetteState, after: SilhouetteState, tool: str, sheet: Sheet, context: Context
) -> SilhouetteState:
    """Carve on the other side of the plane, too, where that takes anything away.

    Parameters
    ----------
    before, after : SilhouetteState
        Without the tool, and with it.
    tool : str
        Its id.
    sheet : Sheet
        What it was drawn on.
    context : Context
        With the plane of symmetry.
    """
    part = next(part for part in after.parts if part.id == tool)
    both = with_twin(after, part, _image_of(after, part, reflection_of(sheet, context)))
    whole, once, twice = (volume_left(state) for state in (before, after, both))
    # Its own image takes away next to nothing more.
    tells = once - twice > SAME * (whole - once) and twice > NOTHING * whole
    return both if tells else after


def reflected_scene(scene: Scene, image: Placement) -> Scene:
    """Return a scene of shaded shapes and lines with its mirror image."""
    layers = []
    for layer in scene.layers:
        twins: list[Item] = []
        for item in layer.items:
            if isinstance(item, Shaded):
                twins.append(replace(item.placed(image), pickable=False))
            elif isinstance(item, Lines) and len(item.points):
                places = image.points(item.points.astype(np.float64)).astype(np.float32)
                twins.append(replace(item, points=places))
        layers.append(Layer(layer.name, (*layer.items, *twins)))
    return Scene(tuple(layers))


def _is_alike(part: Part, twin: Part) -> bool:
    """Whether two parts of one group take up the same space."""
    one, other = (body_of(node, TOUCHED_CELLS) for node in (part, twin))
    gap = closest_on_mesh(
        Mesh(one.vertices.astype(np.float32), one.faces), other.vertices
    ).distances
    return bool(gap.max() < SAME * np.ptp(one.vertices, axis=0).max())
