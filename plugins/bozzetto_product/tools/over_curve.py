"""Tools that change curves by strokes drawn over them, with the curves that would come shown."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator

from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Gesture, Ink, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.tools.product_tool import CurveTool, changed, standing
from bozzetto_product.view.scene import CHOSEN_WIDTH, lines, polyline


class OverCurve(CurveTool):
    """Changes the curve that strokes are drawn over."""

    @abstractmethod
    def reshaped(self, state: ProductState, strokes: tuple[Stroke, ...]) -> ProductState:
        """Return the state with the curve under the strokes changed.

        Raises
        ------
        UserError
            If there is no curve near them.
        """

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curves that would come, lit."""
        if not isinstance(gesture, Ink):
            return Scene()
        after = self.reshaped(state, gesture.strokes[-1:])
        return Scene((Layer("lit", tuple(_lit_changes(state, after))),))

    @override
    @standing
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Change the curve that the strokes are drawn over.

        Raises
        ------
        UserError
            If there is no curve near them.
        """
        return changed(state, lambda before: self.reshaped(before, ink.strokes))


def _lit_changes(before: ProductState, after: ProductState) -> Iterator[Lines]:
    """Yield the curves that differ, as they would be, with their mirror images."""
    mirror = Reflection(before.symmetry)
    old = {curve.id: curve.spline for curve in before.of_kind(Curve)}
    for curve in after.of_kind(Curve):
        if curve.spline is None or curve.spline is old.get(curve.id):
            continue
        points = polyline(curve.spline)
        yield lines([points], "accent", CHOSEN_WIDTH)
        if curve.mirrored:
            yield lines([mirror.points(points)], "second", CHOSEN_WIDTH)
