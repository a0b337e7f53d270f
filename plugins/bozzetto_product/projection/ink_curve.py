"""Curves in space from ink: on what is seen under it, or on a plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import Stroke, distances_to_polyline, spline_weights
from bozzetto.plugin import Context
from bozzetto.scene import Scene, cast_rays, project_stroke
from bozzetto.view import Camera
from bozzetto_product.model.planes import Plane, Point
from bozzetto_product.projection.depth_fit import SAMPLES, at_depth, look_along
from bozzetto_product.projection.planes import canvas_plane, heights, in_plane
from bozzetto_product.projection.sheet_curve import FAR, SheetCurve, curve_on_sheet
from bozzetto_product.projection.spline_basis import bent, chord_length, with_controls
from bozzetto_product.projection.views import pixel_size, seen_at

AT_PLANE: Final = 6.0
"""Distance of an end from the mirror plane, px, within which it is meant to lie in it."""

DEEPER: Final = 3.0
"""Distance of such an end from the plane in space, in lengths of that on the sheet, up to which it
is near it in space, too."""

OUTLINE: Final = 12.0
"""Distance from the outline of a surface, px, up to which the depth of an end is uncertain."""

LOOKS: Final = 16
"""Places around an end at which the outline is looked for."""

STEEPEST: Final = 20.0
"""How much farther a place may go in a plane than it seems to on the sheet: the plane is seen
within three degrees of its edge then."""

_BESIDE = (
    "The curve is beside every surface. It was drawn on a plane that faces the view; turn the view "
    "and draw over it to give it depth."
)
_RUNS_OFF = "The curve runs off the surface. It goes on there as smoothly as its course allows."
_APART = (
    "A part of the curve is over another surface far behind or before the first. It goes on at the "
    "depth of the first; draw it in two curves to have it on both."
)
_CREASE = (
    "The curve goes over an edge of the surface, and is rounded there. Split it at the edge if a "
    "corner is meant."
)
_FAR = "The ink is up to {:.0f} px beside its curve. More control points follow it."
_UNSURE = (
    "The strokes do not make one clear curve. Undo and draw it again if it is not what you mean."
)


@dataclass(frozen=True, eq=False)
class DrawnCurve:
    """A curve in space that was drawn.

    Attributes
    ----------
    spline : Spline
        mm, over 0 … 1.
    warnings : tuple of str
        What a person should know of it.
    creases : tuple of float
        Shares of its range at which the surface has an edge.
    image_error : float
        Largest distance, px, of its image from the curve on the sheet.
    ink_error : float
        Largest distance, px, of the ordered ink from the curve on the sheet.
    """

    spline: Spline
    warnings: tuple[str, ...] = ()
    creases: tuple[float, ...] = ()
    image_error: float = 0.0
    ink_error: float = 0.0


def curve_from_ink(
    strokes: Sequence[Stroke],
    seen: Context | Scene,
    *,
    controls: int = 7,
    order: Literal["drawn", "principal"] = "drawn",
    plane: Plane | None = None,
    mirror_plane: Plane | None = None,
    anchor: Point | None = None,
) -> DrawnCurve:
    """Make a curve in space of strokes that draw one curve.

    Kara & Shimada, book chapter, section 13.2.1: the strokes become one B-spline on the sheet, and
    that is put on what is seen under it, so that its image is the ink.

    Parameters
    ----------
    strokes : sequence of Stroke
        Any number, in any order and direction, drawn in one view.
    seen : Context or Scene
        What is visible, in the frame of the model.
    controls : int
        Control points, at least 4 (5 of a closed curve).
    order : {"drawn", "principal"}
        How the ink is put in order.
    plane : Plane, optional
        The curve lies in it, whatever is under the ink.
    mirror_plane : Plane, optional
        Ends that are seen within 6 px of it lie in it, unless the surface there faces the view and
        is far before it.
    anchor : (x, y, z), optional
        Where the last curve was, mm: what is drawn beside every surface has its depth. Default the
        middle of what is seen.

    Returns
    -------
    DrawnCurve

    Raises
    ------
    UserError
        If the strokes make no curve, or the plane is seen edge-on.
    """
    scene = seen.scene if isinstance(seen, Context) else seen
    sheet = curve_on_sheet(strokes, controls=controls, order=order)
    if plane is not None:
        drawn = DrawnCurve(_on_plane(sheet, plane))
    else:
        drawn = _on_surface(sheet, scene, anchor)
    spline = drawn.spline
    if mirror_plane is not None and not spline.closed:
        spline = _ends_at(spline, mirror_plane, sheet.camera, scene)
        if plane is not None:
            spline = with_controls(spline, in_plane(spline.control_points, plane))
    warnings = drawn.warnings if sheet.sure else (*drawn.warnings, _UNSURE)
    if sheet.worst > FAR:
        warnings = (*warnings, _FAR.format(sheet.worst))
    return replace(
        drawn,
        spline=spline,
        warnings=warnings,
        image_error=image_distance(spline, sheet),
        ink_error=sheet.worst,
    )


def image_distance(spline: Spline, sheet: SheetCurve) -> float:
    """Return the largest distance between the image of a curve and the curve on the sheet, px."""
    image = seen_at(sheet.camera, spline.sampled(2 * SAMPLES))
    if not np.isfinite(image).all():
        return float("inf")
    wanted = sheet.spline.sampled(2 * SAMPLES)
    there = distances_to_polyline(image, wanted)
    back = distances_to_polyline(wanted, image)
    return float(max(there.max(), back.max()))


def _on_surface(sheet: SheetCurve, scene: Scene, anchor: Point | None) -> DrawnCurve:
    sight = look_along(sheet.spline, sheet.camera, scene)
    if not sight.on.any():
        plane = canvas_plane(_anchor(scene, sheet.camera, anchor), sheet.camera.axes[2])
        return DrawnCurve(_on_plane(sheet, plane), warnings=(_BESIDE,))
    spline = at_depth(sheet.spline, sheet.camera, sight)
    creases = creases_along(sheet.spline.sampled(SAMPLES), sheet.camera, scene)
    said = (
        (_APART, sight.apart),
        (_RUNS_OFF, not sight.on.all() and not sight.apart),
        (_CREASE, bool(creases)),
    )
    warnings = tuple(text for text, holds in said if holds)
    return DrawnCurve(spline, warnings, creases)


def _anchor(scene: Scene, camera: Camera, anchor: Point | None) -> Array:
    """Return a place before the eye whose depth is taken where there is no surface."""
    bounds = scene.bounds()
    choices = [] if anchor is None else [np.asarray(anchor, float)]
    choices.append(bounds.mean(axis=0))
    for place in choices:
        before = float((place - camera.eye) @ camera.axes[2])
        if np.isfinite(before) and (camera.kind == "orthographic" or before > 0.0):
            return place
    return np.asarray(camera.target, float)


def creases_along(points: Array, camera: Camera, scene: Scene) -> tuple[float, ...]:
    """Return the shares of a curve at which the surface under it has an edge.

    Parameters
    ----------
    points : (n, 2) float
        Its places on the sheet at equal steps of its parameter, px.
    camera : Camera
        Of the view.
    scene : Scene
        What is visible.
    """
    ink = project_stroke(Stroke(points[:, 0], points[:, 1], camera), scene)
    at = np.concatenate([run.creases for run in ink.runs]) if ink.runs else np.zeros(0)
    return tuple(float(share) for share in np.unique(at / (len(points) - 1)))


def _on_plane(sheet: SheetCurve, plane: Plane) -> Spline:
    """Return the curve of a plane that is seen where the ink is."""
    camera = sheet.camera
    at = np.linspace(*sheet.spline.range, SAMPLES)
    pixels = sheet.spline.value(at)
    points = camera.on_plane(pixels, plane.point, plane.normal)
    if not np.isfinite(points).all() or _is_edge_on(points, pixels, camera):
        raise UserError("The plane is seen edge-on from here. Turn the view, then draw the curve.")
    rows = spline_weights(sheet.spline, at)
    middle = points.mean(axis=0)
    controls = np.linalg.lstsq(rows, points - middle, rcond=None)[0] + middle
    if not sheet.spline.closed:
        controls[[0, -1]] = points[[0, -1]]
    curve = with_controls(sheet.spline, controls)
    for _ in range(3):
        feet = curve.foot_points(points, at)
        if not curve.closed:
            feet[[0, -1]] = curve.range
        controls = (
            np.linalg.lstsq(spline_weights(curve, feet), points - middle, rcond=None)[0] + middle
        )
        curve = with_controls(curve, controls)
    flat = in_plane(curve.control_points, plane)
    return Spline(curve.knots, flat, curve.closed)


def _is_edge_on(points: Array, pixels: Array, camera: Camera) -> bool:
    """Whether places go much farther in space than they seem to on the sheet."""
    way = np.linalg.norm(np.diff(points, axis=0), axis=1) / pixel_size(camera, points[1:])
    seen = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
    return bool(way.sum() > STEEPEST * max(float(seen.sum()), 1e-9))


def _ends_at(spline: Spline, plane: Plane, camera: Camera, scene: Scene) -> Spline:
    """Return the curve with ends in a plane that are seen near it.

    In a view along its normal all is seen near a plane: there the end must be near it in space,
    too, or at the outline of what it lies on, where depth is uncertain.
    """
    ends = spline.control_points[[0, -1]]
    flat = in_plane(ends, plane)
    seen = np.linalg.norm(seen_at(camera, ends) - seen_at(camera, flat), axis=1)
    size = np.abs(heights(ends, plane)) <= 0.5 * chord_length(spline)
    near = np.abs(heights(ends, plane)) <= DEEPER * AT_PLANE * pixel_size(camera, ends)
    for number in np.flatnonzero(~near & (seen <= AT_PLANE) & size):
        near[number] = _at_outline(seen_at(camera, ends[number : number + 1])[0], camera, scene)
    goal = np.where(((seen <= AT_PLANE) & size & near)[:, None], flat, ends)
    return bent(spline, goal[0], goal[1])


def _at_outline(pixel: Array, camera: Camera, scene: Scene) -> bool:
    """Whether what is seen at a place on the sheet ends beside it."""
    turn = 2.0 * np.pi * np.arange(LOOKS) / LOOKS
    around = pixel + OUTLINE * np.column_stack((np.cos(turn), np.sin(turn)))
    return not bool(cast_rays(scene, camera.rays(around)).hit.all())
