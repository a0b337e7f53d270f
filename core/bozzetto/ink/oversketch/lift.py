"""Minimum-surprise lift: a curve that was changed on the sheet, back in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto.ink.checked_points import places_on_sheet

if TYPE_CHECKING:
    from bozzetto.view.camera import Camera

NEAREST: Final = 1e-4
"""Least distance from the eye of a perspective camera, as a share of the distance to its
target. Nearer than that nothing is shown."""


def lift_curve(curve: ArrayLike, camera: Camera, pixels: ArrayLike) -> NDArray[np.float64]:
    """Find the curve nearest to an old one that is seen where it now has to be.

    Of all curves that look like the new one, a person expects the one that changed least.
    Every node moves to the point of its new ray that is nearest to where it was:
    ``C* = o + ((C − o) · d) d`` (Kara & Shimada, section 13.2, "minimum surprise"). The
    nodes are independent, so this is the least sum of distances and of their squares. A
    node whose ray goes through it stays.

    Parameters
    ----------
    curve : (n, 3) array_like
        The old curve, mm.
    camera : Camera
        Through which it was changed, perspective or orthographic.
    pixels : (n, 2) array_like
        Where its nodes now have to be seen, px; not far along the curve from where each of
        them was, as `oversketch_curve` gives them.

    Returns
    -------
    (n, 3) float
        The new curve, mm; in front of the eye of a perspective camera.

    Raises
    ------
    UserError
        If there is no node, or one is not finite or not on the sheet.
    ValueError
        If there are not as many pixels as nodes.
    """
    place = places_on_sheet(pixels, "curve")
    nodes = np.array(curve, float).reshape(-1, 3)
    if len(nodes) != len(place):
        raise ValueError(f"{len(nodes)} nodes cannot be lifted to {len(place)} pixels")
    if not np.isfinite(nodes).all():
        raise UserError("The curve holds a point that is not finite; draw it again.")
    origins, directions = camera.rays(place)
    along = np.einsum("nk,nk->n", nodes - origins, directions)
    if camera.kind == "perspective":
        along = np.maximum(along, NEAREST * camera.distance)
    return np.asarray(origins + along[:, None] * directions)
