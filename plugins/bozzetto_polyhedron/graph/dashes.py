"""Dashes in a row: which ones are one line, the longest row first.

A dash alone says little of its direction; the places of all dashes of a line say much. Every two
dashes that could be of one line are tried: all dashes along the line through both, without a large
gap, are a row. The row of most ink is taken, and the others are sought among what is left.
Lengths are shares of the drawing's diagonal.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.grouping import (
    FEWEST_DASHES,
    LONGEST_DASH,
    LONGEST_GAP,
    Members,
    principal_axis,
)
from bozzetto_polyhedron.graph.segments import Segments

MOST_DASHES: Final = 200
"""Dashes over which none are put in rows: hatching, and pairs of them would be too many."""

TURNED: Final = np.radians(12.0)
"""Angle (radians) that a dash without length may differ from its line by, beyond what the
tolerance across its length allows."""

OVERLAP: Final = 0.3
"""Share of a dash that may lie beside another one of its row."""


def rows_of_dashes(segments: Segments, light: Flags, tolerance: float) -> tuple[Members, ...]:
    """Put light segments in straight rows; all other segments are by themselves.

    Light ones of any length: on paper dashes run together.

    Parameters
    ----------
    segments : Segments
        What was drawn.
    light : (k,) bool
        Which ones were drawn lightly; where none was, every short one may be a dash.
    tolerance : float
        Distance of the ends of dashes from the line through the row.
    """
    may_be = light if light.any() else segments.lengths < LONGEST_DASH
    left = np.flatnonzero(may_be)
    rows: list[Members] = []
    fewest = 2 if light.any() else FEWEST_DASHES
    if fewest <= len(left) <= MOST_DASHES:
        candidates = _candidates(segments.ends[left], tolerance)
        free = np.ones(len(left), bool)
        while True:
            row = _heaviest(segments.ends[left], candidates, free, tolerance)
            if row is None or len(row) < fewest:
                break
            rows.append(tuple(sorted(left[row].tolist())))
            free[row] = False
    taken = {k for row in rows for k in row}
    return (*rows, *((k,) for k in range(len(segments)) if k not in taken))


def _candidates(ends: Array, tolerance: float) -> tuple[Index, Index, Array, Array]:
    """Return pairs of dashes (p,) (p,), and of all dashes the weights and places along their lines.

    The last two values are (p, k).
    """
    middles = ends.mean(1)
    one, two = np.triu_indices(len(ends), 1)
    away = middles[two] - middles[one]
    length = np.maximum(np.hypot(*away.T), 1e-9)
    axis = away / length[:, None]
    kept = length > 1e-6
    for number in range(len(ends)):
        own = np.flatnonzero(kept & ((one == number) | (two == number)))
        _, weight = _along(ends[number : number + 1], middles[one[own]], axis[own], tolerance)
        kept[own[weight[:, 0] <= 0.0]] = False
    one, two = one[kept], two[kept]
    along, weight = _along(ends, middles[one], axis[kept], tolerance)
    return one, two, weight, along


def _along(ends: Array, center: Array, axis: Array, tolerance: float) -> tuple[Array, Array]:
    """Return places of the middles of dashes along lines, and weights, both (p, k).

    The weight is the length of a dash, less the nearer it comes to the tolerance: so the line
    through one of two rows side by side has more than one that goes from row to row.
    """
    steps = ends[:, 1] - ends[:, 0]
    lengths = np.maximum(np.hypot(*steps.T), 1e-9)
    away = ends[None] - center[:, None, None]
    across = away[..., 1] * axis[:, None, None, 0] - away[..., 0] * axis[:, None, None, 1]
    along: Array = (away.mean(2) * axis[:, None]).sum(2)
    sine = np.abs(axis[:, None, 0] * steps[:, 1] - axis[:, None, 1] * steps[:, 0]) / lengths
    near = 1.0 - (np.abs(across).max(2) / tolerance) ** 2
    turned = np.arcsin(np.minimum(sine, 1.0))
    allowed = turned < TURNED + np.arctan(0.6 * tolerance / lengths)
    weight: Array = np.where(allowed & (near > 0.0), near, 0.0) * lengths
    return along, weight


def _heaviest(
    ends: Array, candidates: tuple[Index, Index, Array, Array], free: Flags, tolerance: float
) -> Index | None:
    """Return the dashes of the row with most weight among those that are free."""
    one, two, weights, places = candidates
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    alive = np.flatnonzero(free[one] & free[two])
    most = (weights[alive] * free).sum(1)
    best: Index | None = None
    least = 0.0
    for number, bound in sorted(zip(alive.tolist(), most.tolist(), strict=True), key=_by_bound):
        if bound <= least:
            break
        weight = weights[number] * free
        row = _unbroken(weight > 0, places[number], lengths, int(one[number]))
        if weight[row].sum() > least:
            best, least = row, float(weight[row].sum())
    return best if best is None else _refitted(ends, best, free, lengths, tolerance)


def _by_bound(entry: tuple[int, float]) -> tuple[float, int]:
    number, bound = entry
    return -bound, number


def _refitted(ends: Array, row: Index, free: Flags, lengths: Array, tolerance: float) -> Index:
    """Fit a line to a row and return the row along that line."""
    center, axis = principal_axis(ends[row])
    along, weight = _along(ends, center[None], axis[None], tolerance)
    fit = (weight[0] > 0) & free
    inside = row[fit[row]]
    return _unbroken(fit, along[0], lengths, int(inside[0])) if len(inside) else row


def _unbroken(fit: Flags, along: Array, lengths: Array, through: int) -> Index:
    """Return dashes along a line without large gaps, with a given one among them."""
    order = np.flatnonzero(fit)
    order = order[np.argsort(along[order], kind="stable")]
    gaps = np.diff(along[order]) - 0.5 * (lengths[order][1:] + lengths[order][:-1])
    breaks = np.flatnonzero(gaps > LONGEST_GAP)
    at = int(np.flatnonzero(order == through)[0])
    first = int(breaks[breaks < at].max()) + 1 if (breaks < at).any() else 0
    last = int(breaks[breaks >= at].min()) if (breaks >= at).any() else len(order) - 1
    return order[first : last + 1]
