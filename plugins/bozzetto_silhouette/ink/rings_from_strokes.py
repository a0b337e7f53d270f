"""Pen strokes to closed rings: cleaned, joined, trimmed, closed, filtered.

Everything is done with the longest side of the drawing scaled to 1, so that the lengths
below are shares of the size and a drawing may be in any unit.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import arc_length
from bozzetto_silhouette.ink.jitter_filter import filtered
from bozzetto_silhouette.ink.joints import joint, self_joint
from bozzetto_silhouette.ink.self_intersections import rings_that_cross, untangled
from bozzetto_silhouette.ink.sketch_ring import sketched_ring
from bozzetto_silhouette.ink.tremor_filter import without_tremor

MOST_STROKES = 1_000
"""Strokes of one part; the nesting of their outlines is looked for pair by pair."""

CLUMP = 2e-4
"""Samples closer than this to the one before are one sample."""

MOST_SAMPLES = 10_000
"""Samples that are kept of one line, and of one ring: with more of them a solid takes longer than
five seconds. A hand draws a few hundred."""

HOOK = 0.022
"""A hook at the start or end of a stroke is not longer than this."""
HOOK_TURN = np.deg2rad(50.0)
"""Turn of a hook: it is larger than this."""

FOLD = 0.12
"""Ink at an end that goes back over itself is not longer than this."""
FOLD_TURN = np.deg2rad(120.0)
"""Turn of such a fold: it is larger than this."""
FOLD_WIDTH = 0.012
"""Ink that goes back over itself lies no farther beside it than this: no limb is so thin."""
FOLD_STEP = 0.01
"""Length over which the direction on both sides of a fold is taken; of sparse ink
half as much again as samples lie apart."""

FOLD_HEADING = 0.06
"""Length over which is told which way a line heads that ends there."""

OWN_GAP = 0.5
"""A stroke whose ends are farther apart than this share of its length is not closed by
itself if another stroke can close it."""

TOUCH_UP = 0.06
"""A stroke over other ink that only makes sure of it is not longer than this."""
TOUCH_UP_WIDTH = 0.008
"""Such a stroke lies no farther beside the others than this: the round end of a limb does."""

SMALLEST = 6e-3
"""Strokes smaller than this beside larger ones are specks."""

_REDRAW = "The outline crosses itself at the marked place. Draw it again, or lift the pen there."


def rings_from_strokes(
    strokes: Sequence[ArrayLike],
    *,
    tolerance: float | None = None,
    grain: float = 0.0,
    by_hand: bool = True,
) -> list[Array]:
    """Turn strokes into closed simple rings that do not cross each other.

    Parameters
    ----------
    strokes : sequence of (n, 2) array_like
        Samples, in any unit.
    tolerance : float, optional
        Size of the jitter to be filtered, in the same unit; measured when not given.
    grain : float
        Distance of the places that samples can have, where they were rounded to whole pixels,
        in the same unit; 0 where they were not.
    by_hand : bool
        Whether a hand drew them, which trembles; curves of a file do not.

    Returns
    -------
    list of (n, 2) float arrays
        First vertex not repeated.

    Raises
    ------
    UserError
        With places in the unit of the strokes.
    """
    given = [np.asarray(s, dtype=np.float64) for s in strokes]
    given = [s[:, :2] for s in given if s.ndim == 2 and s.shape[0] > 0 and s.shape[1] >= 2]
    if not given:
        raise UserError("There is no ink yet. Draw a closed outline.")
    if len(given) > MOST_STROKES:
        raise UserError(
            f"This drawing has {len(given)} strokes; at most {MOST_STROKES} can be one part. "
            "Leave out the small ones, or build its parts one by one."
        )
    if not all(np.isfinite(s).all() for s in given):
        raise UserError("Some samples of this stroke are not numbers. Draw the outline again.")
    everything = np.concatenate(given)
    low, high = everything.min(axis=0), everything.max(axis=0)
    size, middle = float((high - low).max()), 0.5 * (low + high)
    place = tuple(float(v) for v in middle)
    # Below this the differences between samples are only rounding.
    if not size > 1e-12 * max(1.0, float(np.abs(everything).max())):
        raise UserError("This is a dot. Draw a closed outline.", places=[(place[0], place[1])])

    lines = [thinned((s - middle) / size) for s in given]
    lines = [s for s in lines if len(s) >= 2 and np.ptp(s, axis=0).max() > SMALLEST]
    noise = None if tolerance is None else tolerance / size
    trembling = by_hand and tolerance is None
    chains = _chains([without_hooks(s) for s in without_folds(without_touch_ups(lines))])
    try:
        clean = _simple([_closed(chain) for chain in chains], noise, grain / size, trembling)
    except UserError as problem:
        sketched = sketched_ring(lines)
        if sketched is None:
            places = [(float(x), float(y)) for x, y in np.array(problem.places) * size + middle]
            raise UserError(problem.message, places=places) from None
        clean = _simple([sketched], noise, grain / size, trembling)
    if not clean:
        raise UserError(
            "This line encloses nothing. Draw around the shape and come back to the start.",
            places=[(place[0], place[1])],
        )
    return [r * size + middle for r in clean]


def _simple(rings: list[Array], noise: float | None, grain: float, trembling: bool) -> list[Array]:
    """Filter rings; return those that enclose something, without small loops.

    Raises
    ------
    UserError
        If a ring crosses itself or another; with the places.
    """
    rings = [r if len(r) <= MOST_SAMPLES else thinned(r) for r in rings if len(r) >= 3]
    clean: list[Array] = []
    for ring in rings:
        calm = filtered(ring, noise, grain)
        simple, crossings = untangled(without_tremor(calm) if trembling else calm)
        if len(crossings):
            raise UserError(_REDRAW, places=[(float(x), float(y)) for x, y in crossings])
        if simple is not None:
            clean.append(simple)
    meetings = rings_that_cross(clean)
    if len(meetings):
        raise UserError(
            "Two outlines cross at the marked place. Draw one inside the other, or apart.",
            places=[(float(x), float(y)) for x, y in meetings],
        )
    return clean


def specks(strokes: Sequence[ArrayLike]) -> int:
    """Count the strokes that are too small beside the others to be part of an outline."""
    given = [np.asarray(s, dtype=np.float64)[:, :2] for s in strokes]
    everything = np.concatenate(given)
    size = float(np.ptp(everything, axis=0).max())
    return sum(float(np.ptp(s, axis=0).max()) <= SMALLEST * size for s in given)


def thinned(line: Array) -> Array:
    """Drop samples that repeat or clump, and of a very long line all but `MOST_SAMPLES`."""
    clump = CLUMP
    line = _without_clumps(line, clump)
    while len(line) > MOST_SAMPLES:
        clump *= 2.0
        line = _without_clumps(line, clump)
    return line


def _without_clumps(line: Array, clump: float) -> Array:
    """Drop samples closer than `clump` to the one kept before them."""
    keep, (x, y), square = [0], line[0].tolist(), clump * clump
    for number, (px, py) in enumerate(line.tolist()):
        if (px - x) * (px - x) + (py - y) * (py - y) > square:
            keep.append(number)
            x, y = px, py
    return line[keep]


def without_touch_ups(lines: list[Array]) -> list[Array]:
    """Leave out short strokes that lie all along longer ones: they would be joined to and fro."""
    import shapely

    lengths = [float(arc_length(line)[-1]) for line in lines]
    kept = []
    for line, length in zip(lines, lengths, strict=True):
        longer = [other for other, far in zip(lines, lengths, strict=True) if far > length]
        if length < TOUCH_UP and longer:
            ink = shapely.MultiLineString(longer)
            points = shapely.points(_along(line, arc_length(line), np.linspace(0.0, length, 9)))
            if float(shapely.distance(ink, points).max()) < TOUCH_UP_WIDTH:
                continue
        kept.append(line)
    return kept


def without_folds(lines: list[Array]) -> list[Array]:
    """Cut off what goes back over a line itself at its ends."""
    ends = np.array([_end(one) for line in lines for one in (line[::-1], line)]).reshape(-1, 2, 2)
    result = []
    for k, line in enumerate(lines):
        line = _fold_cut(line, np.delete(ends, 2 * k, axis=0))
        result.append(_fold_cut(line[::-1], np.delete(ends, 2 * k + 1, axis=0))[::-1])
    return result


def _end(line: Array) -> tuple[Array, Array]:
    """Return where a line ends, and which way it heads there."""
    arc = arc_length(line)
    return line[-1], line[-1] - _along(line, arc, np.array([max(arc[-1] - FOLD_HEADING, 0.0)]))[0]


def _fold_cut(line: Array, ends: Array) -> Array:
    """Cut the start off up to where the pen turned round, if it lies over the ink after that.

    The tip of a thin limb looks alike. But there the line that leads to the start heads for the
    tip, and at a fold it comes the other way. Of the other `ends` (n, 2, 2) come places and
    headings.
    """
    import shapely

    arc = arc_length(line)
    last = int(np.searchsorted(arc, FOLD))
    if last < 2 or arc[-1] < 4.0 * FOLD:
        return line
    at = np.arange(1, min(last + 1, len(line) - 1))
    step = max(FOLD_STEP, 1.5 * float(np.median(np.diff(arc))))
    behind = line[at] - _along(line, arc, np.maximum(arc[at] - step, 0.0))
    ahead = _along(line, arc, arc[at] + step) - line[at]
    turn = np.arctan2(
        behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], (behind * ahead).sum(axis=1)
    )
    _, heading = ends[np.hypot(*(ends[:, 0] - line[0]).T).argmin()]
    for k in at[np.abs(turn) > FOLD_TURN][::-1].tolist():
        length = float(arc[k])
        rest = shapely.LineString(line[k : np.searchsorted(arc, length + 1.5 * FOLD) + 1])
        first = shapely.points(line[:k])
        comes_back = float(heading @ (line[k] - line[0])) < 0.0
        width = FOLD_WIDTH if comes_back else 0.25 * FOLD_WIDTH
        if float(shapely.distance(rest, first).max()) < width and (
            rest.project(first[0]) > 0.5 * length
        ):
            return line[k:]
    return line


def _along(line: Array, arc: Array, at: Array) -> Array:
    return np.column_stack([np.interp(at, arc, line[:, axis]) for axis in (0, 1)])


def without_hooks(line: Array) -> Array:
    """Cut hooks off both ends."""
    line = _hook_cut(line)
    return _hook_cut(line[::-1])[::-1]


def _hook_cut(line: Array) -> Array:
    """Cut the start off up to the last sharp turn within `HOOK`.

    Only ink that is dense there can show a hook; the corners of a polygon given by its
    vertices are none.
    """
    arc = arc_length(line)
    if arc[-1] < 8.0 * HOOK or np.searchsorted(arc, HOOK) < 6:
        return line
    at = np.arange(0.0, 2.2 * HOOK, HOOK / 8.0)
    p = np.stack([np.interp(at, arc, line[:, k]) for k in (0, 1)], axis=1)
    reach = 3
    ahead = p[2 * reach :] - p[reach:-reach]
    behind = p[reach:-reach] - p[: -2 * reach]
    turn = np.arctan2(
        behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], (behind * ahead).sum(axis=1)
    )
    where = at[reach:-reach]
    sharp = np.flatnonzero((np.abs(turn) > HOOK_TURN) & (where < HOOK))
    if not len(sharp):
        # A hook shorter than the reach shows in the very first direction.
        first, later = p[reach - 1] - p[0], p[3 * reach] - p[2 * reach]
        angle = np.arctan2(first[0] * later[1] - first[1] * later[0], float(first @ later))
        if abs(angle) < 1.5 * HOOK_TURN:
            return line
        cut = at[reach]
    else:
        cut = where[sharp[np.abs(turn[sharp]).argmax()]]
    return line[np.searchsorted(arc, cut) :]


def _chains(lines: list[Array]) -> list[list[Array]]:
    """Group strokes into closed chains, each stroke turned so that ends meet starts.

    Ends are matched greedily, the nearest pair first; the two ends of one stroke are a
    pair like any other unless they are far apart.
    """
    count = len(lines)
    own = [_cost_of_closing(line) for line in lines]
    partner = [-1] * (2 * count)
    for i in range(count):
        if own[i] == 0.0:
            partner[2 * i], partner[2 * i + 1] = 2 * i + 1, 2 * i
    # Only strokes with loose ends look for a partner: a drawing may have thousands that close.
    loose = [i for i in range(count) if own[i] > 0.0]
    number = np.repeat(loose, 2) * 2 + np.tile([0, 1], len(loose)) if loose else np.zeros(0, int)
    ends = np.array([p for i in loose for p in (lines[i][0], lines[i][-1])]).reshape(-1, 2)
    one, other = np.triu_indices(len(number), 1)
    gaps = np.hypot(*(ends[one] - ends[other]).T)
    costs = [
        (own[a // 2] if a // 2 == b // 2 else gap, a, b)
        for gap, a, b in zip(
            gaps.tolist(), number[one].tolist(), number[other].tolist(), strict=True
        )
    ]
    for _, a, b in sorted(costs):
        if partner[a] < 0 and partner[b] < 0:
            partner[a], partner[b] = b, a
    chains, done = [], [False] * count
    for first in range(count):
        if done[first]:
            continue
        chain, end = [], 2 * first
        while not done[end // 2]:
            done[end // 2] = True
            line = lines[end // 2]
            chain.append(line if end % 2 == 0 else line[::-1])
            end = partner[end ^ 1]
        chains.append(chain)
    return chains


def _cost_of_closing(line: Array) -> float:
    """Return the cost of joining the two ends of one stroke, comparable to gaps between strokes."""
    arcs = arc_length(line)
    gap = float(np.hypot(*(line[0] - line[-1])))
    share = gap / max(float(arcs[-1]), 1e-12)
    if len(line) > 2 and gap <= 1.5 * float(np.diff(arcs).max()):
        return 0.0  # only the side back to the first vertex is missing
    if share < 0.1:
        return 0.5 * gap
    return gap * (1.0 if share < OWN_GAP else 3.0)


def _closed(chain: list[Array]) -> Array:
    """Join the strokes of a chain, end to start, and the last to the first."""
    if len(chain) == 1 and np.array_equal(chain[0][0], chain[0][-1]):
        return chain[0][:-1]
    lines = list(chain)
    bridges: list[Array] = []
    for i in range(len(lines)):
        j = (i + 1) % len(lines)
        if i == j:
            line, bridge = self_joint(lines[i])
            lines[i] = line
        else:
            lines[i], lines[j], bridge = joint(lines[i], lines[j])
        bridges.append(bridge)
    pieces = [piece for pair in zip(lines, bridges, strict=True) for piece in pair]
    ring = np.concatenate(pieces)
    return ring[np.any(ring != np.roll(ring, 1, axis=0), axis=1)]
