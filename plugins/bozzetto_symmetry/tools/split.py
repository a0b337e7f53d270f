"""Split: a short stroke across a curve, or a touch on it, cuts it there."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import crossings
from bozzetto.plugin import Context, Gesture, Ink, Tap, override
from bozzetto.scene import Layer, Points, Scene
from bozzetto.view import Camera
from bozzetto_symmetry.editing.trim import share_of
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.operations.split import cut_at, replace_by_pieces
from bozzetto_symmetry.solve.picking import Seen, seen_curves
from bozzetto_symmetry.tools.erase import ErasingTool

TOUCH: Final = 12.0
"""How near a curve a touch must be, px."""

DOT: Final = 6.0
"""Extent of a stroke, px, below which it is a touch."""

AT_END: Final = 8.0
"""Distance from an end, or from the centre plane, px, within which there is nothing to cut."""

DOT_SIZE: Final = 7.0
"""Size of the marks where curves would be cut, px."""

_NOTHING: Final = "There is no curve here. Draw a short stroke across a curve to cut it."
_END: Final = "The curve ends here. Draw the stroke farther inside to cut it."
_PLANE: Final = (
    "The curve crosses the centre plane here, and its halves are one another's mirror image: "
    "they are one curve. Cut it beside the plane."
)


class Split(ErasingTool):
    """Cuts curves in two; a closed one is opened first.

    A curve across the plane is cut on both sides at once: its middle stays one curve across
    the plane, and the rest becomes a pair.
    """

    id = "split"
    title = "Split"
    icon = "icons/split.svg"
    hint = "Draw a short stroke across a curve, or touch it, to cut it there."

    @override
    def preview(self, state: SymmetryState, gesture: Gesture, context: Context) -> Scene:
        """Return marks where curves would be cut."""
        if not isinstance(gesture, Ink):
            return Scene()
        cuts = _cuts(state, gesture.strokes[-1].points, gesture.strokes[-1].camera)
        if not cuts:
            return Scene()
        points = np.vstack([side.place(at) for side, places in cuts for at in places])
        placed = state.plane.placement.points(points).astype(np.float32)
        dots = Points(placed, color="accent", size=DOT_SIZE, hidden="show")
        return Scene((Layer("preview", (dots,)),))

    @override
    def draw(self, state: SymmetryState, ink: Ink, context: Context) -> SymmetryState:
        """Cut what the stroke crosses.

        Raises
        ------
        UserError
            If there is no curve, or nothing to cut where it is.
        """
        for stroke in ink.strokes:
            state = _cut(state, stroke.points, stroke.camera)
        return state

    @override
    def tap(self, state: SymmetryState, tap: Tap, context: Context) -> SymmetryState:
        """Cut the curve that is touched; see `draw`."""
        return _cut(state, np.array([[tap.x, tap.y]]), tap.camera)


def _cut(state: SymmetryState, ink: Array, camera: Camera) -> SymmetryState:
    cuts = _cuts(state, ink, camera)
    if not cuts:
        raise UserError(_NOTHING)
    shares: dict[str, list[float]] = {}
    problem = ""
    for side, places in cuts:
        for at in places:
            trouble = _trouble(side, at)
            problem = problem or trouble
            if not trouble:
                shares.setdefault(side.node.id, []).append(share_of(side.curve, at))
    if not shares:
        raise UserError(problem)
    for side, _ in cuts:
        if side.node.id in shares:
            pieces = cut_at(side.curve, shares.pop(side.node.id))
            state = replace_by_pieces(state, side.node, pieces)
    return state


def _cuts(state: SymmetryState, ink: Array, camera: Camera) -> list[tuple[Seen, list[float]]]:
    """Return sides of curves with the parameters at which a stroke crosses them.

    A touch means the nearest place.
    """
    seen = seen_curves(state, camera)
    if float(np.ptp(ink, axis=0).max()) < DOT:
        touch = ink.mean(axis=0)
        near = [(float(side.distances([touch])[0]), k) for k, side in enumerate(seen)]
        away, number = min(near, default=(np.inf, -1))
        return [(seen[number], [seen[number].nearest(touch)])] if away <= TOUCH else []
    found = []
    for side in seen:
        parameters, path = side.visible
        met = crossings(path, ink) if len(path) > 1 else None
        if met is not None and len(met):
            at = np.interp(met.first, np.arange(len(path)), parameters)
            found.append((side, [float(u) for u in at]))
    return found


def _trouble(side: Seen, at: float) -> str:
    """Return why a curve cannot be cut at a parameter; "" where it can."""
    here = side.seen_at([at])[0]
    ends = side.seen_at(side.ends)
    if len(ends) and np.linalg.norm(ends - here, axis=1).min() <= AT_END:
        return _END
    middle = side.seen_at(side.crossings)
    if len(middle) and np.linalg.norm(middle - here, axis=1).min() <= AT_END:
        return _PLANE
    return ""
