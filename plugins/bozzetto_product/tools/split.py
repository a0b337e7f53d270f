"""Split: a touch on a curve cuts it there."""

from __future__ import annotations

from typing import Final

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Tap, override
from bozzetto.scene import Layer, Scene
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.curve_meant import CurvePlace, place_under
from bozzetto_product.operations.pieces import split_curve
from bozzetto_product.tools.product_tool import (
    CurveTool,
    changed,
    own_surfaces,
    standing,
)
from bozzetto_product.view.scene import dots

REACH: Final = 14.0
"""Distance from a curve within which a touch means it, px."""


class Split(CurveTool):
    """Cuts a curve where it is touched; its pieces stay joined."""

    id = "split"
    title = "Split"
    icon = "icons/split.svg"
    group = "Curve"
    hint = "Touch a curve where it is to be cut; its pieces stay joined."
    gesture = "tap"
    hovers = True

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return a dot at the place where the curve would be cut."""
        found = _under(state, gesture, context) if isinstance(gesture, Tap) else None
        return Scene() if found is None else Scene((Layer("lit", (dots([found.point]),)),))

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Cut the curve under the pen.

        Raises
        ------
        UserError
            If there is none, or its end is too near.
        """
        found = _under(state, tap, context)
        if found is None:
            raise UserError("There is no curve here. Touch a curve where it is to be cut.")
        return changed(state, lambda before: split_curve(before, found.curve, [found.at])[0])


def _under(state: ProductState, tap: Tap, context: Context) -> CurvePlace | None:
    surfaces = own_surfaces(context.scene)
    return place_under(state, tap.camera, (tap.x, tap.y), surfaces, reach=REACH)
