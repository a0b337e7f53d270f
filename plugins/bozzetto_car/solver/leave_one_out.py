"""The distance of each mark from the place where the other marks expect it.

Camera and shape give way to a wrong mark, so that its own residual may be small. The place that
the other marks and the template expect tells more. For a least squares problem that is linear
nearby it follows from the solve with the mark (Cook & Weisberg 1982, section 2.2): with H the
mark's part of the hat matrix and r its residual, the residual without the mark is (1 − H)⁻¹ r.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Marks compared with the places that the rest of the data expect.

    Attributes
    ----------
    missed : (k,) float
        Distance between a mark and the place where its node is expected without it.
    surprise : (k,) float
        This distance in standard deviations of the expectation and of the hand: more than four
        or five do not happen by chance.
    """

    missed: Array
    surprise: Array


def leave_one_out(rows: Array, missed: Array, weights: Array, covariance: Array) -> LeftOut:
    """Compare each mark with the place that all others expect.

    Parameters
    ----------
    rows : (2 k, p) float
        Derivatives of what is missed by all unknowns, in standard deviations of the hand.
    missed : (k, 2) float
        What each mark is missed by, in standard deviations of the hand.
    weights : (k,) float
        Weights of the marks in the solve.
    covariance : (p, p) float
        Covariance of the unknowns, with all marks.

    Returns
    -------
    LeftOut
        In standard deviations of the hand.
    """
    pairs = rows.reshape(len(missed), 2, -1)
    spread = pairs @ covariance @ np.swapaxes(pairs, 1, 2)
    left = np.eye(2) - weights[:, None, None] * spread
    expected = np.linalg.solve(left, missed[:, :, None])[:, :, 0]
    # Covariance of the residual: that of the hand, and that of the place without the mark.
    doubt = np.eye(2) + np.linalg.solve(left, spread)
    scaled = np.linalg.solve(doubt, expected[:, :, None])[:, :, 0]
    squares = np.maximum((expected * scaled).sum(axis=1), 0.0)
    return LeftOut(np.linalg.norm(expected, axis=1), np.sqrt(squares))
