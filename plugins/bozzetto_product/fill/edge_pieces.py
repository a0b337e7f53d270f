"""Edges cut into pieces of degree five, once for all loops that share them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Curve, Spline
from bozzetto.plugin import remembered
from bozzetto_product.fill.quintic import DEGREE

NO_SPAN: Final = 1e-9
"""Share of a piece's range below which two knots are one."""

NEAR_KNOT: Final = 0.2
"""Share of a piece's length within which a cut goes to a knot: a cut beside one would leave a
sliver of a span."""

SAMPLES: Final = 65
"""Places at which lengths and curvatures along an edge are measured."""


@dataclass(frozen=True, eq=False)
class EdgePiece:
    """A part of an edge that is a side of one patch.

    Parameters
    ----------
    curve : Curve
        Of degree five over its part of the range of the opened edge; exact. Every surface that
        ends here has these very control points.
    length : float
        mm.
    """

    curve: Curve
    length: float


@remembered(limit=4000)
def opened(spline: Spline) -> Spline:
    """Return the curve of an edge with clamped ends; a closed one is opened where it bends most."""
    if not spline.closed:
        return spline
    begin, end = spline.range
    at = np.linspace(begin, end, 4 * SAMPLES)[:-1]
    first, second = spline.derivative(at), spline.derivative(at, 2)
    speed = np.maximum(np.linalg.norm(first, axis=1), 1e-300)
    bend = np.linalg.norm(cross_product(first, second), axis=1) / speed**3
    sharpest = np.flatnonzero(bend >= (1.0 - 1e-9) * bend.max())[0]
    return spline.split(float(at[sharpest]))[0]


@remembered(limit=4000)
def pieces_of(spline: Spline, count: int) -> tuple[EdgePiece, ...]:
    """Return an edge as pieces of about equal length, in its own sense.

    Parameters
    ----------
    spline : Spline
        That of the edge.
    count : int
        How many.
    """
    whole = opened(spline)
    begin, end = whole.range
    at = np.linspace(begin, end, SAMPLES)
    steps = np.linalg.norm(np.diff(whole.value(at), axis=0), axis=1)
    arc = np.concatenate(((0.0,), np.cumsum(steps)))
    total = float(arc[-1])
    shares = arc / total if total > 0 else np.linspace(0.0, 1.0, SAMPLES)
    inner = np.unique(whole.knots[(whole.knots > begin) & (whole.knots < end)])
    inner_shares = np.interp(inner, at, shares)
    cuts = []
    for number in range(1, count):
        share = number / count
        cut = float(np.interp(share, shares, at))
        if len(inner):
            nearest = int(np.argmin(np.abs(inner_shares - share)))
            if abs(inner_shares[nearest] - share) < NEAR_KNOT / count:
                cut = float(inner[nearest])
        cuts.append(cut)
    return tuple(
        EdgePiece(curve := raised(part), curve_length(curve)) for part in whole.split(*cuts)
    )


@remembered(limit=4000)
def halved(spline: Spline, pieces: tuple[EdgePiece, ...]) -> tuple[EdgePiece, ...]:
    """Return the pieces of an edge cut in two each, of about equal length.

    Parameters
    ----------
    spline : Spline
        That of the edge.
    pieces : tuple of EdgePiece
        Of `pieces_of`; where they end there are ends still.
    """
    cuts = []
    for piece in pieces:
        begin, end = piece.curve.range
        at = np.linspace(begin, end, SAMPLES)
        steps = np.linalg.norm(np.diff(piece.curve.value(at), axis=0), axis=1)
        arc = np.concatenate(((0.0,), np.cumsum(steps)))
        middle = float(np.interp(0.5 * arc[-1], arc, at)) if arc[-1] > 0 else 0.5 * (begin + end)
        inner = np.unique(piece.curve.knots)[1:-1]
        near = np.abs(inner - middle) < 0.5 * NEAR_KNOT * (end - begin)
        if near.any():
            middle = float(inner[np.argmin(np.abs(inner - middle))])
        cuts += [begin, middle]
    parts = opened(spline).split(*cuts[1:])
    return tuple(EdgePiece(curve := raised(part), curve_length(curve)) for part in parts)


def raised(spline: Spline) -> Curve:
    """Return a clamped cubic as the same curve of degree five; its ends are the very numbers."""
    from scipy.interpolate import make_interp_spline

    begin, end = spline.range
    places, counts = np.unique(spline.knots, return_counts=True)
    apart = np.append(True, np.diff(places) > NO_SPAN * (end - begin))
    inner = np.minimum(counts[apart][1:-1], 3)
    places = places[apart]
    places[-1] = end
    knots = np.repeat(places, np.concatenate(([6], inner + 2, [6])))
    count = len(knots) - DEGREE - 1
    sites = knots[np.arange(count)[:, None] + np.arange(1, DEGREE + 1)].mean(axis=1)
    sites = np.clip(sites, begin, end)
    points = np.asarray(make_interp_spline(sites, spline.value(sites), DEGREE, t=knots).c)
    points[[0, -1]] = spline.control_points[[0, -1]]
    return Curve(DEGREE, knots, points)


def curve_length(curve: Curve) -> float:
    """Return the length of a chain of places on a curve, mm."""
    at = np.linspace(*curve.range, SAMPLES)
    return float(np.linalg.norm(np.diff(curve.value(at), axis=0), axis=1).sum())


def run_from(piece: EdgePiece, forward: bool) -> tuple[Array, Array]:
    """Return knots over 0 … 1 and control points of a piece, run from one of its ends."""
    begin, end = piece.curve.range
    knots = (piece.curve.knots - begin) / (end - begin)
    if forward:
        return knots, piece.curve.control_points
    return 1.0 - knots[::-1], piece.curve.control_points[::-1]
