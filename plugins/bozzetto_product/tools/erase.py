"""Erase: a stroke along a curve takes it away, with any pen."""

from __future__ import annotations

from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Layer, Scene
from bozzetto_product.model.state import ProductState
from bozzetto_product.tools.product_tool import ProductTool, curves_along, erased
from bozzetto_product.view.scene import lines, polyline


class Erase(ProductTool):
    """Takes away the curves that a stroke runs along, for pens without an eraser."""

    id = "erase"
    title = "Erase"
    icon = "icons/erase.svg"
    hint = "Rub along a curve to take it away; its surfaces go with it."

    @override
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curves that would go, lit."""
        if not isinstance(gesture, Ink):
            return Scene()
        meant = [state.node(name) for name in curves_along(state, gesture.strokes[-1])]
        items = tuple(lines([polyline(curve.spline)], "warning", 5.0) for curve in meant)
        return Scene((Layer("lit", items),))

    @override
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Take away what the strokes run along.

        Raises
        ------
        UserError
            If there is no curve under one of them.
        """
        for stroke in ink.strokes:
            state = erased(state, stroke)
        return state
