"""Strokes drawn over a curve bend it, in any view.

Kara & Shimada, book chapter, section 13.2.2: the image of the curve is an active contour that the
strokes pull, and its new course goes back to space with the least change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import (
    Stroke,
    arc_length,
    contour_nodes,
    lift_curve,
    oversketch_curve,
)
from bozzetto.view import Camera
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.curve_meant import CurveMeant, curve_meant
from bozzetto_product.operations.displacement import displaced
from bozzetto_product.operations.meetings import curve_of, joint_at
from bozzetto_product.operations.mirrored_changes import changed_on_both_sides
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.planes import in_plane, mirror_image, mirrored_plane
from bozzetto_product.projection.views import pixel_size, seen_at

SPACING: Final = 2.0
"""Distance of the contour's nodes along the image, px: about the finest detail of a hand."""

BLEND: Final = 40.0
"""Least length, px, from an end that is held over which the change fades; at least twice the
step by which the end would have moved."""

STEEPEST: Final = 20.0
"""How much farther a place may go in a plane than it seems to, before the view says too little
about it."""

_NOTHING = "There is no curve near the strokes. Draw over the curve that is to change."
_EDGE_ON = (
    "Where the stroke leads, the plane of the curve is seen edge-on. Turn the view, then draw over "
    "the curve."
)


def modify(
    state: ProductState,
    strokes: Sequence[Stroke],
    *,
    meant: CurveMeant | None = None,
) -> ProductState:
    """Bend a curve towards the strokes drawn over it.

    Ends that are joined stay, and what is joined to the inside of the curve follows. Strokes over
    the mirror image change the one curve; of a curve that is its own mirror image the other half
    changes as well.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    strokes : sequence of Stroke
        Drawn in one view.
    meant : CurveMeant, optional
        The curve; default the one that is nearest on the sheet.

    Returns
    -------
    ProductState
        The same object where the strokes follow the curve as it is.

    Raises
    ------
    UserError
        If there is no curve near the strokes, it is not seen, or its plane is seen edge-on.
    """
    found = meant or curve_meant(state, strokes)
    if found is None or not strokes:
        raise UserError(_NOTHING)
    curve = curve_of(state, found.curve)
    assert curve.spline is not None
    mirror = state.symmetry if found.mirrored else None
    held = (
        joint_at(state, curve.id, 0.0) is not None,
        joint_at(state, curve.id, 1.0) is not None,
    )
    spline = drawn_over(curve.spline, strokes, held=held, plane=curve.plane, mirror=mirror)
    if spline is curve.spline:
        return state
    spline = changed_on_both_sides(curve.spline, spline, state.symmetry)
    node = replace(curve, strokes=curve.strokes.extended(strokes), told=())
    return settled_state(state.with_node(node), {curve.id: spline})


def drawn_over(
    spline: Spline,
    strokes: Sequence[Stroke],
    *,
    held: tuple[bool, bool] = (False, False),
    plane: Plane | None = None,
    mirror: Plane | None = None,
) -> Spline:
    """Return a curve after strokes drawn over it.

    Parameters
    ----------
    spline : Spline
        mm.
    strokes : sequence of Stroke
        Drawn in one view.
    held : (bool, bool)
        Whether its start and its end stay.
    plane : Plane, optional
        In which the curve stays; else it changes least.
    mirror : Plane, optional
        The strokes were drawn over the mirror image in this plane.

    Returns
    -------
    Spline
        The same object where nothing changes.

    Raises
    ------
    UserError
        If the curve is not seen, or its plane is seen edge-on.
    """
    camera = strokes[0].camera
    at, points, whole = image_nodes(spline, camera, mirror)
    pixels = seen_at(camera, points)
    new = oversketch_curve(
        pixels,
        [(stroke.points, stroke.pressure) for stroke in strokes],
        closed=whole,
    )
    wanted, moved = new.points, new.moved
    if not spline.closed:
        at_ends = at[0] == spline.range[0], at[-1] == spline.range[1]
        keep = held[0] or not at_ends[0], held[1] or not at_ends[1]
        wanted, moved = _with_ends_held(pixels, wanted, moved, keep)
    if not moved.any():
        return spline
    seen_plane = plane if plane is None or mirror is None else mirrored_plane(plane, mirror)
    goal = _lifted(points, pixels, wanted, camera, seen_plane)
    shifts = np.where(moved[:, None], goal - points, 0.0)
    if mirror is not None:
        shifts = mirror_image(points + shifts, mirror) - mirror_image(points, mirror)
        shifts[~moved] = 0.0
    made = displaced(spline, at, shifts, pixel_size(camera, points))
    if plane is None or made is spline:
        return made
    flat = in_plane(made.control_points, plane)
    if not spline.closed:
        for end, stays in ((0, held[0]), (-1, held[1])):
            flat[end] = spline.control_points[end] if stays else flat[end]
    return Spline(made.knots, flat, made.closed)


def image_nodes(spline: Spline, camera: Camera, mirror: Plane | None) -> tuple[Array, Array, bool]:
    """Return places at equal steps along the image: parameters, points, whether they close."""

    def image(points: Array) -> Array:
        return points if mirror is None else mirror_image(points, mirror)

    at, whole = contour_nodes(spline, lambda points: seen_at(camera, image(points)), SPACING)
    return at, image(spline.value(at)), whole


def _with_ends_held(
    pixels: Array, wanted: Array, moved: Flags, held: tuple[bool, bool]
) -> tuple[Array, Flags]:
    """Return the new image with ends that stay: what moved them fades towards them."""
    shift = wanted - pixels
    along = arc_length(pixels)
    taken = np.zeros_like(shift)
    for end, stays, away in ((0, held[0], along), (-1, held[1], along[-1] - along)):
        if stays and moved[end]:
            step = float(np.linalg.norm(shift[end]))
            share = np.clip(1.0 - away / max(BLEND, 2.0 * step), 0.0, 1.0)
            taken += (share**2 * (3.0 - 2.0 * share))[:, None] * shift[end]
            moved = moved.copy()
            moved[end] = False
    return wanted - taken, moved


def _lifted(
    points: Array, pixels: Array, wanted: Array, camera: Camera, plane: Plane | None
) -> Array:
    """Return where the nodes go in space: with the least change, or in their plane."""
    if plane is None:
        return lift_curve(points, camera, wanted)
    goal = camera.on_plane(wanted, plane.point, plane.normal)
    if not np.isfinite(goal).all():
        raise UserError(_EDGE_ON)
    way = np.linalg.norm(goal - points, axis=1) / pixel_size(camera, points)
    if (way > STEEPEST * np.linalg.norm(wanted - pixels, axis=1) + 1.0).any():
        raise UserError(_EDGE_ON)
    return goal
