"""Curves as polylines that look smooth from everywhere: no more points than that needs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.errors import UserError

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags

FLATNESS: Final = 0.25
"""Distance, px, between a curve and its polyline that nobody sees; over the pixels per mm of
a view it is a tolerance for `flattened`."""

MOST_HALVINGS: Final = 12
"""Limit of halvings of a piece: beyond it a curve is thousands of sheets wide."""


def flattened(pieces: ArrayLike, tolerance: float) -> tuple[Array, Array]:
    """Turn cubic Bezier pieces into a polyline that is flat enough.

    A piece is halved (de Casteljau) until its inner control points lie within the tolerance
    of its chord: a cubic lies in the hull of its four points, so the bound holds exactly,
    and no parallel view of the curve shows it broader.

    Parameters
    ----------
    pieces : (k, 4, 3) array_like
        Control points of pieces that follow one another, mm, as `Spline.beziers` gives
        them; ``k >= 1``.
    tolerance : float
        mm, above 0.

    Returns
    -------
    points : (n, 3) float
        On the curve, mm; both ends of every piece are among them.
    parameters : (n,) float
        Number of the piece plus the parameter 0 … 1 within it; increasing.

    Raises
    ------
    UserError
        If a control point is not finite or there is none, or the tolerance is not above 0.
    """
    left = np.array(pieces, float).reshape(-1, 4, 3)
    count = float(len(left))
    if not len(left) or not np.isfinite(left).all():
        raise UserError("A curve needs control points with finite coordinates.")
    if not tolerance > 0:
        raise UserError("The flatness of a curve must be above zero.")
    begin, width = np.arange(len(left), dtype=float), 1.0
    ready_pieces, ready_begin = [], []
    for _ in range(MOST_HALVINGS):
        flat = _is_flat(left, tolerance)
        ready_pieces.append(left[flat])
        ready_begin.append(begin[flat])
        left, begin = left[~flat], begin[~flat]
        if not len(left):
            break
        width *= 0.5
        left = np.concatenate(_halves(left))
        begin = np.concatenate((begin, begin + width))
    starts = np.concatenate((*ready_begin, begin))
    order = np.argsort(starts)
    control = np.concatenate((*ready_pieces, left))[order]
    points = np.vstack((control[:, 0], control[-1:, 3]))
    return points, np.append(starts[order], count)


def _halves(control: Array) -> tuple[Array, Array]:
    """Return both halves of each piece (de Casteljau)."""
    a, b, c, d = np.moveaxis(control, 1, 0)
    ab, bc, cd = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + d)
    abc, bcd = 0.5 * (ab + bc), 0.5 * (bc + cd)
    middle = 0.5 * (abc + bcd)
    return np.stack((a, ab, abc, middle), axis=1), np.stack((middle, bcd, cd, d), axis=1)


def _is_flat(control: Array, tolerance: float) -> Flags:
    """Whether each piece is within the tolerance of its chord."""
    a, b, c, d = np.moveaxis(control, 1, 0)
    chord = d - a
    square = np.einsum("nk,nk->n", chord, chord)
    square = np.where(square > 0, square, 1.0)
    flat = np.ones(len(control), bool)
    for inner in (b, c):
        share = np.clip(np.einsum("nk,nk->n", inner - a, chord) / square, 0.0, 1.0)
        aside = np.linalg.norm(inner - a - share[:, None] * chord, axis=1)
        flat &= aside <= tolerance
    return flat
