"""Fillet: a corner between two curves is rounded by a touch, or by dragging the arc."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.plugin import Context, Drag, Gesture, Job, Tap, override
from bozzetto.scene import Layer, Scene, cast_rays
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.corners import CORNER, Corner, corners_of
from bozzetto_product.operations.largest_radius import radius_refused
from bozzetto_product.operations.meetings import splines_of
from bozzetto_product.operations.rounded_corners import rounded_corner
from bozzetto_product.projection.views import pixel_size
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.move import dragged_to
from bozzetto_product.tools.product_tool import (
    CurveTool,
    changed,
    own_surfaces,
    standing,
)
from bozzetto_product.view.scene import (
    CHOSEN_WIDTH,
    FILLET_TOOL,
    lines,
    polyline,
)

REACH: Final = 40.0
"""Distance from a corner within which a touch means it, px."""

LARGEST: Final = 1e5
"""Largest radius, mm; that of the parameter."""

HALVINGS: Final = 4
"""Steps in which the largest radius is found by which no surface folds."""

STILL: Final = 3.0
"""Way of a pen on a dot, px, below which it is a touch: the radius is the one that is set."""

_NOBODY: Final = "There is no corner here. Touch one between the two curves that are meant."


class Fillet(CurveTool):
    """Rounds the corner between two curves that end in one joint."""

    id = FILLET_TOOL
    title = "Fillet"
    icon = "icons/fillet.svg"
    group = "Curve"
    hint = (
        "Drag the dot in a corner: the arc goes where the pen is. A touch between two curves takes "
        "the radius “Fillet”."
    )
    gesture = "drag"

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curves after the drag."""
        if not isinstance(gesture, Drag):
            return Scene()
        before, after = splines_of(state), splines_of(_dragged(state, gesture))
        fresh = [
            polyline(spline)
            for name, spline in after.items()
            if name not in before or not _is_same(spline, before[name])
        ]
        return Scene((Layer("rounded", (lines(fresh, "accent", CHOSEN_WIDTH),)),))

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Round the corner under the pen by the radius that is set.

        Raises
        ------
        UserError
            If there is none, or the radius is too large for it.
        """
        corner = _under(state, tap, own_surfaces(context.scene))
        if corner is None:
            raise UserError(_NOBODY)
        return _sound(state, corner, state.rounding, context)

    @override
    @standing
    def drag(self, state: ProductState, drag: Drag, context: Context) -> ProductState:
        """Round a corner so that its arc is where the pen is; the radius is that of the next touch.

        Raises
        ------
        UserError
            If the handle is not of this product, or the radius is too large.
        """
        return _sound(state, *_asked(state, drag), context)


def _is_same(one: Spline, other: Spline) -> bool:
    return np.array_equal(one.control_points, other.control_points)


def _sound(state: ProductState, corner: Corner, radius: float, context: Context) -> ProductState:
    """Return the network with a corner rounded, unless a surface beside it would fold by that.

    Raises
    ------
    UserError
        If the radius is too large.
    """
    job = Job("preview", sources=context.sources)
    before = _folded(solve_product(state, job))

    def rounded(size: float) -> ProductState:
        asked = replace(state, rounding=size)
        return changed(asked, lambda one: _rounded(one, corner, size))

    def fits(size: float) -> bool:
        return _folded(solve_product(rounded(size), job)) <= before

    made = rounded(radius)
    if _folded(solve_product(made, job)) > before:
        reason = f"With a radius of {radius:.4g} mm a surface beside the arc would fold"
        raise radius_refused(reason, radius, fits, HALVINGS)
    return made


def _folded(result: ProductResult) -> int:
    """Return how many surfaces fold, or have creases so as not to."""
    return sum(one.surface is None or bool(one.creased) for one in result.patches)


def _dragged(state: ProductState, drag: Drag) -> ProductState:
    corner, radius = _asked(state, drag)
    return _rounded(state, corner, radius)


def _asked(state: ProductState, drag: Drag) -> tuple[Corner, float]:
    """Return the corner of a dragged dot, and the radius that is asked for."""
    corner = next(
        (
            one
            for one in corners_of(state.joints, splines_of(state), state.symmetry)
            if one.name == drag.handle
        ),
        None,
    )
    if corner is None or not drag.handle.startswith(CORNER):
        raise UserError("This corner is not there any more. Drag the dot of another one.")
    if float(np.ptp(drag.path.points, axis=0).max()) < STILL:
        return corner, state.rounding
    radius = corner.radius_through(dragged_to(drag, np.array(corner.handle)))
    if not 0.0 < radius <= LARGEST:
        raise UserError("Drag between the two curves: the arc goes where the pen is.")
    return corner, radius


def _rounded(state: ProductState, corner: Corner, radius: float) -> ProductState:
    return rounded_corner(state, corner.joint, corner.first, corner.second, radius, corner.ways)


def _under(state: ProductState, tap: Tap, surfaces: Scene) -> Corner | None:
    """Return the corner that is touched: at the nearest joint, the one that the touch lies in."""
    camera = tap.camera
    pen = np.array((tap.x, tap.y))
    best: tuple[float, float, Corner] | None = None
    for corner in corners_of(state.joints, splines_of(state), state.symmetry):
        seen = camera.project(np.array((corner.place, corner.handle)))[0]
        away = float(np.linalg.norm(seen[0] - pen))
        if not np.isfinite(seen).all() or away > REACH or _is_hidden(corner, tap, surfaces):
            continue
        ways = seen[1] - seen[0], pen - seen[0]
        lengths = float(np.linalg.norm(ways[0]) * np.linalg.norm(ways[1]))
        aside = -float(ways[0] @ ways[1]) / lengths if lengths > 0.0 else 0.0
        # Corners of one joint are told apart by where the touch lies in them.
        key = round(away, 3), aside
        if best is None or key < best[:2]:
            best = (*key, corner)
    return None if best is None else best[2]


def _is_hidden(corner: Corner, tap: Tap, surfaces: Scene) -> bool:
    """Whether a surface is seen before a corner."""
    place = np.array((corner.place,))
    rays = tap.camera.rays(tap.camera.project(place)[0])
    hits = cast_rays(surfaces, rays)
    behind = float((place[0] - hits.points[0]) @ rays.directions[0])
    return bool(hits.hit[0]) and behind > REACH * float(pixel_size(tap.camera, place)[0])
