"""Redraw: a stroke from place to place of a curve takes the place of the stretch between."""

from __future__ import annotations

from bozzetto.plugin import Context, Gesture, Ink, NextStep, override
from bozzetto.scene import Layer, Scene
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.redraw import redraw_stretch
from bozzetto_product.tools.modify import NO_CURVE, lit_changes
from bozzetto_product.tools.product_tool import ProductTool, changed, has_curves


class Redraw(ProductTool):
    """Draws a stretch of the nearest curve anew, of whatever course."""

    id = "redraw"
    title = "Redraw a stretch"
    icon = "icons/redraw.svg"
    group = "Curve"
    hint = "Begin and end on a curve: what you draw takes the place of the stretch between."

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return the gesture; where there is no curve, that one is to be drawn."""
        return NextStep(self.hint) if has_curves(state) else NextStep(NO_CURVE, tool="draw")

    @override
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curves that would come, lit."""
        if not isinstance(gesture, Ink):
            return Scene()
        after = redraw_stretch(state, gesture.strokes[-1:])
        return Scene((Layer("lit", tuple(lit_changes(state, after))),))

    @override
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Exchange the stretch between the ends of the strokes.

        Raises
        ------
        UserError
            If there is no curve near them.
        """
        return changed(state, lambda before: redraw_stretch(before, ink.strokes))
