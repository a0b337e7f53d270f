"""Redraw: a stroke from place to place of a curve takes the place of the stretch between."""

from __future__ import annotations

from bozzetto.ink import Stroke
from bozzetto.plugin import override
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.redraw import redraw_stretch
from bozzetto_product.tools.over_curve import OverCurve


class Redraw(OverCurve):
    """Draws a stretch of the nearest curve anew, of whatever course."""

    id = "redraw"
    title = "Redraw a stretch"
    icon = "icons/redraw.svg"
    group = "Curve"
    hint = "Begin and end on a curve: what you draw takes the place of the stretch between."

    @override
    def reshaped(self, state: ProductState, strokes: tuple[Stroke, ...]) -> ProductState:
        """Return the state with the stretch between the ends of the strokes exchanged."""
        return redraw_stretch(state, strokes)
