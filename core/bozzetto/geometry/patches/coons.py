"""Patches from their edges: bicubically blended Coons patches as exact bicubic Bézier patches.

A Coons patch (Coons 1967, "Surfaces for computer-aided design of space forms"; Farin, *Curves and
Surfaces for CAGD*, 5th ed., section 22) interpolates four boundary curves and the derivatives
across them. Where the curves are cubics, the derivatives across are blended from those in the
corners by the same Hermite polynomials, and the twists in the corners are 0, all of its parts
are Ferguson patches of the same corners, and so is their sum: sixteen control points say the
same as Coons' formula, without any loss.

Edges are cubic Bézier curves, (m, 4, 3) mm. A patch names its four *sides* round it: a number e
says edge e from its start to its end, ``~e`` (that is −1 − e) the same edge from its end to its
start. Seen from where the normals point, sides run anticlockwise:

===== ======== ===========================
side  where    runs
===== ======== ===========================
0     v = 0    with u
1     u = 1    with v
2     v = 1    against u
3     u = 0    against v
===== ======== ===========================
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index


def edge_numbers(sides: ArrayLike) -> Index:
    """Return the edges of sides without their sense: e for e and for ``~e``."""
    signed = np.asarray(sides, np.intp)
    return np.asarray(np.where(signed < 0, ~signed, signed))


def boundaries(edges: ArrayLike, sides: ArrayLike) -> Array:
    """Return the curves round patches, each in the sense in which it is followed.

    Parameters
    ----------
    edges : (m, 4, 3) array_like
        Control points of the edges, mm.
    sides : (…) array_like of int
        Edges by number, ``~e`` where followed against their sense.

    Returns
    -------
    (…, 4, 3) float
    """
    signed = np.asarray(sides, np.intp)
    curves = np.asarray(edges, float)[edge_numbers(signed)]
    return np.where((signed < 0)[..., None, None], curves[..., ::-1, :], curves)


def coons_nets(edges: ArrayLike, sides: ArrayLike) -> Array:
    """Return control nets of the bicubically blended Coons patches with zero twists.

    Parameters
    ----------
    edges : (m, 4, 3) array_like
        mm.
    sides : (k, 4) array_like of int
        Each begins where the one before it ends, to the last bit: the corner of a net is that
        of two sides.

    Returns
    -------
    (k, 4, 4, 3) float
        Their outer control points are those of the edges, bit for bit.
    """
    nets = with_boundaries(np.zeros((len(np.asarray(sides)), 4, 4, 3)), edges, sides)
    for i, j in ((0, 0), (0, 3), (3, 0), (3, 3)):
        inner, other = (1 if i == 0 else 2), (1 if j == 0 else 2)
        nets[:, inner, other] = (nets[:, i, other] - nets[:, i, j]) + nets[:, inner, j]
    return nets


def with_boundaries(nets: ArrayLike, edges: ArrayLike, sides: ArrayLike) -> Array:
    """Return nets whose outer control points are those of their sides, bit for bit.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Control points, mm; the inner ones are kept.
    edges, sides
        As in `coons_nets`.
    """
    made = np.array(nets, float)
    round_ = boundaries(edges, sides)
    made[:, ::-1, 3] = round_[:, 2]
    made[:, 0, ::-1] = round_[:, 3]
    made[:, :, 0] = round_[:, 0]
    made[:, 3] = round_[:, 1]
    return made


def sides_of(nets: ArrayLike) -> Array:
    """Return the curves round control nets in the order of their sides, (k, 4, 4, 3)."""
    nets = np.asarray(nets, float)
    return np.stack((nets[:, :, 0], nets[:, 3], nets[:, ::-1, 3], nets[:, 0, ::-1]), axis=1)
