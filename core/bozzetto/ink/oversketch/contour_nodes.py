"""Places on a curve in space at equal steps along its image: the nodes of an active contour."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink.checked_points import FARTHEST
from bozzetto.ink.curves.resample import arc_length

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.geometry import Spline

LOOKS: Final = 1024
"""Places by which the length of an image is measured."""

NODES: Final = (16, 1200)
"""Fewest and most nodes of a contour; one longer than the sheet gets coarser ones."""


def contour_nodes(
    spline: Spline, see: Callable[[Array], Array], spacing: float
) -> tuple[Array, bool]:
    """Return parameters at equal steps along the image of a curve, and whether they close.

    Of a curve that passes the eye the longest part that is seen.

    Parameters
    ----------
    spline : Spline
        In space.
    see : callable
        Where points of it, (n, 3), are seen, (n, 2) px; not finite where they are not.
    spacing : float
        Distance of the nodes along the image, px.

    Returns
    -------
    parameters : (k,) float
        Rising.
    closes : bool
        Whether all of a closed curve is seen; its first node is not repeated.

    Raises
    ------
    UserError
        If nothing of the curve is seen.
    """
    dense = np.linspace(*spline.range, LOOKS)
    pixels = see(spline.value(dense))
    seen = (np.abs(pixels) <= FARTHEST).all(axis=1)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], seen, [False])).astype(int)))
    runs = edges.reshape(-1, 2)
    longest = max(((last - first, first, last) for first, last in runs.tolist()), default=(0, 0, 0))
    count, first, last = longest
    if count < 3:
        raise UserError("The curve is not seen from here. Turn the view, then draw over it.")
    closes = bool(spline.closed and count == LOOKS)
    along = arc_length(pixels[first:last])
    nodes = int(np.clip(along[-1] / spacing, *NODES))
    stations = np.linspace(0.0, along[-1], nodes, endpoint=not closes)
    return np.interp(stations, along, dense[first:last]), closes
