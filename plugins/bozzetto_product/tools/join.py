"""Join: ends that nearly meet are offered, and a touch joins them."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Gesture, Tap, override
from bozzetto.scene import Layer, Scene
from bozzetto.view import Camera
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.magnets import NearMiss, near_misses
from bozzetto_product.operations.proposals import accept
from bozzetto_product.projection.views import seen_at
from bozzetto_product.tools.product_tool import CurveTool, changed, standing
from bozzetto_product.view.scene import JOIN_TOOL, dots, lines

OFFERED: Final = 60.0
"""Largest gap on the sheet that is offered, px."""

REACH: Final = 24.0
"""Distance from an end, or from where it would be joined, within which a touch means it, px."""

WIDTH: Final = 2.0
"""Width of the line over a gap, px."""


class Join(CurveTool):
    """Joins ends that are too far apart to be joined by themselves."""

    id = JOIN_TOOL
    title = "Join"
    icon = "icons/join.svg"
    group = "Curve"
    hint = "Touch an end that nearly meets a curve: both are joined there."
    gesture = "tap"
    hovers = True

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return all gaps that are offered in this view, the one under the pen stronger."""
        if not isinstance(gesture, Tap):
            return Scene()
        offers = near_misses(state, gesture.camera, tolerance=OFFERED)
        meant = _under(offers, gesture.camera, gesture)
        items: list[object] = []
        for offer in offers:
            way = np.array((offer.place, offer.proposal.place))
            items.append(lines([way], "accent", WIDTH, opacity=1.0 if offer is meant else 0.5))
            items.append(dots(way, opacity=1.0 if offer is meant else 0.5))
        return Scene((Layer("offers", tuple(items)),))  # type: ignore[arg-type]

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Join the end under the pen.

        Raises
        ------
        UserError
            If none is offered there.
        """
        offers = near_misses(state, tap.camera, tolerance=OFFERED)
        meant = _under(offers, tap.camera, tap)
        if meant is None:
            raise UserError(
                "No end that nearly meets a curve is here. Touch a free end, or draw a curve over "
                "the gap."
            )
        return changed(state, lambda before: accept(before, meant.proposal))


def _under(offers: tuple[NearMiss, ...], camera: Camera, tap: Tap) -> NearMiss | None:
    """Return the offer whose gap is under the pen."""
    best: tuple[float, NearMiss] | None = None
    for offer in offers:
        seen = seen_at(camera, np.array((offer.place, offer.proposal.place)))
        away = float(np.linalg.norm(seen - (tap.x, tap.y), axis=1).min())
        if away <= REACH and (best is None or away < best[0]):
            best = away, offer
    return None if best is None else best[1]
