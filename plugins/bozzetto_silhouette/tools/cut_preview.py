"""Preview of a cut while its line is drawn: where it runs, and what falls away."""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array, Faces
from bozzetto.geometry import Mesh
from bozzetto.ink import resample
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto_silhouette.model.state import Cut
from bozzetto_silhouette.model.view_rays import view_rays_through
from bozzetto_silhouette.outline.cut_line import cut_side
from bozzetto_silhouette.outline.outline import Outline
from bozzetto_silhouette.solids.extrude import corners_of
from bozzetto_silhouette.tools.through_preview import trace_of
from bozzetto_silhouette.view.picking import Touch

LOOKS = 160
"""Lines of sight along the side's outline."""

TINT = 0.5
"""Opacity of the tint of what falls away."""

STANDOFF = 2e-3
"""Distance of the tint from the surface, as a share of the size."""


def cut_preview(cut: Cut, touch: Touch) -> Scene:
    """Show the line of a cut on a shape, carried on at its ends, and tint the smaller side.

    Parameters
    ----------
    cut : Cut
        In the model's frame.
    touch : Touch
        The shape.

    Raises
    ------
    UserError
        If there is no line yet, or it crosses itself.
    """
    place = cut.sheet.placement
    local = place.inverse().points(touch.body.vertices)
    side = cut_side(cut, corners_of(np.stack([local.min(axis=0), local.max(axis=0)])))
    camera = cut.strokes[0].camera
    ring = resample(side.rings[0], count=LOOKS, closed=True)
    pixels, _ = camera.project(cut.sheet.to_world(np.vstack([ring, ring[:1]])))
    line = trace_of(touch, pixels, camera).scene(through=False)
    faces = _falling(cut, touch, local, side)
    if not len(faces):
        return line
    used, corners = np.unique(faces, return_inverse=True)
    body = touch.body
    off = STANDOFF * float(np.ptp(body.bounds, axis=0).max())
    mesh = Mesh(
        (body.vertices[used] + off * body.normals[used]).astype(np.float32),
        corners.reshape(faces.shape).astype(np.int32),
        body.normals[used].astype(np.float32),
    )
    return line + Scene((Layer("preview", (Shaded(mesh, "accent", TINT, pickable=False),)),))


def _falling(cut: Cut, touch: Touch, local: Array, side: Outline) -> Faces:
    """Return the faces of a shape on the side of a cut that has less volume, (k, 3).

    Tetrahedra from a place on the cut add up to the volume of a side, as far as the cut is
    flat: its own face has none with that place.
    """
    import shapely

    view_rays = view_rays_through(cut.sheet, cut.strokes[0].camera)
    corners = local[touch.body.faces]
    middles = corners.mean(axis=1)
    low, high = view_rays.before_eye(float(middles[:, 2].min()), float(middles[:, 2].max()))
    seen = view_rays.drawn(np.column_stack([middles[:, :2], np.clip(middles[:, 2], low, high)]))
    polygon = side.polygon()
    shapely.prepare(polygon)
    inside = shapely.contains_xy(polygon, seen[:, 0], seen[:, 1])
    drawn = cut.sheet.from_pixels(cut.strokes[0].points, cut.strokes[0].camera)
    apex = np.append(drawn[len(drawn) // 2], 0.0)
    a, b, c = (corners - apex).transpose(1, 0, 2)
    volume = np.einsum("nd,nd->n", a, np.cross(b, c))
    falls = inside if volume[inside].sum() <= volume[~inside].sum() else ~inside
    return np.asarray(touch.body.faces[falls], np.int32)
