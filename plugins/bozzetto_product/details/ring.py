"""Outlines in the plane of a chart: smooth stretches that follow one another."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.geometry import Spline
from bozzetto.plugin import cached_property

SMOOTH_TURN: Final = np.radians(4.0)
"""Turn between stretches below which there is no corner."""

SHARPEST: Final = np.radians(165.0)
"""Turn at a corner beyond which its bisector is not followed."""

PER_STRETCH: Final = 48
"""Places of a stretch for its polyline, at least."""


@dataclass(frozen=True, eq=False)
class Ring:
    """A curve in a chart; closed, the region lies on its left.

    Parameters
    ----------
    stretches : tuple of Spline
        In the plane, mm, head to tail. The parameter t counts them: 1.5 is half-way along the
        second.
    closed : bool
        Whether the last stretch ends where the first begins.
    folds : frozenset of int
        Stretches that begin at a crease: a turn there is none on the surface.
    """

    stretches: tuple[Spline, ...]
    closed: bool = True
    folds: frozenset[int] = frozenset()

    @property
    def end(self) -> float:
        """The last parameter."""
        return float(len(self.stretches))

    def value(self, at: Array) -> Array:
        """Return places, (n, 2)."""
        return self._of(at, 0)

    def tangents(self, at: Array) -> Array:
        """Return derivatives by t, (n, 2); at joints those of the stretch that follows."""
        return self._of(at, 1)

    def _of(self, at: Array, order: int) -> Array:
        at = np.asarray(at, float)
        which = np.clip(at.astype(int), 0, len(self.stretches) - 1)
        made = np.empty((len(at), 2))
        for number in np.unique(which).tolist():
            rows = which == number
            spline = self.stretches[number]
            begin, end = spline.range
            t = begin + (at[rows] - number) * (end - begin)
            found = spline.derivative(t, 1) * (end - begin) if order else spline.value(t)
            made[rows] = found
        return made

    def ends_of(self, number: int) -> tuple[Array, Array]:
        """Return unit tangents at the start and the end of a stretch, (2,) each."""
        spline = self.stretches[number]
        both = spline.derivative(np.array(spline.range), 1)
        both = both / np.linalg.norm(both, axis=1, keepdims=True)
        return both[0], both[1]

    @cached_property
    def turns(self) -> tuple[float, ...]:
        """The turn at the start of each stretch, radians, left positive; 0 where it is smooth."""
        turns = []
        for number in range(len(self.stretches)):
            if number in self.folds or (number == 0 and not self.closed):
                turns.append(0.0)
                continue
            (x, y), (p, q) = self.ends_of(number - 1)[1], self.ends_of(number)[0]
            turn = float(np.arctan2(x * q - y * p, x * p + y * q))
            turns.append(turn if abs(turn) > SMOOTH_TURN else 0.0)
        return tuple(turns)

    @cached_property
    def polyline_at(self) -> Array:
        """Parameters of a polyline that is near the curve, (n,)."""
        rows = []
        for number, spline in enumerate(self.stretches):
            count = max(PER_STRETCH, 4 * (len(spline.control_points) - 3))
            rows.append(number + np.arange(count) / count)
        return np.append(np.concatenate(rows), self.end)

    @cached_property
    def polyline(self) -> Array:
        """Places at `polyline_at`, (n, 2); the last is the first where it is closed."""
        return self.value(self.polyline_at)

    def inset_by(self, at: Array, reach: Array | float) -> tuple[Array, Array]:
        """Return how much to go left, and on along the curve, to be inside by a distance, (n,).

        At a corner the way is that of its bisector; from there the part along the curve fades
        evenly to the next one, so that straight stretches stay straight and at their distance.

        Parameters
        ----------
        at : (n,) float
            Parameters t.
        reach : (n,) float or float
            mm.
        """
        at = np.asarray(at, float)
        which = np.clip(at.astype(int), 0, len(self.stretches) - 1)
        share = at - which
        after = np.append(self.turns[1:], self.turns[0] if self.closed else 0.0)
        first = np.tan(0.5 * np.clip(np.array(self.turns), -SHARPEST, SHARPEST))
        last = -np.tan(0.5 * np.clip(after, -SHARPEST, SHARPEST))
        along = (1.0 - share) * first[which] + share * last[which]
        left = np.broadcast_to(np.asarray(reach, float), at.shape)
        return left, along * left

    def drawn_out(self, share: float) -> Ring:
        """Return an open ring with a straight stretch before and behind it.

        Parameters
        ----------
        share : float
            Length of each, as share of the ring's own.
        """
        reach = share * float(np.linalg.norm(np.diff(self.polyline, axis=0), axis=1).sum())
        first, last = self.polyline[0], self.polyline[-1]
        before = first - reach * self.ends_of(0)[0]
        behind = last + reach * self.ends_of(len(self.stretches) - 1)[1]
        return Ring(
            (
                spline_of_stretch(np.stack((before, first))),
                *self.stretches,
                spline_of_stretch(np.stack((last, behind))),
            ),
            closed=False,
        )

    def moved(self, step: Array) -> Ring:
        """Return the ring moved in the plane."""
        rows = [Spline(s.knots, s.control_points + step, s.closed) for s in self.stretches]
        return Ring(tuple(rows), self.closed, self.folds)

    def reversed(self) -> Ring:
        """Return the ring run the other way."""
        count = len(self.stretches)
        folds = frozenset((count - number) % count for number in self.folds)
        return Ring(tuple(s.reversed() for s in reversed(self.stretches)), self.closed, folds)


def ring_through(points: Array, corners: Flags, *, closed: bool = True) -> Ring:
    """Return the ring through points: smooth from corner to corner.

    Parameters
    ----------
    points : (n, 2) float
        mm, none twice in a row; of a closed ring the first is not repeated.
    corners : (n,) bool
        Which of them are corners.
    closed : bool
        Whether the last is followed by the first.
    """
    if not closed:
        inner = [k for k in np.flatnonzero(corners).tolist() if 0 < k < len(points) - 1]
        breaks = [0, *inner, len(points) - 1]
        return Ring(tuple(_rows(points, breaks)), closed=False)
    if not corners.any():
        return Ring(_smooth_ring(points))
    first = int(np.flatnonzero(corners)[0])
    rolled = np.roll(points, -first, axis=0)
    rolled = np.vstack((rolled, rolled[:1]))
    marks = np.flatnonzero(np.roll(corners, -first)).tolist()
    return Ring(tuple(_rows(rolled, [*marks, len(points)])))


def _rows(points: Array, breaks: Sequence[int]) -> list[Spline]:
    return [spline_of_stretch(points[a : b + 1]) for a, b in itertools.pairwise(breaks)]


def spline_of_stretch(points: Array) -> Spline:
    """Return the open spline through points, (n, 2)."""
    from scipy.interpolate import make_interp_spline

    if len(points) < 4:
        chord = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
        t = np.linspace(0.0, chord[-1], 4)
        if len(points) == 2:
            points = np.column_stack([np.interp(t, chord, points[:, k]) for k in range(2)])
        else:
            points = make_interp_spline(chord, points, k=2)(t)
    chord = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    fit = make_interp_spline(chord / chord[-1], points, k=3)
    return Spline(fit.t, fit.c)


def _smooth_ring(points: Array) -> tuple[Spline, ...]:
    """Return one smooth round as two stretches, so that no edge meets itself."""
    from scipy.interpolate import make_interp_spline

    whole = np.vstack((points, points[:1]))
    chord = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(whole, axis=0), axis=1))))
    fit = make_interp_spline(chord / chord[-1], whole, k=3, bc_type="periodic")
    first, second = Spline(fit.t, fit.c).split(float(chord[len(points) // 2] / chord[-1]))
    return first, second
