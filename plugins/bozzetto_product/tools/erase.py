"""Erase: a stroke along a curve, or over a detail, takes it away, with any pen."""

from __future__ import annotations

from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Layer, Scene
from bozzetto_product.model.state import ProductState
from bozzetto_product.tools.product_tool import (
    CurveTool,
    curves_along,
    details_under,
    erased,
    standing,
)
from bozzetto_product.view.scene import lines, polyline


class Erase(CurveTool):
    """Takes away the curves that a stroke runs along, or details, for pens without an eraser."""

    id = "erase"
    title = "Erase"
    icon = "icons/erase.svg"
    hint = "Rub along a curve, or over a detail, to take it away; surfaces go with their curves."

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curves or outlines of details that would go, lit."""
        if not isinstance(gesture, Ink):
            return Scene()
        path = gesture.strokes[-1]
        meant = [state.node(name) for name in curves_along(state, path)]
        rows = [[polyline(curve.spline)] for curve in meant]
        if not rows:
            rows = [
                [*one.outlines]
                for one in details_under(state, gesture.strokes[-1], context.sources)
            ]
        items = tuple(lines(row, "warning", 5.0) for row in rows)
        return Scene((Layer("lit", items),))

    @override
    @standing
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Take away what the strokes run along.

        Raises
        ------
        UserError
            If there is neither a curve nor a detail under one of them.
        """
        for stroke in ink.strokes:
            state = erased(state, stroke, context.sources)
        return state
