"""Whether other lines and corners explain a drawing nearly as well, and where they differ."""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.draft import Change, Draft
from bozzetto_polyhedron.graph.likelihood import Fits
from bozzetto_polyhedron.graph.search import SPREADS, with_best_spread
from bozzetto_polyhedron.graph.steps import steps

DOUBT: Final = 5.0
"""Cost by which another reading must be worse for a graph to be beyond doubt: odds of 1 to 150."""

MOST_TRIED: Final = 12
"""Changes of which it is asked whether they make the lines those of solids, at most."""


def second_readings(draft: Draft) -> list[Array]:
    """Return where one change would join lines otherwise and cost next to nothing.

    Only changes after which every corner concerned still has three lines count: others would be
    told as such.

    Parameters
    ----------
    draft : Draft
        The likeliest one.

    Returns
    -------
    list of (2,) float64
        The middle of the corners concerned of the likeliest such change, shares of the diagonal;
        empty where there is none.
    """
    cost, place = closest_other(draft)
    return [] if place is None or cost >= DOUBT else [place]


def closest_other(draft: Draft) -> tuple[float, Array | None]:
    """Return what the likeliest other way to join lines costs more, and where it differs.

    Parameters
    ----------
    draft : Draft
        Not changed.

    Returns
    -------
    float
        Nats; infinite where no change leaves every corner concerned three lines.
    (2,) float64 or None
        The middle of the corners concerned, shares of the diagonal.
    """
    best: Change | None = None
    least = float("inf")
    for change in steps(draft):
        if not change.dropped and _joins_otherwise(draft, change):
            price = draft.price(change)
            if price < least:
                best, least = change, price
    if best is None:
        return least, None
    places = draft.places()
    gone = {corner for key in best.removed for corner in draft.lines[key].pair}
    kept = {corner for each in best.added for corner in each.pair}
    concerned = (gone - kept) or gone
    return least, np.array([places[corner] for corner in sorted(concerned)]).mean(0)


def other_drafts(draft: Draft, dearest: float, most: int) -> list[Draft]:
    """Return what one change makes of a draft, where it joins lines otherwise and costs little.

    Parameters
    ----------
    draft : Draft
        Not changed.
    dearest : float
        Cost that a change may add.
    most : int
        Number of drafts, at most.

    Returns
    -------
    list of Draft
        Those that are least in doubt first; each joins other corners than the ones before it.
    """
    priced = [
        (price, number, change)
        for number, change in enumerate(steps(draft))
        if not change.dropped
        and _joins_otherwise(draft, change)
        and (price := draft.price(change)) < dearest
    ]
    found: dict[tuple[tuple[int, int], ...], Draft] = {}
    for _, _, change in sorted(priced, key=lambda each: each[:2])[:MOST_TRIED]:
        other = draft.copied()
        other.apply(change)
        found.setdefault(joined_pairs(other), other)
    every = [Fits(draft.fits.segments, spread, draft.fits.few) for spread in SPREADS]
    best = [with_best_spread(each, every) for each in found.values()]
    return sorted(best, key=lambda each: each.doubt)[:most]


def joined_pairs(draft: Draft) -> tuple[tuple[int, int], ...]:
    """Return which corners of a draft are joined, whatever the strokes between them.

    Corners have numbers from left to right, so that drafts are compared in which the same corners
    were joined the other way round.
    """
    places = draft.places()
    number = {corner: k for k, corner in enumerate(sorted(places, key=lambda each: places[each]))}
    ends = ((number[each.start], number[each.stop]) for each in draft.lines.values())
    return tuple(sorted((min(pair), max(pair)) for pair in ends))


def _joins_otherwise(draft: Draft, change: Change) -> bool:
    """Whether a change joins other corners, and leaves none with fewer than three lines."""
    gone = sorted(draft.lines[key].pair for key in change.removed)
    come = sorted(each.pair for each in change.added)
    if gone == come:
        return False
    degrees: dict[int, int] = {}
    for pairs, sign in ((gone, -1), (come, 1)):
        for corner in (corner for pair in pairs for corner in pair):
            degrees[corner] = degrees.get(corner, draft.degrees.get(corner, 0)) + sign
    return all(degree == 0 or degree >= 3 for degree in degrees.values())
