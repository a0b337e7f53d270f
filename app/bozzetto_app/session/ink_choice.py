"""Which of the ink that waits goes to the tool in the hand."""

from __future__ import annotations

from bozzetto.document.waiting_ink import Waiting, strokes_of
from bozzetto.ink.stroke import Stroke

__all__ = ["ink_to_try"]


def ink_to_try(
    waiting: Waiting, until: Stroke, modeler: str, tool: str, *, committed: bool
) -> tuple[tuple[Stroke, ...], ...]:
    """Which of the ink that waits goes to a tool, and what is tried where it is not taken.

    Ink waits for the tool that it was drawn for; only Enter hands it to another, where the
    tool in the hand has none of its own. A stroke is tried together with refused ink, which
    it may mend, and without, for refused ink must not stand in the way of other ink. Ink that
    a plugin failed over is tried again at Enter only, by itself.

    Parameters
    ----------
    waiting : tuple of WaitingStroke
    until : Stroke
        The newest one to be tried.
    modeler, tool : str
        In whose hands it comes.
    committed : bool
        Whether the person said that this is all.

    Returns
    -------
    tuple of tuple of Stroke
        Empty where `until` no longer waits.
    """
    places = [place for place, one in enumerate(waiting, 1) if one.stroke is until]
    if not places:
        return ()
    drawn = waiting[: places[0]]
    own = tuple(one for one in drawn if one.is_for(modeler, tool))
    if committed:
        own = own or drawn
        own = tuple(one for one in own if one.status != "failed") or own
    else:
        own = tuple(one for one in own if one.status != "failed" or one.stroke is until)
    good = tuple(one for one in own if not one.is_marked)
    tries = [own, good] if good and len(good) < len(own) else [own]
    return tuple(map(strokes_of, tries)) if own else ()
