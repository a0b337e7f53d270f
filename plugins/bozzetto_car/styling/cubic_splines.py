"""Interpolating cubic splines, many at once.

A cubic spline whose third derivative is continuous at the second and the last but one place, too
(*not-a-knot*: de Boor, *A Practical Guide to Splines*, 1978, chapter IV), is the one through all
places that repeats a cubic. Its slopes solve a system with three diagonals; the systems of many
splines follow each other on the same diagonals.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array


def not_a_knot_splines(runs: Sequence[tuple[Array, Array]]) -> list[Array]:
    """Return the pieces of the splines through places.

    Parameters
    ----------
    runs : sequence of ((n,) float, (n, d) float)
        For each spline at least two parameters, which increase, and its places there. Two places
        give a line, three a parabola.

    Returns
    -------
    list of (4, n - 1, d) float
        For each spline the coefficients of the powers 3, 2, 1 and 0 of the parameter from the
        begin of each piece on.
    """
    from scipy.linalg import solve_banded

    if not runs:
        return []
    counts = np.array([len(at) for at, _ in runs])
    begins = np.cumsum(counts) - counts
    at = np.concatenate([own for own, _ in runs])
    places = np.concatenate([own for _, own in runs])
    # Steps from the last place of a spline to the first of the next one mean nothing.
    steps = np.append(np.diff(at), 1.0)
    steps[begins[1:] - 1] = 1.0
    rises = np.append(np.diff(places, axis=0), np.zeros((1, places.shape[1])), axis=0)
    slopes = rises / steps[:, None]
    bands, right = np.zeros((3, len(at))), np.zeros_like(places)
    inner = np.ones(len(at), bool)
    inner[begins] = inner[begins + counts - 1] = False
    mid = np.flatnonzero(inner)
    before, after = steps[mid - 1], steps[mid]
    bands[0, mid + 1], bands[1, mid], bands[2, mid - 1] = before, 2.0 * (before + after), after
    right[mid] = 3.0 * (after[:, None] * slopes[mid - 1] + before[:, None] * slopes[mid])
    first, last = begins, begins + counts - 1
    for ends, way in ((first, 1), (last, -1)):
        _add_end_rows(bands, right, counts, ends, way, steps, slopes)
    speeds = solve_banded((1, 1), bands, right, check_finite=False)
    pieces = []
    for begin, count in zip(begins.tolist(), counts.tolist(), strict=True):
        here = slice(begin, begin + count - 1)
        step, slope = steps[here, None], slopes[here]
        speed, next_speed = speeds[here], speeds[begin + 1 : begin + count]
        bend = (speed + next_speed - 2.0 * slope) / step
        pieces.append(np.stack((bend / step, (slope - speed) / step - bend, speed, places[here])))
    return pieces


def _add_end_rows(
    bands: Array,
    right: Array,
    counts: Array,
    ends: Array,
    way: int,
    steps: Array,
    slopes: Array,
) -> None:
    """Add the equations for the slopes at the first or at the last places of all splines.

    Parameters
    ----------
    bands, right : (3, m) and (m, d) float
        The system, which is changed.
    counts, ends : (r,) int
        Places of each spline, and the one at its end.
    way : {1, -1}
        From the end into the spline.
    steps, slopes : (m,) and (m, d) float
        Of the piece after each place.
    """
    beside = 0 if way > 0 else 2
    outer = ends if way > 0 else ends - 1
    long, three, two = counts >= 4, counts == 3, counts == 2
    end, piece = ends[long], outer[long]
    inward = steps[piece + way]
    both = steps[piece] + inward
    bands[1, end], bands[beside, end + way] = inward, both
    one = (steps[piece] + 2.0 * both) * inward
    other = steps[piece, None] ** 2 * slopes[piece + way]
    right[end] = (one[:, None] * slopes[piece] + other) / both[:, None]
    bands[1, ends[three]] = bands[beside, ends[three] + way] = 1.0
    right[ends[three]] = 2.0 * slopes[outer[three]]
    bands[1, ends[two]] = 1.0
    right[ends[two]] = slopes[outer[two]]
