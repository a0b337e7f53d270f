"""Plane: three touches set the plane that new curves lie in."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, NextStep, Tap, override
from bozzetto.scene import Layer, Scene
from bozzetto.view import triple
from bozzetto_product.model.planes import Point
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.curve_meant import place_under
from bozzetto_product.projection.planes import plane_through
from bozzetto_product.tools.product_tool import ProductTool, own_surfaces, standing
from bozzetto_product.view.scene import PLANE_TOOL, dots

REACH: Final = 12.0
"""Distance from a curve within which a touch means a place of it, px."""

_FIRST: Final = "Touch three places, on curves or surfaces: new curves lie in the plane of these."
_SET: Final = (
    "New curves lie in this plane; the panel says where else they may lie. Touch three other "
    "places for another plane."
)


class SetPlane(ProductTool):
    """Takes three places, on curves or on whatever is seen; curves are drawn in their plane."""

    id = PLANE_TOOL
    title = "Plane"
    icon = "icons/plane.svg"
    group = "Curve"
    hint = _FIRST
    gesture = "tap"
    hovers = True

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return how many places are still to be touched."""
        known = len(state.plane_places)
        if known == 3:
            return NextStep(_SET)
        return NextStep((_FIRST, "Touch two more places.", "Touch one more place.")[known])

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return a dot at the place under the pen."""
        found = _place_under(state, gesture, context) if isinstance(gesture, Tap) else None
        return Scene() if found is None else Scene((Layer("lit", (dots([found]),)),))

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Take one more place; the third makes the plane, one after that begins another one.

        Raises
        ------
        UserError
            If nothing is under the pen, or three places lie on a line.
        """
        found = _place_under(state, tap, context)
        if found is None:
            raise UserError("There is nothing here. Touch a place on a curve or on a surface.")
        known = state.plane_places if len(state.plane_places) < 3 else ()
        places = (*known, found)
        if len(places) < 3:
            lay = "surface" if state.lay == "plane" else state.lay
            return replace(state, plane_places=places, lay=lay)
        plane_through(places)
        return replace(state, plane_places=places, lay="plane")


def _place_under(state: ProductState, tap: Tap, context: Context) -> Point | None:
    """Return the place of a curve under the pen, else that of what is seen there."""
    surfaces = own_surfaces(context.scene)
    found = place_under(state, tap.camera, (tap.x, tap.y), surfaces, reach=REACH)
    if found is not None:
        return found.point
    hits = context.surface_hit(tap.camera.rays(np.array([[tap.x, tap.y]])))
    return triple(hits.points[0]) if bool(hits.hit[0]) else None
