"""Filling of holes: an outline that was drawn around earlier ones need not have them as holes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Strokes
from bozzetto.plugin import Command, Context, remembered
from bozzetto_silhouette.model.state import Cut, Part, SilhouetteState
from bozzetto_silhouette.outline.from_ink import outline_of, points_on_sheet, rings_of, surrounds
from bozzetto_silhouette.solids.placements import is_shown

NOT_AROUND = "The chosen part was not drawn around an earlier outline, so there is no hole to fill."


def fill(state: SilhouetteState, context: Context) -> SilhouetteState:
    """Make the outline that was drawn around the chosen part's earlier ones a part of its own.

    Raises
    ------
    UserError
        If nothing is chosen, or it was not drawn around anything.
    """
    part = part_drawn_around(state)
    if part is None:
        raise UserError(NOT_AROUND)
    count = _earlier_strokes(part)
    rings = _ring_count(replace(part, strokes=Strokes(part.strokes[:count]), edits=()))
    strokes = tuple(part.strokes)
    within = replace(
        part,
        strokes=Strokes(strokes[:count]),
        edits=tuple(edit for edit in part.edits if edit.ring < rings),
    )
    around = replace(
        part,
        id=state.unused_id(),
        name=state.unused_name("Part"),
        strokes=Strokes(strokes[count:]),
        profile=Strokes(),
        edits=tuple(
            replace(edit, ring=edit.ring - rings) for edit in part.edits if edit.ring >= rings
        ),
    )
    outline_of(within)
    outline_of(around)
    nodes = [
        new for old in state.nodes for new in ((within, around) if old.id == part.id else (old,))
    ]
    return replace(state, nodes=tuple(nodes), selected=around.id)


def part_drawn_around(state: SilhouetteState) -> Part | None:
    """Return the chosen part if its last outline was drawn around all its earlier ones."""
    part = next((part for part in state.parts if part.id == state.selected), None)
    if part is None or isinstance(part, Cut) or not is_shown(state, part):
        return None
    return part if _earlier_strokes(part) else None


@remembered(limit=32, key=lambda part: (part.strokes, part.sheet))
def _earlier_strokes(part: Part) -> int:
    """Return how many strokes came before the outline around them; 0 where there is none."""
    strokes = tuple(part.strokes)
    for count in range(len(strokes) - 1, 0, -1):
        around = replace(part, strokes=Strokes(strokes[count:]), edits=())
        within = replace(part, strokes=Strokes(strokes[:count]), edits=())
        try:
            points = np.concatenate(points_on_sheet(within.strokes, part.sheet))
            alone = _ring_count(around) == 1 and _ring_count(within) > 0
            if alone and surrounds(outline_of(around), points):
                return count
        except UserError:  # some strokes of one outline
            continue
    return 0


def _ring_count(part: Part) -> int:
    return len(rings_of(part))


FILL = Command(
    "fill",
    "Fill hole",
    "The outline around an earlier one is a body of its own, and not pierced by it.",
    fill,
    key="Shift+F",
    enabled=lambda state: bool(state.selected),
)
