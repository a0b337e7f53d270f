"""Text: a touch lays a text on a surface; handles move, turn and size it."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.ink import Drawing
from bozzetto.plugin import Context, Drag, Gesture, NextStep, Tap, override
from bozzetto.scene import Layer, Lines, Scene
from bozzetto.view import Camera
from bozzetto_product.details.bodies import DetailedBodies
from bozzetto_product.details.drawing_outlines import drawing_outlines
from bozzetto_product.details.emblem_places import anchored, emblem_outlines
from bozzetto_product.details.ground import Ground, followed_outline, located
from bozzetto_product.details.outline_places import NO_SURFACE, seen_places, tangent_axes
from bozzetto_product.model.emblems import Emblem
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.solve.canvas import Sources
from bozzetto_product.solve.paper_surfacing import UNCARVED
from bozzetto_product.solve.result import ProductResult
from bozzetto_product.solve.solver import grounds_of
from bozzetto_product.tools.detail import DEPTH, GAP, carved_bodies, plain_result
from bozzetto_product.tools.product_tool import ProductTool, standing
from bozzetto_product.view.detail_view import EMBLEM_TOOL, MIDDLE, SIZED, emblem_corner

FIRST: Final = "Text"
"""What a new text says."""

HEIGHT: Final = 0.06
"""Height of the first text, as share of the size of the product."""

ABOVE: Final = 12.0
"""Distance on the sheet of the place that tells what is up for a new text, px."""

ROOM: Final = 0.4
"""Longest side of a drawing, as share of the surface that it is laid on; more is made smaller."""

SMALLEST: Final = 1e-2
LARGEST: Final = 1e4
"""Bounds of heights, mm."""

BESIDE: Final = "There is no surface here. Touch a surface to lay a text on it."
UNCHOSEN: Final = (
    "No surface is chosen, and none is in the middle of the sheet. Choose one in the list of "
    "objects, then add the drawing."
)
GONE: Final = "This handle is not there any more. Choose the text in the list, or touch anew."


class LayText(ProductTool):
    """Lays a text on a surface; what becomes of it is chosen in the panel, as of any detail."""

    id = EMBLEM_TOOL
    title = "Text"
    icon = "icons/emblem.svg"
    hint = "Touch a surface to lay a text on it."
    gesture = "drag"

    @override
    def next_step(self, state: ProductState) -> NextStep:
        """Return the gesture, or where to type and what to drag."""
        if not state.of_kind(Patch):
            return NextStep(NO_SURFACE, tool="draw")
        if state.surfaces == "paper":
            return NextStep(UNCARVED)
        if state.chosen_of(Emblem) is not None:
            return NextStep(
                "Type the text in the panel; drag its middle, or its corner to turn it."
            )
        return NextStep(self.hint)

    @override
    @standing
    def tap(self, state: ProductState, tap: Tap, context: Context) -> ProductState:
        """Lay a text under the pen, upright on the sheet.

        Raises
        ------
        UserError
            If there is no surface that is carved.
        """
        plain = _plain(state, context.sources)
        carved = carved_bodies(state, context.sources)
        pen = np.array((tap.x, tap.y))
        at, up = _touched(tap.camera, pen, grounds_of(plain.patches), carved)
        model = state.chosen_of(Emblem) or next(reversed(state.of_kind(Emblem)), None)
        if model is None:
            model = replace(_first(plain), text=FIRST)
        name = state.unused_name("Text" if model.text else model.name.rstrip(" 0123456789"))
        return _with_emblem(state, replace(model, name=name, turn=0.0), plain, at, up)

    @override
    @standing
    def preview(self, state: ProductState, gesture: Gesture, context: Context) -> Scene:
        """Return the outlines after the drag."""
        if not isinstance(gesture, Drag):
            return Scene()
        emblem = state.chosen_of(Emblem)
        after = self.drag(state, gesture, context).chosen_of(Emblem)
        if emblem is None or after is None:
            return Scene()
        rows = emblem_outlines(after, _grounds(state, context.sources))
        rows = [np.vstack((row, row[:1])) for row in rows]
        starts = np.cumsum([0, *(len(row) for row in rows[:-1])]).astype(np.int32)
        points = np.concatenate(rows).astype(np.float32)
        return Scene((Layer("moved", (Lines(points, starts, color="accent", width=2.0),)),))

    @override
    @standing
    def drag(self, state: ProductState, drag: Drag, context: Context) -> ProductState:
        """Move the chosen text over the surfaces, or turn and size it.

        Raises
        ------
        UserError
            If it leaves the surfaces.
        """
        emblem, grounds = state.chosen_of(Emblem), _grounds(state, context.sources)
        followed = (
            None
            if emblem is None or emblem.places is None or not grounds
            else followed_outline(grounds, emblem.places)
        )
        if emblem is None or followed is None:
            raise UserError(GONE)
        at, above = followed.points[:2]
        begin, end = drag.path.points[0], drag.path.points[-1]
        if drag.handle == MIDDLE:
            # The pen may hold the handle a little beside.
            seen = drag.camera.project(at[None])[0][0]
            carved = carved_bodies(_without(state, emblem), context.sources)
            place, _ = _touched(drag.camera, seen + end - begin, grounds, carved)
            return state.with_node(replace(emblem, places=anchored(grounds, place, above - at)))
        if drag.handle != SIZED:
            raise UserError(GONE)
        middle, axes = tangent_axes(at, above - at, grounds)
        corner = emblem_corner(emblem, grounds)
        if corner is None:
            raise UserError(GONE)
        seen = drag.camera.project(corner[None])[0][0]
        goal = drag.camera.on_plane((seen + end - begin)[None], middle, axes[2])[0]
        if not np.isfinite(goal).all():
            raise UserError("It is seen end on here. Turn the view, and drag again.")
        way, was = ((point - middle) @ axes[:2].T for point in (goal, corner))
        share = float(np.linalg.norm(way) / max(float(np.linalg.norm(was)), 1e-12))
        turn = emblem.turn + float(np.degrees(np.arctan2(*way[::-1]) - np.arctan2(*was[::-1])))
        height = float(np.clip(emblem.height * share, SMALLEST, LARGEST))
        turn = float((turn + 180.0) % 360.0 - 180.0)
        return state.with_node(replace(emblem, height=height, turn=turn))


def with_drawing_laid(state: ProductState, drawing: Drawing, context: Context) -> ProductState:
    """Return the state with the closed lines of a drawing on a surface, as one detail.

    They lie in the middle of the chosen surface, or else on what is in the middle of the sheet, as
    large as they were drawn where there is room for them.

    Raises
    ------
    UserError
        If there is no surface, or the drawing has no closed lines.
    """
    plain, camera = _plain(state, context.sources), context.camera
    grounds = grounds_of(plain.patches)
    if not grounds:
        raise UserError(NO_SURFACE)
    flat, height = drawing_outlines(drawing.strokes, drawing.name)
    chosen = [ground for ground in grounds if ground.patch == state.selected]
    if chosen:
        # Of a surface and its mirror image the one that is turned to the person.
        ground = min(chosen, key=lambda one: float(_middle(one) @ camera.axes[2]))
        at, up = _middle(ground), camera.axes[1]
        grounds_there = (ground,)
    else:
        centre = 0.5 * np.array(camera.viewport, float)
        carved = carved_bodies(state, context.sources)
        at, up = _touched(camera, centre, grounds, carved, UNCHOSEN)
        nearest = located(grounds, at[None]).grounds[0]
        grounds_there = (grounds[int(nearest)],)
    room = ROOM * float(np.ptp(grounds_there[0].fill.mesh.bounds, axis=0).max())
    low, high = flat.points.min(axis=0), flat.points.max(axis=0)
    longest = height * max(1.0, float(high[0] - low[0]))
    height = float(np.clip(height * min(1.0, room / longest), SMALLEST, LARGEST))
    at, _ = tangent_axes(at, up, grounds_there)
    name = state.unused_name(drawing.name or "Outline")
    emblem = replace(_first(plain), flat=flat, height=height, name=name)
    return _with_emblem(state, emblem, plain, at, up)


def _middle(ground: Ground) -> Array:
    """Return the middle of a surface, by area, (3,) mm."""
    mesh = ground.fill.mesh
    corners = mesh.vertices[mesh.faces].astype(float)
    across = cross_product(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    return np.asarray(area @ corners.mean(axis=1) / area.sum())


def _plain(state: ProductState, sources: Sources) -> ProductResult:
    """Return the surfaces without details.

    Raises
    ------
    UserError
        If they are not carved.
    """
    if state.surfaces == "paper":
        raise UserError(UNCARVED)
    return plain_result(state, sources)


def _first(result: ProductResult) -> Emblem:
    """Return a first emblem, in sizes that suit the product."""
    height, depth, gap = (
        float(f"{share * result.size:.2g}") for share in (HEIGHT, 0.3 * DEPTH, GAP)
    )
    return Emblem(height=height, depth=depth, gap=gap)


def _with_emblem(
    state: ProductState, emblem: Emblem, plain: ProductResult, at: Array, up: Array
) -> ProductState:
    """Return the state with a new emblem at a place, chosen."""
    places = anchored(grounds_of(plain.patches), at, up)
    added = replace(emblem, id=state.unused_id(), visible=True, within="", places=places)
    return replace(state.with_node(added), selected=added.id)


def _without(state: ProductState, emblem: Emblem) -> ProductState:
    return replace(state, nodes=tuple(node for node in state.nodes if node.id != emblem.id))


def _grounds(state: ProductState, sources: Sources) -> tuple[Ground, ...]:
    return grounds_of(plain_result(state, sources).patches)


def _touched(
    camera: Camera,
    pixel: Array,
    grounds: tuple[Ground, ...],
    carved: DetailedBodies,
    beside: str = BESIDE,
) -> tuple[Array, Array]:
    """Return the place of surfaces under a pixel, and the direction there that is up on the sheet.

    Raises
    ------
    UserError
        If there is no surface.
    """
    if not grounds:
        raise UserError(NO_SURFACE)
    at = seen_places(pixel[None], camera, grounds, carved.shells, carved.floors, beside)[0]
    _, (*_, normal) = tangent_axes(at, camera.axes[1], grounds)
    # Over an edge the surface above may be elsewhere: the tangent plane tells what is up.
    onto = camera.on_plane((pixel - (0.0, ABOVE))[None], at, normal)[0]
    return at, onto - at if np.isfinite(onto).all() else camera.axes[1]
