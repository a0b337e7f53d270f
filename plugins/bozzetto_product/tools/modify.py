"""Modify: a stroke over a curve bends it, in any view, with all that is joined to it."""

from __future__ import annotations

from typing import Final

from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Gesture, Tap, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.curve_meant import CurveMeant, curve_under
from bozzetto_product.operations.modify import modify
from bozzetto_product.tools.over_curve import OverCurve
from bozzetto_product.tools.product_tool import standing
from bozzetto_product.view.scene import lines, polyline

LIT: Final = 6.0
"""Width of the light under the curve that is meant, px."""


class Modify(OverCurve):
    """Bends the nearest curve towards what is drawn over it, or over its mirror image."""

    id = "modify"
    title = "Modify"
    icon = "icons/modify.svg"
    group = "Reshape"
    hint = "Draw over a curve where it is to run; press harder to pull it closer."
    hovers = True

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curve that is meant, lit; of ink the curves that would come."""
        if isinstance(gesture, Tap):
            found = curve_under(state, gesture.camera, (gesture.x, gesture.y), reach=14.0)
            return Scene() if found is None else Scene((Layer("lit", (_lit(state, found),)),))
        return super().preview(state, gesture, context)

    @override
    def reshaped(self, state: ProductState, strokes: tuple[Stroke, ...]) -> ProductState:
        """Return the state with the curve bent towards the strokes."""
        return modify(state, strokes)


def _lit(state: ProductState, found: CurveMeant) -> Lines:
    spline = state.node(found.curve).spline
    points = polyline(spline)
    if found.mirrored:
        points = Reflection(state.symmetry).points(points)
    return lines([points], "accent", LIT, opacity=0.55)
