"""Lines that could also meet in another way: what they are in space decides.

On the sheet two readings may cost the same, such as two close lines that exchange their ends.
Mostly only one of them is a solid with planar faces, right angles and hidden lines where light ones
are. Where lines look right on the sheet but leave faces open in space, that is told.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_polyhedron.graph.draft import NOT_WHOLE, Draft
from bozzetto_polyhedron.graph.health import told
from bozzetto_polyhedron.graph.live import LiveGraph, with_certainty, with_draft
from bozzetto_polyhedron.graph.second_reading import joined_pairs, other_drafts
from bozzetto_polyhedron.reconstruction.answers import LEAST_LINES
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.orientation import lines_left_open
from bozzetto_polyhedron.reconstruction.perspective import parallel_view
from bozzetto_polyhedron.reconstruction.readings import readings
from bozzetto_polyhedron.solve.corner_order import in_order

Checkpoint = Callable[[float, str], None]

DEAREST: Final = 12.0
"""Cost on the sheet that a change may add to be looked at in space."""

MOST_OTHERS: Final = 3
"""Changes that are looked at in space from one draft."""

MOST_CHANGES: Final = 2
"""Changes that are made one after the other."""

LEAST_GAIN: Final = 1.0
"""Score less cost by which another draft must be better."""

HIGHEST: Final = 21.0
"""Score that readings do not surpass (20.4 in 250 drawings); what could not win even so is left."""

BEYOND_DOUBT: Final = 10.0
"""Score less cost by which all others must be worse for nothing to be told."""


LEAVES_OPEN: Final = NOT_WHOLE
"""Cost of lines whose best reading in space leaves faces open."""


@dataclass(frozen=True, eq=False)
class _Read:
    """A draft with the score of its best reading in space less its cost on the sheet.

    Parameters
    ----------
    live : LiveGraph
        The graph of the draft.
    draft : Draft
    value : float
    open : (k, 2) array
        Middles of the lines that are not between two faces, px.
    """

    live: LiveGraph
    draft: Draft
    value: float
    open: Array


def decided(live: LiveGraph, camera: Camera, checkpoint: Checkpoint) -> LiveGraph:
    """Return the graph whose best reading in space speaks most for it.

    Parameters
    ----------
    live : LiveGraph
        What the whole search found.
    camera : Camera
        Through which it was drawn.
    checkpoint : callable
        Called between readings; it may raise.

    Returns
    -------
    LiveGraph
        The same lines where the sheet leaves no doubt and its lines are those of solids, and where
        something else looks wrong. Where readings in space leave no doubt, the finding is taken
        out; where they leave faces open, that is a finding. Its certainty is that of what was
        chosen.
    """
    return with_certainty(_chosen(live, camera, checkpoint))


def _chosen(live: LiveGraph, camera: Camera, checkpoint: Checkpoint) -> LiveGraph:
    """Return the graph whose best reading in space speaks most for it, without its certainty."""
    if any(each.what != "second reading" for each in live.graph.health):
        return live
    if live.draft is None or live.draft.loose or (live.draft.is_whole and not live.graph.health):
        return live
    best = _read(live, live.draft, camera)
    values = {joined_pairs(best.draft): best.value}
    for _ in range(MOST_CHANGES):
        better = best
        for draft in other_drafts(best.draft, DEAREST, MOST_OTHERS):
            pairs = joined_pairs(draft)
            if pairs in values:
                continue
            values[pairs] = HIGHEST - draft.cost
            if values[pairs] < better.value + LEAST_GAIN or not draft.is_whole:
                continue
            checkpoint(0.5, "Comparing lines")
            other = _read(with_draft(live, draft), draft, camera)
            values[pairs] = other.value
            if other.value >= better.value + LEAST_GAIN:
                better = other
        if better is best:
            break
        best = better
    del values[joined_pairs(best.draft)]
    others = max(values.values(), default=best.value - BEYOND_DOUBT)
    doubts = [each for each in best.live.graph.health if each.what != "second reading"]
    if len(best.open):
        middle = best.open[np.linalg.norm(best.open - best.open.mean(0), axis=1).argmin()]
        doubts.append(told(middle, "open faces"))
    elif live.graph.health and best.value < others + BEYOND_DOUBT:
        doubts = list(best.live.graph.health or live.graph.health)
    return replace(best.live, graph=replace(best.live.graph, health=tuple(doubts)))


def _read(live: LiveGraph, draft: Draft, camera: Camera) -> _Read:
    graph = in_order(live.graph)
    drawing = drawing_of(graph)
    value, middles = float("-inf"), graph.places[drawing.lines].mean(1)
    if len(drawing.lines) >= LEAST_LINES:
        view = parallel_view(drawing, camera).drawing
        best = max(readings(view, thorough=False), key=lambda each: each.score, default=None)
        if best is not None:
            middles = middles[lines_left_open(best.faces, view.lines)]
            value = best.score - (LEAVES_OPEN if len(middles) else 0.0)
    return _Read(live, draft, value - draft.cost, middles)
