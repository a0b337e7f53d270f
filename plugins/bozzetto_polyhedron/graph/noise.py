"""How far the corners of a drawing are from where they were meant, estimated from itself."""

from __future__ import annotations

from math import sqrt
from typing import Final

from bozzetto_polyhedron.graph.draft import Draft
from bozzetto_polyhedron.graph.likelihood import strain_of

PRIOR: Final = 6.0
"""Degrees of freedom for which the assumed spread counts before anything is measured."""

STEADY: Final = 0.004
"""Least spread that is assumed of a hand, shares of the diagonal: lines may meet in one point and
still run where they were not meant, so corners that fit well say little of a few lines."""

LEAST: Final = 5e-4
"""Share of the diagonal below which no hand draws."""


def corner_noise(draft: Draft) -> float:
    """Return the root mean square distance of corners from where they were meant.

    The covariance of a corner is the inverse of the information of its ends. It is
    scaled by what the ends really strain: d ends leave 2 d - 2 degrees of freedom.

    Parameters
    ----------
    draft : Draft
        Lines and corners, in shares of the diagonal.
    """
    if not draft.sums:
        return LEAST
    assumed = max(1.0, STEADY / draft.fits.spread.across)
    strain, freedom, variance = PRIOR * assumed**2, PRIOR, 0.0
    for corner, sums in draft.sums.items():
        strain += strain_of(sums)
        freedom += 2.0 * draft.degrees[corner] - 2.0
        xx, xy, yy = sums[:3]
        variance += (xx + yy) / max(xx * yy - xy * xy, 1e-12)
    return max(LEAST, sqrt(variance / len(draft.sums) * strain / freedom))
