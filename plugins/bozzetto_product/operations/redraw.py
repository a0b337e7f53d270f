"""A stretch of a curve drawn anew."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.ink import Stroke, arc_length, distances_to_polyline, lift_curve, points_along
from bozzetto.view import Camera
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.curve_meant import CurveMeant, curve_meant
from bozzetto_product.operations.displacement import displaced
from bozzetto_product.operations.meetings import curve_of, joint_at, spline_of
from bozzetto_product.operations.mirrored_changes import changed_on_both_sides
from bozzetto_product.operations.settling import settled_state
from bozzetto_product.projection.planes import in_plane, mirror_image, mirrored_plane
from bozzetto_product.projection.sheet_curve import curve_on_sheet
from bozzetto_product.projection.views import pixel_size, seen_at

LOOKS: Final = 1025
"""Places of the curve whose images are compared with the ink."""

SPACING: Final = 2.5
"""Distance of the places that are moved, along the image, px."""

BLEND: Final = 30.0
"""Least length, px, over which the ink leads back into the curve; at most a quarter of the ink."""

AT_END: Final = 0.01
"""Share of the curve from its end within which the ink takes the end along."""

CONTROLS: Final = 16
"""Control points of the stretch on the sheet: it may have any course."""

_NOTHING = "There is no curve near the strokes. Begin and end on the curve that is to change."


def redraw_stretch(
    state: ProductState, strokes: Sequence[Stroke], *, meant: CurveMeant | None = None
) -> ProductState:
    """Exchange the stretch of a curve between the ends of the ink for the ink.

    Where the ink begins and ends is where it leaves the curve. A free end near which the ink ends
    is taken along; joints stay. The new course changes least in space, or stays in the
    curve's plane. Of a curve that is its own mirror image the other half changes as well.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    strokes : sequence of Stroke
        Drawn in one view.
    meant : CurveMeant, optional
        The curve; default the one that is nearest on the sheet.

    Raises
    ------
    UserError
        If there is no curve near the strokes, or it is not seen where they are.
    """
    found = meant or curve_meant(state, strokes)
    if found is None or not strokes:
        raise UserError(_NOTHING)
    curve, spline = curve_of(state, found.curve), spline_of(state, found.curve)
    mirror = state.symmetry if found.mirrored else None
    sheet = curve_on_sheet(strokes, controls=CONTROLS)
    if sheet.spline.closed:
        raise UserError("A ring cannot take the place of a stretch. Draw from place to place.")
    ink = sheet.spline.sampled(LOOKS)
    held = (
        joint_at(state, curve.id, 0.0) is not None,
        joint_at(state, curve.id, 1.0) is not None,
    )
    at, pixels = _stretch(spline, ink, sheet.camera, mirror)
    if at[0] > at[-1]:
        at, pixels, ink = at[::-1], pixels[::-1], ink[::-1]
    wanted = _led_in(at, pixels, ink, spline, held)
    points = spline.value(at)
    seen = points if mirror is None else mirror_image(points, mirror)
    goal = _lifted(seen, wanted, sheet.camera, curve.plane, mirror)
    if mirror is not None:
        goal = mirror_image(goal, mirror)
    shifts = goal - points
    for end, stays in ((0, _is_inside(at[0], spline) or held[0]),
                       (-1, _is_inside(at[-1], spline) or held[1])):  # fmt: skip
        if stays:
            shifts[end] = 0.0
    made = _placed(spline, at, shifts, sheet.camera)
    if curve.plane is not None:
        flat = in_plane(made.control_points, curve.plane)
        for end, stays in ((0, held[0]), (-1, held[1])):
            flat[end] = spline.control_points[end] if stays else flat[end]
        made = Spline(made.knots, flat, made.closed)
    made = changed_on_both_sides(spline, made, state.symmetry)
    node = replace(curve, strokes=curve.strokes.extended(strokes), told=())
    return settled_state(state.with_node(node), {curve.id: made})


def _stretch(
    spline: Spline, ink: Array, camera: Camera, mirror: Plane | None
) -> tuple[Array, Array]:
    """Return parameters and image of the stretch between the ends of the ink, from its first."""
    dense = np.linspace(*spline.range, LOOKS)
    points = spline.value(dense)
    image = seen_at(camera, points if mirror is None else mirror_image(points, mirror))
    if not np.isfinite(image).any():
        raise UserError("The curve is not seen from here. Turn the view, then draw over it.")
    away = [np.nan_to_num(np.linalg.norm(image - end, axis=1), nan=np.inf) for end in ink[[0, -1]]]
    first, last = (int(np.argmin(one)) for one in away)
    if first == last:
        raise UserError("The strokes begin and end at one place of the curve. Draw a longer one.")
    ways = [np.arange(first, last + 1) if first < last else np.arange(first, last - 1, -1)]
    if spline.closed:
        other = LOOKS - 1 - len(ways[0]) + 2
        step = -1 if first < last else 1
        ways.append((first + step * np.arange(other)) % (LOOKS - 1))
    best = min(ways, key=lambda way: float(_apart(image[way], ink)))
    if not np.isfinite(image[best]).all():
        raise UserError("The curve is not seen where the strokes are. Turn the view.")
    at = (
        np.unwrap(dense[best], period=spline.range[1] - spline.range[0])
        if spline.closed
        else dense[best]
    )
    along = arc_length(image[best])
    count = int(np.clip(max(along[-1], arc_length(ink)[-1]) / SPACING, 16, 1200))
    stations = np.linspace(0.0, along[-1], count)
    return np.interp(stations, along, at), points_along(image[best], along, stations)


def _apart(path: Array, ink: Array) -> float:
    """Return the mean distance between two paths, px."""
    there, back = distances_to_polyline(ink, path), distances_to_polyline(path, ink)
    return float(there.mean() + back.mean()) if np.isfinite(path).all() else np.inf


def _led_in(at: Array, pixels: Array, ink: Array, spline: Spline, held: tuple[bool, bool]) -> Array:
    """Return where the places of the stretch are to be seen: along the ink, led into the curve."""
    along = arc_length(ink)
    way = points_along(ink, along, np.linspace(0.0, along[-1], len(at)))
    gone = arc_length(way)
    blend = max(1e-9, min(BLEND, 0.25 * float(gone[-1])))
    for end, away, stays in ((0, gone, held[0]), (-1, gone[-1] - gone, held[1])):
        if stays or _is_inside(at[end], spline):
            share = np.clip(1.0 - away / blend, 0.0, 1.0)
            fade = share**2 * (3.0 - 2.0 * share)
            way = way + fade[:, None] * (pixels[end] - way[end])
    return way


def _is_inside(at: float, spline: Spline) -> bool:
    """Whether a parameter is inside the curve, and not near an end of it."""
    begin, end = spline.range
    share = (at - begin) / (end - begin)
    return bool(spline.closed or AT_END < share < 1.0 - AT_END)


def _lifted(
    points: Array, wanted: Array, camera: Camera, plane: Plane | None, mirror: Plane | None
) -> Array:
    """Return where the places go in space."""
    if plane is None:
        return lift_curve(points, camera, wanted)
    flat = plane if mirror is None else mirrored_plane(plane, mirror)
    goal = camera.on_plane(wanted, flat.point, flat.normal)
    if not np.isfinite(goal).all():
        raise UserError("The plane of the curve is seen edge-on from here. Turn the view.")
    return goal


def _placed(spline: Spline, at: Array, shifts: Array, camera: Camera) -> Spline:
    """Return the curve with a stretch displaced, and the rest where it was."""
    begin, end = spline.range
    step = float(np.abs(np.diff(at)).mean())
    low, high = float(at[0]), float(at[-1])
    stop = low + (end - begin) if spline.closed else end
    start = high if spline.closed else begin
    rest = [np.arange(high + step, stop - 0.5 * step, step)]
    if not spline.closed:
        rest.append(np.arange(start, low - 0.5 * step, step))
        rest.append(np.array([end] if high < end else []))
    still = np.concatenate(rest)
    every = np.concatenate((at, still))
    moves = np.vstack((shifts, np.zeros((len(still), 3))))
    order = np.argsort(every, kind="stable")
    places = spline.value(every[order])
    return displaced(spline, every[order], moves[order], pixel_size(camera, places))
