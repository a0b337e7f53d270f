"""Sides of a loop as two halves each, which run from a corner of a patch to the cut between."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.plugin import cached_property
from bozzetto_product.fill.edge_pieces import EdgePiece, run_from
from bozzetto_product.fill.normal_field import NormalField
from bozzetto_product.fill.patch_space import SIDE_NODES, side_nodes
from bozzetto_product.fill.quintic import DEGREE, POINTS, bernstein, gauss, spline_fit

SPEED_RATIO: Final = 3.0
"""Most that the speeds of pieces of a half differ from those by length, to meet evenly."""

IDLE: Final = 1e-10
"""How far a control point may be from where it makes no corner, as share of the curve's size."""

FIT_NODES: Final = 24
"""Places at which a half is fitted by one polynomial."""


@dataclass(frozen=True, eq=False)
class SidePiece:
    """A piece of an edge as a side of a loop runs it.

    Parameters
    ----------
    half_edge : int
        Which of the loop's.
    piece : EdgePiece
    forward : bool
        Whether the loop runs it in the edge's sense.
    field : NormalField, optional
        Unit normals of the surface by the edge's parameter; None where the edge is a crease.
    """

    half_edge: int
    piece: EdgePiece
    forward: bool
    field: NormalField | None = None

    def ends(self) -> tuple[Array, Array]:
        """Return the derivatives at the start and the end, over 0 … 1, as the loop runs."""
        knots, points = run_from(self.piece, self.forward)
        first = DEGREE * (points[1] - points[0]) / (knots[POINTS] - knots[1])
        last = DEGREE * (points[-1] - points[-2]) / (knots[-2] - knots[-1 - POINTS])
        return first, last


@dataclass(frozen=True, eq=False)
class HalfSide:
    """Half of a side, from a corner of a patch to the middle of the side.

    Parameters
    ----------
    pieces : tuple of SidePiece
        From the corner on.
    onward : bool
        Whether the loop runs it from the corner to the middle.
    breaks : (k + 1,) float
        Parameters 0 … 1 of the ends of the pieces.
    knots : (m + 6,) float
        Over 0 … 1.
    points : (m, 3) float
        Control points, those of the pieces to the last bit.
    """

    pieces: tuple[SidePiece, ...]
    onward: bool
    breaks: Array
    knots: Array
    points: Array

    @classmethod
    def of(cls, pieces: Sequence[SidePiece], onward: bool) -> HalfSide:
        """Return pieces as one curve with even speed over its joints where that can be."""
        weights = [1.0]
        for one, two in itertools.pairwise(pieces):
            ends = (one.ends(), two.ends())
            leave, enter = (ends[0][1], ends[1][0]) if onward else (ends[0][0], ends[1][1])
            speeds = float(np.linalg.norm(enter)), max(float(np.linalg.norm(leave)), 1e-300)
            by_length = two.piece.length / max(one.piece.length, 1e-300)
            ratio = np.clip(speeds[0] / speeds[1], by_length / SPEED_RATIO, by_length * SPEED_RATIO)
            weights.append(weights[-1] * float(ratio))
        breaks = np.concatenate(((0.0,), np.cumsum(weights) / np.sum(weights)))
        breaks[-1] = 1.0
        knots, points = [], []
        for number, piece in enumerate(pieces):
            own, controls = run_from(piece.piece, piece.forward == onward)
            spread = breaks[number] + (breaks[number + 1] - breaks[number]) * own
            spread[-POINTS:] = breaks[number + 1]
            knots.append(spread[POINTS if number else 0 : len(spread) - 1])
            points.append(controls[1 if number else 0 :])
        knots.append(np.ones(1))
        return cls(tuple(pieces), onward, breaks, np.concatenate(knots), np.concatenate(points))

    @cached_property
    def length(self) -> float:
        """Length of the curve, mm."""
        return sum(piece.piece.length for piece in self.pieces)

    def value(self, at: Array, order: int = 0) -> Array:
        """Return places, or derivatives by the parameter, (n, 3)."""
        from scipy.interpolate import BSpline

        return np.asarray(BSpline.construct_fast(self.knots, self.points, DEGREE)(at, order))

    def normals(self, at: Array) -> Array | None:
        """Return unit normals of the surface, (n, 3); None where a piece is a crease."""
        if any(piece.field is None for piece in self.pieces):
            return None
        number = np.clip(np.searchsorted(self.breaks, at, "right") - 1, 0, len(self.pieces) - 1)
        made = np.empty((len(at), 3))
        for k, piece in enumerate(self.pieces):
            own = number == k
            if piece.field is None or not own.any():
                continue
            share = (at[own] - self.breaks[k]) / (self.breaks[k + 1] - self.breaks[k])
            if piece.forward != self.onward:
                share = 1.0 - share
            begin, end = piece.piece.curve.range
            made[own] = piece.field.value(begin + share * (end - begin))
        return made

    @cached_property
    def fit_knots(self) -> Array:
        """The knots without those at which the curve might have a corner and has none, (k + 6,).

        What is added to a surface along the half is fitted over these: else it would have a corner
        there, if only by the rounding of a fit, where CAD cuts a surface or complains.
        """
        p, t = self.points, self.knots
        _, first, counts = np.unique(t, return_index=True, return_counts=True)
        at = first[1:-1][counts[1:-1] == DEGREE]
        if not len(at):
            return t
        leave, enter = t[at] - t[at - 1], t[at + DEGREE] - t[at]
        share = (leave / (leave + enter))[:, None]
        idle = (1.0 - share) * p[at - 2] + share * p[at]
        off = np.abs(p[at - 1] - idle).max(axis=1)
        return np.delete(t, at[off <= IDLE * float(np.linalg.norm(np.ptp(p, axis=0)))])

    @cached_property
    def _known_normals(self) -> Array | None:
        return self.normals(np.concatenate((side_nodes()[0], spline_fit(self.fit_knots)[0])))

    @property
    def held_normals(self) -> Array | None:
        """Unit normals at the Gauss nodes of `side_nodes`, (11, 3); None at a crease."""
        return None if self._known_normals is None else self._known_normals[:SIDE_NODES]

    @property
    def fitted_normals(self) -> Array | None:
        """Unit normals at the places of `spline_fit`, (n, 3); None at a crease."""
        return None if self._known_normals is None else self._known_normals[SIDE_NODES:]

    @cached_property
    def end_slopes(self) -> tuple[Array, Array]:
        """The derivatives at the corner and at the middle; where one is nought, nearly."""
        p, t = self.points, self.knots
        first = DEGREE * (p[1] - p[0]) / (t[POINTS] - t[1])
        last = DEGREE * (p[-1] - p[-2]) / (t[-2] - t[-1 - POINTS])
        tiny = 1e-9 * float(np.linalg.norm(np.ptp(p, axis=0)))
        if float(np.linalg.norm(first)) <= tiny:
            first = self.value(np.array([0.02]), 1)[0]
        if float(np.linalg.norm(last)) <= tiny:
            last = self.value(np.array([0.98]), 1)[0]
        return first, last

    @cached_property
    def is_polynomial(self) -> bool:
        """Whether the half is one polynomial."""
        return len(self.points) == POINTS

    def polynomial(self, slope: Array | None = None) -> Array:
        """Return the polynomial nearest to the half, with the same ends and end slopes, (6, 3).

        Parameters
        ----------
        slope : (3,) float, optional
            The derivative at the middle instead of its own.
        """
        first, last = self.points[[0, -1]]
        if self.is_polynomial and slope is None:
            return self.points
        leave = DEGREE * (self.points[1] - first) / (self.knots[POINTS] - self.knots[1])
        if slope is None:
            slope = DEGREE * (last - self.points[-2]) / (self.knots[-2] - self.knots[-1 - POINTS])
        made = np.empty((POINTS, 3))
        made[0], made[-1] = first, last
        made[1], made[-2] = first + leave / DEGREE, last - slope / DEGREE
        outer = [0, 1, DEGREE - 1, DEGREE]
        at, values, inverse = _fit_of_middle()
        made[2:4] = inverse @ (self.value(at) - values[:, outer] @ made[outer])
        return made


@cache
def _fit_of_middle() -> tuple[Array, Array, Array]:
    """Return places, Bernstein polynomials there, and what fits the two in the middle, (2, 24)."""
    at, weights = gauss(FIT_NODES)
    values, size = bernstein(at), np.sqrt(weights)
    inverse = np.asarray(np.linalg.pinv(size[:, None] * values[:, 2:4]))
    return at, values, inverse * size


@dataclass(frozen=True, eq=False)
class Side:
    """A side of a loop: from corner to corner of the domain.

    Parameters
    ----------
    halves : (HalfSide, HalfSide)
        From the corner before it to the middle, and from the corner after it to the middle.
    bend : float
        How far it turns outward at the middle, radians: a concave corner; 0 where smooth.
    """

    halves: tuple[HalfSide, HalfSide]
    bend: float = 0.0

    @cached_property
    def polynomials(self) -> tuple[Array, Array]:
        """The polynomials nearest to both halves; smooth over the middle unless it is bent."""
        one, two = self.halves
        if self.bend:
            return one.polynomial(), two.polynomial()
        before, after = one.end_slopes[1], -two.end_slopes[1]
        first, second = self.shares
        common = 0.5 * (before / first + after / second)
        return one.polynomial(first * common), two.polynomial(-second * common)

    @cached_property
    def shares(self) -> tuple[float, float]:
        """Shares of the side in the domain: as the speeds at the middle."""
        one, two = self.halves
        if self.bend:
            return one.length, two.length
        speeds = [float(np.linalg.norm(half.end_slopes[1])) for half in self.halves]
        whole = sum(speeds)
        share = float(np.clip(speeds[0] / whole, 0.15, 0.85)) if whole > 0 else 0.5
        return share, 1.0 - share

    @property
    def lengths(self) -> tuple[float, float]:
        """Lengths of both halves in the domain, mm."""
        whole = self.halves[0].length + self.halves[1].length
        first, second = self.shares
        return whole * first / (first + second), whole * second / (first + second)
