"""From segments to the likeliest lines and corners: several spreads are tried, the best mended."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Sequence
from typing import Final

from bozzetto.arrays import Flags
from bozzetto_polyhedron.graph.clustering import clustered
from bozzetto_polyhedron.graph.dashes import rows_of_dashes
from bozzetto_polyhedron.graph.draft import NOT_WHOLE, Draft, Joined, draft_of, refitted
from bozzetto_polyhedron.graph.grouping import ACROSS_DASHES, Members, dashed, grouped
from bozzetto_polyhedron.graph.likelihood import FEW_LINES, Fits, Spread
from bozzetto_polyhedron.graph.repair import LEAST_GAIN, repair
from bozzetto_polyhedron.graph.segments import Segments
from bozzetto_polyhedron.graph.step_pairs import with_detours

ACROSS: Final = (0.0015, 0.0025, 0.004, 0.006, 0.009, 0.013)
"""Standard deviations of line ends across the line that are tried, shares of the diagonal."""

OVERSHOOTS: Final = ((0.0, 0.0), (0.015, 0.015), (0.022, 0.032))
"""Standard deviations along the line, and mean overshoots, that are tried; 0 means as across."""

SPREADS: Final = tuple(
    Spread(across, along or 1.3 * across, overshoot)
    for across in ACROSS
    for along, overshoot in OVERSHOOTS
)
"""Every one with every other."""

ACROSS_ROWS: Final = (0.006, 0.01)
"""Distances of dashes from the line through their row that are tried."""

MOST_SPREADS: Final = 5
"""Times that a draft is given another spread, at most."""

MANY_LINES: Final = 48
"""Lines over which only the likeliest draft is mended, so that the answer comes within a second."""

MOST_MENDED: Final = 4
"""Drafts that are mended, one after the other, until one has the lines of solids."""

MOST_LOOSE: Final = 4
"""Corners of one or two lines, above which a drawing is not finished, or shows no solid: two drafts
of it are mended, for no few steps make its lines those of solids."""

MOST_PRICED: Final = 25_000
"""Steps that are priced: no other draft, spread or detour is tried where one that takes as many as
those before took in the mean would go beyond. Drawings of solids take a thousand or two; scribbles,
where all is close to all, took 58,000."""


def best_draft(
    segments: Segments,
    light: Flags,
    checkpoint: Callable[[], None],
    few: tuple[float, float, float] = FEW_LINES,
) -> Draft:
    """Find the likeliest lines and corners.

    Parameters
    ----------
    segments : Segments
        Lengths in shares of the drawing's diagonal.
    light : (k,) bool
        Which ones were drawn lightly.
    checkpoint : callable
        Called between steps; it may raise.
    few : (float, float, float)
        Cost of a corner of no, one, two lines.
    """
    rows = [dashed(segments, light, ACROSS_DASHES)]
    rows += [rows_of_dashes(segments, light, each) for each in ACROSS_ROWS]
    chains = list(dict.fromkeys(tuple(sorted(each)) for each in rows))
    starts = []
    groups: dict[tuple[int, float], tuple[Members, ...]] = {}
    every = [Fits(segments, spread, few) for spread in SPREADS]
    for fits in every:
        spread = fits.spread
        for number, each in enumerate(chains):
            checkpoint()
            key = number, spread.across
            if key not in groups:
                groups[key] = grouped(
                    segments, 1.6 * spread.across + min(0.004, spread.across), each
                )
            starts.append(first_draft(groups[key], fits))
    many = min(len(each.lines) for each in starts) > MANY_LINES
    found: dict[Hashable, Draft] = {}
    left = MOST_PRICED
    for number, start in enumerate(diverse(starts, 1 if many else MOST_MENDED), 1):
        mended, priced = settled(start, every, checkpoint, left)
        left -= priced
        known = found.setdefault(mended.meeting_ends, mended)
        found[mended.meeting_ends] = min(known, mended, key=_doubt)
        best = min(found.values(), key=_doubt)
        if best.is_whole or (number > 1 and best.loose > MOST_LOOSE):
            break
        if not _is_room_for_one_more(MOST_PRICED - left, number, MOST_PRICED):
            left = 0
            break
    best = min(found.values(), key=_doubt)
    if best.loose <= MOST_LOOSE:
        others = [draft for draft in found.values() if draft.doubt < best.doubt + NOT_WHOLE]
        others.sort(key=_doubt)
        for number, draft in enumerate(others):
            made, priced = with_detours(draft, checkpoint, left // (len(others) - number))
            left -= priced
            best = min(best, made, key=_doubt)
            if best.is_whole or left <= 0:
                break
    return with_best_spread(best, every)


def diverse(starts: Sequence[Draft], most: int) -> list[Draft]:
    """Choose the likeliest draft, one of another spread and overshoot, then others.

    Of drafts in which the same ends meet only the likeliest one is chosen, for all are mended to
    the same. Those that take other segments for one line come before others: steps seldom find
    them.

    Parameters
    ----------
    starts : sequence of Draft
        One for each of several spreads.
    most : int
        How many to choose.
    """
    likeliest: dict[Hashable, Draft] = {}
    for each in sorted(starts, key=lambda each: each.cost):
        likeliest.setdefault(each.meeting_ends, each)
    ordered = list(likeliest.values())
    first = ordered[0].fits.spread
    other = [
        each
        for each in ordered
        if each.fits.spread.across != first.across and each.fits.spread.overshoot != first.overshoot
    ][:1]
    chosen = [ordered[0], *other]
    groups = {each.groups for each in chosen}
    for each in ordered:
        if each.groups not in groups:
            groups.add(each.groups)
            chosen.append(each)
    return [*chosen, *(each for each in ordered if each not in chosen)][:most]


def settled(
    draft: Draft, every: Sequence[Fits], checkpoint: Callable[[], None], most: int
) -> tuple[Draft, int]:
    """Repair a draft, choose its likeliest spread, and so on until neither changes.

    Steps lower the cost, and may make lines of solids others: where the draft was less in doubt
    before them, it stays.

    Parameters
    ----------
    draft : Draft
        Changed in place.
    every : sequence of Fits
        One for each spread.
    checkpoint : callable
        Called between steps; it may raise.
    most : int
        Steps that may be priced: no other spread is tried where it would go beyond.

    Returns
    -------
    Draft, int
        The second value is how many steps were priced.
    """
    priced, before = 0, draft.copied()
    for number in range(1, MOST_SPREADS + 1):
        priced += repair(draft, checkpoint)
        better = with_best_spread(draft, every)
        if better is draft:
            break
        draft = better
        if not _is_room_for_one_more(priced, number, most):
            break
    if not draft.is_whole:
        draft = min(draft, with_best_spread(before, every), key=_doubt)
    return draft, priced


def with_best_spread(draft: Draft, every: Sequence[Fits]) -> Draft:
    """Return the same lines and corners with the spread of ends that suits them best.

    Parameters
    ----------
    draft : Draft
        Returned itself if none is better.
    every : sequence of Fits
        One for each spread.
    """
    better = min((refitted(draft, each) for each in every), key=lambda each: each.cost)
    return better if better.cost < draft.cost - LEAST_GAIN else draft


def _is_room_for_one_more(priced: int, count: int, most: int) -> bool:
    """Whether another trial that prices as many steps as some did in the mean stays within most."""
    return priced + priced / count <= most


def _doubt(draft: Draft) -> float:
    return draft.doubt


def first_draft(groups: tuple[Members, ...], fits: Fits) -> Draft:
    """Cluster the ends of grouped segments.

    Parameters
    ----------
    groups : tuple of tuple of int
        Segments of each line.
    fits : Fits
        Lines through segments.
    """
    lines = [fits.line(each) for each in groups]
    corners = clustered(lines).tolist()
    return draft_of(fits, (Joined(line, *pair) for line, pair in zip(lines, corners, strict=True)))
