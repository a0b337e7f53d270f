"""Waiting ink: strokes on the sheet that no modeler has taken yet.

Every stroke is waiting ink from the moment the pen is lifted, and stays so until a modeler
takes it, or the person takes it back. So it is part of the document: history, journal and
file keep it like everything else.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, get_args

import numpy as np

from bozzetto.ink.checked_points import is_seen, seen_through
from bozzetto.ink.stroke import Stroke

WaitingStatus = Literal["new", "unfinished", "refused", "failed"]

MAX_REASON: Final = 2000
"""Longest reason that is kept, characters."""

MAX_PLACES: Final = 1000
"""Most places that are kept with a reason."""


@dataclass(frozen=True, eq=False)
class WaitingStroke:
    """A stroke that waits.

    Parameters
    ----------
    stroke : Stroke
    modeler, tool : str
        What it was drawn for, or what tried it last; "" where that was not known yet.
    status : {"new", "unfinished", "refused", "failed"}
        No modeler has answered yet; it is good so far and needs more strokes; it was refused
        with a reason; the modeler raised, hung or was stopped.
    reason : str
        What the person was told.
    places : tuple of (x, y)
        Where it is wrong, canvas pixels of the stroke's own camera.
    """

    stroke: Stroke
    modeler: str = ""
    tool: str = ""
    status: WaitingStatus = "new"
    reason: str = ""
    places: tuple[tuple[float, float], ...] = ()

    def __post_init__(self) -> None:
        if self.status not in get_args(WaitingStatus):
            raise ValueError(f"{self.status!r} is no status of waiting ink")
        if not np.isfinite(np.array(self.places, float)).all():
            raise ValueError("the places of waiting ink are finite")

    def is_for(self, modeler: str, tool: str) -> bool:
        """Whether it waits for a tool; a tool that is not known yet may be any."""
        return self.modeler == modeler and ("" in (self.tool, tool) or self.tool == tool)

    @property
    def is_marked(self) -> bool:
        """Whether something is wrong with it."""
        return self.status in ("refused", "failed")


Waiting = tuple[WaitingStroke, ...]
"""All that waits, in the order drawn."""


def strokes_of(waiting: Iterable[WaitingStroke]) -> tuple[Stroke, ...]:
    """Return the strokes themselves."""
    return tuple(one.stroke for one in waiting)


def without(waiting: Waiting, strokes: Iterable[Stroke]) -> Waiting:
    """Return what is left when some strokes are taken, compared by identity."""
    taken = set(map(id, strokes))
    left = tuple(one for one in waiting if id(one.stroke) not in taken)
    return waiting if len(left) == len(waiting) else left


def marked(
    waiting: Waiting,
    strokes: Sequence[Stroke],
    status: WaitingStatus,
    *,
    modeler: str,
    tool: str,
    reason: str = "",
    places: Sequence[tuple[float, float]] = (),
) -> Waiting:
    """Return the ink with what became of some strokes; the places belong to the last of them."""
    meant = set(map(id, strokes))
    if not any(id(one.stroke) in meant for one in waiting):
        return waiting
    finite = tuple((x, y) for x, y in places if np.isfinite((x, y)).all())[:MAX_PLACES]
    return tuple(
        replace(
            one,
            modeler=modeler,
            tool=tool,
            status=status,
            reason=reason[:MAX_REASON],
            places=finite if one.stroke is strokes[-1] else (),
        )
        if id(one.stroke) in meant
        else one
        for one in waiting
    )


def touched(waiting: Waiting, eraser: Stroke, reach: float) -> tuple[Stroke, ...]:
    """Return the strokes that an eraser met.

    Parameters
    ----------
    waiting : tuple of WaitingStroke
        The ink that waits.
    eraser : Stroke
        Its path; strokes are compared as they are seen through its camera.
    reach : float
        Greatest distance between the two lines, pixels; at least one.
    """
    from bozzetto.ink.curves.nearest import distances_to_polyline
    from bozzetto.ink.curves.resample import resample

    path = resample(eraser.points, spacing=0.5 * reach)
    found = []
    for one in waiting:
        seen = seen_through(one.stroke.points, one.stroke.camera, eraser.camera)
        seen = seen[is_seen(seen)]
        if len(seen) and distances_to_polyline(path, seen).min() <= reach:
            found.append(one.stroke)
    return tuple(found)
