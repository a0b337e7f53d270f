"""Pull: a stroke over a surface, seen from the side, is where its contour is to be."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, resample
from bozzetto.plugin import Context, Gesture, Ink, Job, NextStep, override
from bozzetto.scene import Layer, Scene, Shaded, cast_rays
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.shaping.pull import pulled
from bozzetto_product.solve.canvas import NOTHING, Sources
from bozzetto_product.solve.paper_surfacing import UNPULLED
from bozzetto_product.solve.result import SolvedPatch
from bozzetto_product.solve.solver import solve_product
from bozzetto_product.tools.product_tool import ProductTool, standing
from bozzetto_product.view.scene import LIT_OPACITY

LOOKS: Final = 33
"""Places of a stroke that are looked at."""

_NOTHING: Final = "Draw curves that enclose an area first: it gets a surface, which you can pull."


class Pull(ProductTool):
    """Pulls the surface under a stroke, so that its contour follows it."""

    id = "pull"
    title = "Pull"
    icon = "icons/pull.svg"
    group = "Reshape"
    hint = "See a surface from the side, and draw where its contour is to be."

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return the gesture; where there is no surface, that curves are to be drawn."""
        if not state.of_kind(Patch):
            return NextStep(_NOTHING, tool="draw")
        if state.surfaces == "paper":
            return NextStep(UNPULLED)
        return NextStep(self.hint)

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the surface that would come, lit."""
        if not isinstance(gesture, Ink):
            return Scene()
        stroke = gesture.strokes[-1]
        one = _meant(state, stroke, context.sources)
        if one is None or one.fill is None:
            return Scene()
        found = pulled(one.fill, stroke)
        item = Shaded(found.fill.mesh, "accent", LIT_OPACITY, pickable=False)
        return Scene((Layer("lit", (item,)),))

    @override
    @standing
    def draw(self, state: ProductState, ink: Ink, context: Context) -> ProductState:
        """Pull the chosen surface, or the one under the strokes.

        Raises
        ------
        UserError
            If there is no surface, or it cannot follow a stroke.
        """
        for stroke in ink.strokes:
            state = with_pull(state, stroke, context.sources)
        return state


def with_pull(state: ProductState, stroke: Stroke, sources: Sources = NOTHING) -> ProductState:
    """Return the state with a surface that follows one more stroke.

    Raises
    ------
    UserError
        If there is no surface under the stroke, or it cannot follow it.
    """
    if state.surfaces == "paper":
        raise UserError(UNPULLED)
    one = _meant(state, stroke, sources)
    if one is None or one.fill is None:
        raise UserError(
            "There is no surface under the stroke. Draw it over a surface, or choose one first."
        )
    found = pulled(one.fill, stroke)
    if found.problem:
        raise UserError(f"{one.name} stays: {found.problem}")
    patch = one.patch
    if one.mirrored:
        after = replace(patch, pulls_mirrored=patch.pulls_mirrored.extended((stroke,)))
    else:
        after = replace(patch, pulls=patch.pulls.extended((stroke,)))
    return replace(state.with_node(after), selected=state.selected)


def _meant(state: ProductState, stroke: Stroke, sources: Sources) -> SolvedPatch | None:
    """Return the surface that a stroke means: the chosen one, else that under most of it.

    Where there is none under it, the one that is seen nearest to its middle.
    """
    filled = solve_product(state, Job("preview", sources=sources)).filled
    if not filled or len(stroke.points) < 2:
        return None
    chosen = state.chosen_of(Patch)
    if chosen is not None:
        filled = tuple(one for one in filled if one.patch.id == chosen.id) or filled
    meshes = [one.mesh for one in filled if one.mesh is not None]
    places = resample(stroke.points, count=LOOKS)
    scene = Scene((Layer("surfaces", tuple(Shaded(mesh) for mesh in meshes)),))
    hits = cast_rays(scene, stroke.camera.rays(places))
    if hits.hit.any():
        numbers = [hits.surfaces[on].number for on in hits.on[hits.hit]]
        return filled[int(np.bincount(numbers).argmax())]
    middle = places[LOOKS // 4 : -LOOKS // 4].mean(axis=0)
    away = [
        float(np.nanmin(np.linalg.norm(stroke.camera.project(m.vertices)[0] - middle, axis=1)))
        for m in meshes
    ]
    return filled[int(np.argmin(away))]
