"""Detail: a round on a finished surface is pressed in, raised, cut out, or told apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Ink, Job, NextStep, override
from bozzetto_product.details.bodies import DetailedBodies
from bozzetto_product.details.outline_places import NO_SURFACE, places_of_ink
from bozzetto_product.model.details import Detail
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.canvas import NOTHING, Sources
from bozzetto_product.solve.paper_surfacing import UNCARVED
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import grounds_of, solve_product
from bozzetto_product.tools.product_tool import ProductTool, standing

DEPTH: Final = 0.02
"""Depth of the first detail, as share of the size of the product."""

GAP: Final = 0.006
"""Gap round the first button, as share of the size of the product."""


class DrawDetail(ProductTool):
    """Draws the outline of a detail on the surface under the pen.

    A detail takes kind, depth, draft angle and gap from the chosen detail, or else the last one.
    While *Draw symmetric* is on it has a mirror image, unless it lies across the plane.
    """

    id = "detail"
    title = "Detail"
    icon = "icons/detail.svg"
    hint = "Draw a round on a surface: the area inside is pressed in."

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return the gesture, and where to choose what becomes of the area."""
        if not state.of_kind(Patch):
            return NextStep(NO_SURFACE, tool="draw")
        if state.surfaces == "paper":
            return NextStep(UNCARVED)
        if state.chosen_of(Detail) is not None:
            return NextStep(
                "Choose kind, depth and draft angle in the panel, or draw another round."
            )
        return NextStep(self.hint)

    @override
    @standing
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Add a detail.

        Raises
        ------
        UserError
            If the ink is not on surfaces, or too small.
        """
        return with_detail_drawn(state, ink.strokes, context.sources)


def with_detail_drawn(
    state: ProductState, strokes: Sequence[Stroke], sources: Sources = NOTHING
) -> ProductState:
    """Return the state with one more detail, the outline of which is ink on a surface.

    Parameters
    ----------
    state : ProductState
        As it stands on what it follows.
    strokes : sequence of Stroke
        In one view.
    sources : Sources
        What it follows.
    """
    if state.surfaces == "paper":
        raise UserError(UNCARVED)
    result = plain_result(state, sources)
    carved = carved_bodies(state, sources)
    grounds = grounds_of(result.patches)
    places, closed = places_of_ink(strokes, grounds, carved.shells, carved.floors)
    model = state.chosen_of(Detail) or next(reversed(state.of_kind(Detail)), None)
    if model is None:
        depth, gap = (float(f"{share * result.size:.2g}") for share in (DEPTH, GAP))
        model = Detail(depth=depth, gap=gap)
    detail = Detail(
        state.unused_id(),
        state.unused_name("Detail"),
        strokes=Strokes(strokes),
        places=places,
        closed=closed,
        mirrored=state.mirror and _is_beside(state.symmetry, places.points),
        kind=model.kind if closed else "split",
        depth=model.depth,
        draft=model.draft,
        gap=model.gap,
        color=model.color,
        finish=model.finish,
    )
    return replace(state.with_node(detail), selected=detail.id)


def _is_beside(plane: Plane, points: Array) -> bool:
    """Whether all points, (n, 3), are on one side of a plane."""
    heights = (points - plane.point) @ np.asarray(plane.normal)
    return bool((heights > 0.0).all() or (heights < 0.0).all())


def plain_result(state: ProductState, sources: Sources) -> ProductResult:
    """Return the surfaces of a product without details, where they are seen.

    Without what the product follows its curves would lie where they were drawn, and its surfaces
    might be turned the other way round.
    """
    nodes = tuple(node for node in state.nodes if not isinstance(node, Detail))
    return solve_product(replace(state, nodes=nodes), Job(sources=sources))


def carved_bodies(state: ProductState, sources: Sources) -> DetailedBodies:
    """Return the surfaces of a product with its details, as they are seen."""
    return solve_product(state, Job("preview", sources=sources)).detailed
