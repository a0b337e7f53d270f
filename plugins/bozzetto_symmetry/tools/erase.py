"""The pen's other end: with any tool, it takes away what it rubs over."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Flags
from bozzetto.errors import UserError
from bozzetto.ink import (
    Stroke,
    distances_to_polyline,
    is_one_view,
    on_canvas,
    resample,
)
from bozzetto.plugin import Context, Ink, Tool, override
from bozzetto_symmetry.editing.trim import share_of
from bozzetto_symmetry.model.state import Curve, Line, SymmetryState
from bozzetto_symmetry.operations.split import Stretch, replace_by_pieces, without_stretch
from bozzetto_symmetry.solve.picking import Seen, seen_curves

REACH: Final = 9.0
"""Half the width of the eraser, px."""

MOST: Final = 0.6
"""Share of a curve that must be rubbed over for all of it to go."""

ALONG: Final = 0.5
"""Share of the path over a curve, against the curve it covers most, from which it is meant too."""

LOOKS: Final = 64
"""Places of a path or of a construction line that are looked at."""


class ErasingTool(Tool[SymmetryState]):
    """A tool of the modeler: the eraser does the same with all of them."""

    @override
    def erase(self, state: SymmetryState, ink: Ink, context: Context) -> SymmetryState:
        """Take away what the eraser's path lies over; see `erase`."""
        return erase(state, ink.strokes[-1])


def erase(state: SymmetryState, eraser: Stroke) -> SymmetryState:
    """Return the state without what the eraser's path lies over.

    A curve goes whole where most of it is rubbed over; else the stretch that is rubbed over
    is cut out of it, on both sides of the plane. Of a curve that still waits for its other
    side the strokes go, and a construction line goes whole.

    Raises
    ------
    UserError
        If there is nothing under the eraser.
    """
    before = state
    solved = seen_curves(state, eraser.camera)
    for side in _meant(solved, eraser):
        state = _without_part(state, side, _rubbed(side, eraser))
    known = {side.node.id for side in solved}
    for node in before.shown_curves:
        if node.id not in known:
            state = _without_strokes(state, node, eraser)
    for line in before.shown_lines:
        if _is_over(line, eraser):
            state = state.without_nodes(line.id)
    if state == before:
        raise UserError("There is no curve under the eraser. Rub along what is to go.")
    return state


def _meant(seen: Sequence[Seen], eraser: Stroke) -> list[Seen]:
    """Return the sides that the path runs along, one of each curve.

    Sides that it only crosses are not meant.
    """
    path = resample(eraser.points, count=LOOKS)
    best: dict[str, tuple[int, Seen]] = {}
    for side in seen:
        near = int((side.distances(path) <= REACH).sum())
        if near > best.get(side.node.id, (0, side))[0]:
            best[side.node.id] = near, side
    most = max((near for near, _ in best.values()), default=0)
    return [side for near, side in best.values() if near >= ALONG * most]


def _rubbed(side: Seen, eraser: Stroke) -> Flags:
    """Return which places of a side are under the path; places behind the eye are not."""
    flags = np.zeros(len(side.pixels), bool)
    seen = np.isfinite(side.pixels).all(axis=1)
    flags[seen] = distances_to_polyline(side.pixels[seen], eraser.points) <= REACH
    return flags


def _without_part(state: SymmetryState, side: Seen, flags: Flags) -> SymmetryState:
    steps = np.linalg.norm(np.diff(side.place(side.parameters), axis=0), axis=1)
    share = float(steps[flags[:-1] & flags[1:]].sum() / steps.sum())
    if share >= MOST:
        return state.without_nodes(side.node.id)
    if not flags.any():
        return state
    left = without_stretch(side.curve, _stretch(side, flags))
    return replace_by_pieces(state, side.node, left)


def _stretch(side: Seen, flags: Flags) -> Stretch:
    """Return the shares of a curve that are rubbed over, without gaps."""
    rubbed = side.parameters[flags]
    if side.curve.reading == "self":
        shares = [share_of(side.curve, float(at)) for at in rubbed]
        return min(shares), max(shares)
    begin, end = side.curve.spline.range
    shares = np.unique((rubbed - begin) / (end - begin)).tolist()
    if not side.curve.closed or not (flags[0] and flags[-1]):
        return shares[0], shares[-1]
    # Rubbed over the seam: the widest gap between rubbed places is what stays.
    gap = int(np.argmax(np.diff(shares)))
    return shares[gap + 1], shares[gap] + 1.0


def _without_strokes(state: SymmetryState, node: Curve, eraser: Stroke) -> SymmetryState:
    """Return a state without a curve's strokes of this view that are mostly rubbed over."""
    kept = [k for k, stroke in enumerate(node.strokes) if not _is_rubbed(stroke, eraser)]
    if len(kept) == len(node.strokes):
        return state
    return state.with_node(node.with_only(kept)) if kept else state.without_nodes(node.id)


def _is_rubbed(stroke: Stroke, eraser: Stroke) -> bool:
    """Whether a stroke was drawn in the view of the eraser and is mostly rubbed over."""
    if not is_one_view(stroke.camera, eraser.camera):
        return False
    places = on_canvas(stroke, eraser.camera).points
    return bool((distances_to_polyline(places, eraser.points) <= REACH).mean() >= MOST)


def _is_over(line: Line, eraser: Stroke) -> bool:
    share = np.linspace(0.0, 1.0, LOOKS)[:, None]
    points = (1.0 - share) * np.array(line.begin) + share * np.array(line.end)
    pixels = eraser.camera.project(points)[0]
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    near = distances_to_polyline(pixels, eraser.points) <= REACH if len(pixels) else np.zeros(1)
    return bool(near.mean() >= MOST)
