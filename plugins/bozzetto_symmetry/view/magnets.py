"""Magnets: what the pen is caught by, as it is shown on the sheet while a curve is drawn."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.ink import Stroke
from bozzetto.scene import Item, Layer, Lines, Points
from bozzetto.view import Camera, triple
from bozzetto_symmetry.model.axes import AXES, AXIS_PAINTS
from bozzetto_symmetry.model.perspective import pixel_size, toward_vanishing
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.drawn_snaps import axis_drawn
from bozzetto_symmetry.operations.snap_candidates import SMOOTH, plane_near
from bozzetto_symmetry.operations.snap_targets import Place, Targets, nearest_target

POINT_SIZE, SEGMENT_SIZE, OPACITY = 13.0, 9.0, 0.6
"""Size of a magnet at a single place, and on a curve or edge, px, and its opacity."""

REACH: Final = 2.0
"""How near to a single place the pen must be, in its tolerances; to curves and edges it is one."""

GUIDE_WIDTH, GUIDE_OPACITY, BEYOND = 1.2, 0.7, 0.35
"""Width, px, and opacity of the line along an axis, and how far it goes on beyond a stroke, as a
share of that."""

LEAVING: Final = 16.0
"""Length of a stroke from its end, px, that tells the direction in which it leaves it."""

TANGENT: Final = 3.0
"""Half the length of the line along a known direction, in such lengths."""


def caught_by(pixel: Array, camera: Camera, known: Targets, tolerance: float) -> Place | None:
    """Return the known place that the pen is caught by at a place on the sheet."""
    place = nearest_target(pixel, camera, known, REACH * tolerance)
    if place is None or place.kind in ("end", "crossing", "corner") or place.pixels <= tolerance:
        return place
    return None


def on_plane(place: Array, camera: Camera, state: SymmetryState) -> Place | None:
    """Return the place on a face of the box or the centre plane that holds an end of a curve.

    Parameters
    ----------
    place : (3,) float
        The end, as far as it is drawn, in the model's frame, mm.
    camera : Camera
        Through which it is drawn, in the model's frame.
    state : SymmetryState
        Its box and plane.
    """
    point = plane_near(place, camera, state)
    if point is None:
        return None
    away = camera.project(np.stack((place, point)))[0]
    return Place(triple(point), "edge", float(np.linalg.norm(away[1] - away[0])))


def magnet_layer(places: Iterable[Place | None]) -> tuple[Layer, ...]:
    """Return marks at the places that hold the pen; nothing where none does."""
    found = [place for place in places if place is not None]
    if not found:
        return ()
    single = [place.kind in ("end", "crossing", "corner") for place in found]
    sizes = np.where(single, POINT_SIZE, SEGMENT_SIZE).astype(np.float32)
    points = np.array([place.point for place in found], np.float32)
    dots = tuple(
        Points(points[k : k + 1], color="accent", size=float(sizes[k]), opacity=OPACITY)
        for k in range(len(found))
    )
    return (Layer("magnets", dots),)


def tangent_layer(stroke: Stroke, known: Targets, tolerance: float) -> tuple[Layer, ...]:
    """Return a line at each end of a stroke that goes on smoothly from a known end; else nothing.

    The curve takes that direction when the pen is lifted (`snap_candidates.snap_of`).

    Parameters
    ----------
    stroke : Stroke
        So far, px.
    known : Targets
        With the directions in which curves go on at their ends, mm.
    tolerance : float
        Of the pen, px.
    """
    has = np.flatnonzero(known.tangents.any(axis=1))
    if not len(has) or len(stroke.points) < 2:
        return ()
    camera = stroke.camera
    seen = camera.project(known.points[has])[0]
    items = []
    for order in (1, -1):
        path = stroke.points[::order]
        away = np.linalg.norm(seen - path[0], axis=1)
        near = int(np.argmin(np.where(np.isfinite(away), away, np.inf)))
        if not away[near] <= REACH * tolerance:
            continue
        begun = np.flatnonzero(np.linalg.norm(path - path[0], axis=1) >= LEAVING)
        if not len(begun):
            continue
        place, way = known.points[has[near]], known.tangents[has[near]]
        step = LEAVING * float(pixel_size(camera, place)[0])
        ends = place + np.outer((-1.0, 1.0), step * way)
        shown = np.diff(camera.project(ends)[0], axis=0)[0]
        left = path[begun[0]] - path[0]
        across = float(np.linalg.norm(shown) * np.linalg.norm(left))
        if across > 0.0 and abs(float(shown @ left)) >= SMOOTH * across:
            line = place + np.outer((-1.0, 1.0), TANGENT * step * way)
            items.append(
                Lines(
                    line.astype(np.float32), color="accent", width=GUIDE_WIDTH,
                    opacity=GUIDE_OPACITY, hidden="show",
                )
            )  # fmt: skip
    return (Layer("tangents", tuple(items)),) if items else ()


def guide_layer(state: SymmetryState, stroke: Stroke) -> tuple[Layer, ...]:
    """Return the line along an axis of the box on which a straight stroke runs; else nothing."""
    axis = axis_drawn((stroke,), state)
    if axis < 0:
        return ()
    camera = stroke.camera
    begin, end = stroke.points[0], stroke.points[-1]
    way = toward_vanishing(camera, AXES[axis], begin)
    way = way / np.linalg.norm(way)
    along = float((end - begin) @ way)
    pixels = begin + np.outer((0.0, (1.0 + BEYOND) * along), way)
    places = camera.on_plane(pixels, state.centre, camera.axes[2]).astype(np.float32)
    item: Item = Lines(
        places, color=AXIS_PAINTS[axis], width=GUIDE_WIDTH, opacity=GUIDE_OPACITY, hidden="show"
    )
    return (Layer("axis", (item,)),)
