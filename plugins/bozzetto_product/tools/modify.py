"""Modify: a stroke over a curve bends it, in any view, with all that is joined to it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from bozzetto.plugin import Context, Gesture, Ink, NextStep, Tap, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.operations.curve_meant import CurveMeant, curve_under
from bozzetto_product.operations.modify import modify
from bozzetto_product.tools.product_tool import ProductTool, changed, has_curves
from bozzetto_product.view.scene import CHOSEN_WIDTH, lines, polyline

LIT: Final = 6.0
"""Width of the light under the curve that is meant, px."""

NO_CURVE: Final = "Draw a curve first; then draw over it where it is to run."


class Modify(ProductTool):
    """Bends the nearest curve towards what is drawn over it, or over its mirror image."""

    id = "modify"
    title = "Modify"
    icon = "icons/modify.svg"
    group = "Reshape"
    hint = "Draw over a curve where it is to run; press harder to pull it closer."
    hovers = True

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return the gesture; where there is no curve, that one is to be drawn."""
        return NextStep(self.hint) if has_curves(state) else NextStep(NO_CURVE, tool="draw")

    @override
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the curve that is meant, lit; of ink the curves that would come."""
        if isinstance(gesture, Tap):
            found = curve_under(state, gesture.camera, (gesture.x, gesture.y), reach=14.0)
            return Scene() if found is None else Scene((Layer("lit", (_lit(state, found),)),))
        if not isinstance(gesture, Ink):
            return Scene()
        after = modify(state, gesture.strokes[-1:])
        return Scene((Layer("lit", tuple(lit_changes(state, after))),))

    @override
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Bend the curve that the strokes are drawn over.

        Raises
        ------
        UserError
            If there is no curve near them.
        """
        return changed(state, lambda before: modify(before, ink.strokes))


def _lit(state: ProductState, found: CurveMeant) -> Lines:
    spline = state.node(found.curve).spline
    points = polyline(spline)
    if found.mirrored:
        points = Reflection(state.symmetry).points(points)
    return lines([points], "accent", LIT, opacity=0.55)


def lit_changes(before: ProductState, after: ProductState) -> Iterator[Lines]:
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
