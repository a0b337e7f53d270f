"""Outlines over creases: smooth up to a crease, and from there on, with one place on it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto_product.details.ring import Ring, spline_of_stretch

NEAR: Final = 0.012
"""Share of the length of an outline beside a crease within which its course is taken from farther
away: a curve through places on both sides is bent alike on both."""

MILD: Final = np.radians(42.0)
"""Turn up to which what seems to be a corner beside a crease is a step of a curve."""

BESIDE: Final = 0.06
"""How near to a crease that is, as share of the length of the outline."""

SAME: Final = 1e-5
"""The same, within which a corner is where the outline crosses the crease."""

PLACES: Final = 64
"""Places of a stretch through which it goes."""


def folded(ring: Ring, creases: Sequence[float]) -> Ring:
    """Return a closed outline with a joint of stretches at every crease that it crosses.

    Parameters
    ----------
    ring : Ring
        Closed.
    creases : sequence of float
        Parameters at which it crosses creases, in order.
    """
    along = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(ring.polyline, axis=0), axis=1)))
    length = float(along[-1])
    near = NEAR * length
    places = np.interp(creases, ring.polyline_at, along)
    corners = []
    for number, turn in enumerate(ring.turns):
        corner = float(np.interp(number, ring.polyline_at, along))
        room = SAME if abs(turn) > MILD else BESIDE
        if turn and _gaps(places, corner, length).min() > room * length:
            corners.append(corner)
    marks = sorted([(float(p), True) for p in places] + [(c, False) for c in corners])
    rows: list[tuple[Spline, bool]] = []
    for (start, fold), (end, other) in zip(marks, [*marks[1:], marks[0]], strict=True):
        end += length if end <= start else 0.0
        inner = np.linspace(start, end, PLACES + 1)
        low, high = (start + near if fold else start), (end - near if other else end)
        inner = np.concatenate(([start], inner[(inner > low) & (inner < high)], [end]))
        at = np.interp(inner % length, along, ring.polyline_at)
        points = ring.value(np.where(at >= ring.end, 0.0, at))
        points[0], points[-1] = (_at(ring, along, p % length) for p in (start, end))
        rows.append((spline_of_stretch(points), fold))
    longest = max(range(len(rows)), key=lambda k: len(rows[k][0].control_points))
    spline, fold = rows[longest]
    first, second = spline.split(0.5 * sum(spline.range))
    turned = [*rows[longest + 1 :], *rows[:longest]]
    stretches = (second, *(one for one, _ in turned), first)
    folds = [False, *(one for _, one in turned), fold]
    return Ring(stretches, True, frozenset(k for k, one in enumerate(folds) if one))


def _at(ring: Ring, along: Array, place: float) -> Array:
    at = float(np.interp(place, along, ring.polyline_at))
    return np.asarray(ring.value(np.array([0.0 if at >= ring.end else at]))[0])


def _gaps(places: Array, at: float, length: float) -> Array:
    """Return how far places of a round are from one, either way, mm."""
    gaps = np.abs(places - at)
    return np.asarray(np.minimum(gaps, length - gaps))
