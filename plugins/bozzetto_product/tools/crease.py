"""Crease: a touch on an edge makes the surfaces meet in a crease, smoothly, or in between."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Job, Tap, override
from bozzetto.scene import Layer, Scene
from bozzetto_product.model.curve_stretch import with_stretch
from bozzetto_product.model.curves import Curve, EdgeKind, Stretch
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.net import Edge
from bozzetto_product.operations.curve_meant import place_under
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.product_tool import CurveTool, own_surfaces, standing
from bozzetto_product.view.scene import CHOSEN_WIDTH, CREASE_TOOL, edge_lines

REACH: Final = 14.0
"""Distance from an edge within which a touch means it, px."""

KINDS: Final[dict[float, EdgeKind]] = {0.0: "smooth", 1.0: "crease"}
"""Kinds of edges by their crease; others lie between."""

LAPS: Final = (0.0, 1.0)
"""Rounds of a closed curve at which a place on it may be meant."""


class SwitchCrease(CurveTool):
    """Switches an edge, which is the piece of a curve between joints, to a crease or to smooth."""

    id = CREASE_TOOL
    title = "Crease"
    icon = "icons/crease.svg"
    group = "Reshape"
    hint = (
        "Touch an edge between joints: surfaces meet in a crease of the strength set, at the next "
        "touch smoothly; with Shift as over the whole curve."
    )
    gesture = "tap"
    hovers = True

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the edge under the pen, lit."""
        if not isinstance(gesture, Tap):
            return Scene()
        result = solve_product(state, Job("preview", sources=context.sources))
        edges = _under(state, gesture, context, result)
        if not edges:
            return Scene()
        lit = [result.net.edges[number] for number in edges]
        return Scene((Layer("lit", (edge_lines(lit, "accent", CHOSEN_WIDTH),)),))

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Switch the edge under the pen.

        Raises
        ------
        UserError
            If there is none.
        """
        result = solve_product(state, Job("preview", sources=context.sources))
        edges = _under(state, tap, context, result)
        if not edges:
            raise UserError("There is no edge here. Touch a curve between two joints.")
        crease = 0.0 if _crease_of(result, edges) == state.strength else state.strength
        kind: EdgeKind = KINDS.get(crease, "between")
        for number in edges:
            edge = result.net.edges[number]
            curve = next(one for one in state.of_kind(Curve) if one.id == edge.curve)
            chosen = None if tap.shift else Stretch(*edge.span, kind, crease)
            state = state.with_node(with_stretch(curve, *edge.span, chosen))
        return state


def _under(state: ProductState, tap: Tap, context: Context, result: ProductResult) -> Sequence[int]:
    """Return the edge under the pen, and where a curve is its own mirror image that of it."""
    found = place_under(state, tap.camera, (tap.x, tap.y), own_surfaces(context.scene), reach=REACH)
    if found is None:
        return ()
    for number, edge in enumerate(result.net.edges):
        if edge.curve == found.curve and not edge.mirrored and _is_at(edge, found.at):
            twin = edge.twin
            own = twin >= 0 and not result.net.edges[twin].mirrored
            return sorted({number, twin}) if own else (number,)
    return ()


def _is_at(edge: Edge, share: float) -> bool:
    low, high = edge.span
    return any(low <= share + lap <= high for lap in LAPS)


def _crease_of(result: ProductResult, edges: Sequence[int]) -> float:
    """Return the crease of edges that are switched together: 0 to 1."""
    told = result.net.edges[edges[0]].crease
    if np.isfinite(told):
        return float(told)
    smooth = any(
        one.is_smooth_at(place)
        for one in result.filled
        for place, (edge, _) in enumerate(one.loop)
        if edge in edges
    )
    return 0.0 if smooth else 1.0
