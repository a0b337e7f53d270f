"""Lines that could also meet in another way: what they are in space decides.

On the sheet two readings may cost the same, such as two close lines that exchange their ends.
Mostly only one of them is a solid with planar faces, right angles and hidden lines where light ones
are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from bozzetto.view import Camera
from bozzetto_polyhedron.graph.draft import Draft
from bozzetto_polyhedron.graph.live import LiveGraph, with_draft
from bozzetto_polyhedron.graph.second_reading import joined_pairs, other_drafts
from bozzetto_polyhedron.reconstruction.answers import LEAST_LINES
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.perspective import parallel_view
from bozzetto_polyhedron.reconstruction.readings import readings
from bozzetto_polyhedron.solve.corner_order import in_order

Checkpoint = Callable[[float, str], None]

DEAREST: Final = 12.0
"""Cost on the sheet that a change may add to be looked at in space."""

MOST_OTHERS: Final = 2
"""Changes that are looked at in space from one draft."""

MOST_CHANGES: Final = 2
"""Changes that are made one after the other."""

LEAST_GAIN: Final = 1.0
"""Score less cost by which another draft must be better."""

HIGHEST: Final = 21.0
"""Score that readings do not surpass (20.4 in 250 drawings); what could not win even so is left."""

BEYOND_DOUBT: Final = 10.0
"""Score less cost by which all others must be worse for nothing to be told."""


@dataclass(frozen=True, eq=False)
class _Read:
    """A draft with the score of its best reading in space less its cost on the sheet."""

    live: LiveGraph
    draft: Draft
    value: float


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
        The same one where the sheet leaves no doubt, where something else looks wrong, and where
        its lines are not those of solids: such readings take long and seldom decide. Where readings
        in space leave no doubt, the finding is taken out.
    """
    if [each.what for each in live.graph.health] != ["second reading"]:
        return live
    if live.draft is None or not live.draft.is_whole:
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
    others = max(values.values(), default=best.value)
    if best.value < others + BEYOND_DOUBT:
        doubts = best.live.graph.health or live.graph.health
    else:
        doubts = tuple(each for each in best.live.graph.health if each.what != "second reading")
    return replace(best.live, graph=replace(best.live.graph, health=doubts))


def _read(live: LiveGraph, draft: Draft, camera: Camera) -> _Read:
    drawing = drawing_of(in_order(live.graph))
    score = float("-inf")
    if len(drawing.lines) >= LEAST_LINES:
        found = readings(parallel_view(drawing, camera).drawing, thorough=False)
        score = max((each.score for each in found), default=score)
    return _Read(live, draft, score - draft.cost)
