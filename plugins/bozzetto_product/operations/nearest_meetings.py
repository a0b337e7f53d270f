"""Places inside curves that ends are joined to: T-joints."""

from __future__ import annotations

from collections.abc import Collection
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.geometry import Spline
from bozzetto.plugin import remembered
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.joints import Meeting
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.meetings import place_at, share_at
from bozzetto_product.operations.plane_crossings import lies_in, plane_crossings
from bozzetto_product.projection.planes import mirror_image

BESIDE: Final = 2.0
"""Distance of the end of a curve, in that of its nearest place, below which the end is meant."""


def nearest_inside(
    state: ProductState, place: Array, reach: float, busy: Collection[str], flat: bool
) -> tuple[Meeting, float] | None:
    """Return the nearest place inside a curve, or its mirror image, within a distance.

    Curves of which an end is within that distance, or nearly as near, do not count.

    Parameters
    ----------
    state : ProductState
        The network, in the frame of the model.
    place : (3,) float
        mm.
    reach : float
        mm.
    busy : collection of str
        Ids of curves that do not count.
    flat : bool
        Only places in the symmetry plane count: where curves cross it, or those that lie in it.
    """
    best: tuple[float, tuple[float, ...], Meeting] | None = None
    curves = [curve for curve in state.of_kind(Curve) if curve.spline is not None]
    low, high = _boxes(tuple(curve.spline for curve in curves))
    both = place, mirror_image(place, state.symmetry)
    far = (np.maximum(low - here, here - high).max(axis=1, initial=-np.inf) for here in both)
    near = [own <= reach for own in far]
    for number in np.flatnonzero(near[0] | near[1]):
        curve = curves[number]
        spline = curve.spline
        if spline is None or curve.id in busy:
            continue
        across = flat and not lies_in(curve, state.symmetry)
        for mirrored in (False, True) if curve.mirrored else (False,):
            here = both[mirrored]
            if not near[mirrored][number]:
                continue
            ends = np.linalg.norm(spline.control_points[[0, -1]] - here, axis=1)
            if not spline.closed and ends.min() <= reach:
                continue  # it is the end that is meant
            if not across and spline.least_distances(here[None])[0] > reach:
                continue
            shares = (
                plane_crossings(spline, state.symmetry) if across else [_foot_share(spline, here)]
            )
            for share in shares:
                foot = place_at(spline, share)
                distance = float(np.linalg.norm(foot - here))
                beside_end = not spline.closed and ends.min() <= BESIDE * distance
                if distance > reach or beside_end or not (spline.closed or 0.0 < share < 1.0):
                    continue
                found = (distance, tuple(foot.tolist()), Meeting(curve.id, share, mirrored))
                if best is None or found[:2] < best[:2]:
                    best = found
    return None if best is None else (best[2], best[0])


@remembered(limit=8)
def _boxes(splines: tuple[Spline | None, ...]) -> tuple[Array, Array]:
    """Return the least and the largest coordinates of control points, (n, 3) each."""
    points = [spline.control_points for spline in splines if spline is not None]
    return (
        np.array([own.min(axis=0) for own in points]).reshape(-1, 3),
        np.array([own.max(axis=0) for own in points]).reshape(-1, 3),
    )


def _foot_share(spline: Spline, place: Array) -> float:
    """Return the share of the range at which a curve is nearest to a place."""
    return share_at(spline, float(spline.foot_points(place[None])[0]))
