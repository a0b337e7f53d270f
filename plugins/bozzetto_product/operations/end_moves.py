"""A whole curve moved so that its ends reach given places.

Kara & Shimada, book chapter, section 13.2.2: ends that nearly meet are joined by translations,
rotations and scalings of whole curves, which keep their shape. Of all rotations about the new
chord the one is taken that moves the curve least. Where that would surprise, for it scales much,
turns an end much or the curve nearly closes, the curve is bent instead.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Spline
from bozzetto_product.projection.spline_basis import bent, chord_length

SCALES: Final = (0.9, 1.1)
"""Least and greatest scale of a similarity."""

OPEN: Final = 0.5
"""Least chord over length of a curve that is moved by a similarity."""

TURN: Final = 5.0
"""Greatest turn of the direction of an end by a similarity, degrees."""


STRAIGHT: Final = 1e-9
"""Distance of a curve from its chord, as a share of it, below which it is straight."""


def moved_to_ends(spline: Spline, start: ArrayLike, end: ArrayLike) -> Spline:
    """Return a curve that begins and ends in the very numbers given.

    Parameters
    ----------
    spline : Spline
        Open, with clamped ends, mm.
    start, end : (3,) array_like
        Where it is to begin and to end.

    Returns
    -------
    Spline
        Over the same knots; the same object where it begins and ends there already.
    """
    first, last = np.asarray(start, float), np.asarray(end, float)
    points = spline.control_points
    if (first == points[0]).all() and (last == points[-1]).all():
        return spline
    shift = first - points[0]
    if (shift == last - points[-1]).all():
        moved = points + shift
        moved[0], moved[-1] = first, last
        return Spline(spline.knots, moved)
    alike = similar(points, first, last)
    if alike is None or not _is_gentle(spline, alike):
        return bent(spline, first, last)
    return Spline(spline.knots, alike)


def similar(points: Array, start: Array, end: Array) -> Array | None:
    """Return points moved by the similarity that takes the ends to places and rolls least.

    Parameters
    ----------
    points : (n, 3) float
        mm.
    start, end : (3,) float
        Where the first and the last one go, exactly.

    Returns
    -------
    (n, 3) float or None
        None where a chord has no length, or the chord turns right round.
    """
    chord, wanted = points[-1] - points[0], end - start
    length, reach = float(np.linalg.norm(chord)), float(np.linalg.norm(wanted))
    if not length > 0.0 or not reach > 0.0:
        return None
    old, new = chord / length, wanted / reach
    cosine = float(old @ new)
    if cosine <= -1.0 + 1e-9:
        return None
    turned = reach / length * _led_over(points - points[0], cross_product(old, new), cosine)
    before = points - start
    across = turned - np.outer(turned @ new, new)
    goal = before - np.outer(before @ new, new)
    sine, same = float((cross_product(across, goal) @ new).sum()), float((across * goal).sum())
    size = float(np.hypot(sine, same))
    # A straight curve has no roll.
    if size > STRAIGHT**2 * reach * reach:
        turned = _rolled(turned, new, sine / size, same / size)
    made = turned + start
    made[0], made[-1] = start, end
    return np.asarray(made)


def _led_over(vectors: Array, cross: Array, cosine: float) -> Array:
    """Rotate vectors by the smallest turn between two unit vectors: their products."""
    along = np.outer(vectors @ cross, cross) / (1.0 + cosine)
    return np.asarray(cosine * vectors + cross_product(cross, vectors) + along)


def _rolled(vectors: Array, axis: Array, sine: float, cosine: float) -> Array:
    """Rotate vectors about a unit axis."""
    along = np.outer(vectors @ axis, axis)
    return np.asarray(along + cosine * (vectors - along) + sine * cross_product(axis, vectors))


def _is_gentle(spline: Spline, moved: Array) -> bool:
    """Whether a similarity changes a curve so little that it keeps its look."""
    points = spline.control_points
    chord = float(np.linalg.norm(points[-1] - points[0]))
    scale = float(np.linalg.norm(moved[-1] - moved[0])) / chord
    turns = [
        _angle(one[second] - one[first], other[second] - other[first])
        for one, other in ((points, moved),)
        for first, second in ((0, 1), (-2, -1))
    ]
    return bool(
        SCALES[0] <= scale <= SCALES[1]
        and chord > OPEN * chord_length(spline)
        and max(turns) < TURN
    )


def _angle(one: Array, other: Array) -> float:
    """Return the angle between two vectors, degrees; 0 where one has no direction."""
    return float(np.degrees(np.arctan2(np.linalg.norm(cross_product(one, other)), one @ other)))
