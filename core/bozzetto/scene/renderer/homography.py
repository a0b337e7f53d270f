"""Homography from a rectangle in space to the picture.

From a place on the sheet a picture's own coordinates follow by one 3 × 3 matrix (Hartley &
Zisserman, "Multiple View Geometry", 2nd ed., section 2.3), whose third row is the nearness of the
picture's plane: it tells what is in front, and where the plane goes behind the eye.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.scene.renderer.clipping import Polygon, cut, cut_to_window

if TYPE_CHECKING:
    from bozzetto.scene.display_list import Image
    from bozzetto.scene.renderer.view_transform import ViewTransform

EDGE_ON: Final = 1e-9
"""Volume of the box of both sides and the way to the corner, per product of their lengths,
below which a picture is seen edge on."""


@dataclass(frozen=True, eq=False)
class Place:
    """Place of a picture on the sheet.

    Attributes
    ----------
    matrix : (3, 3) float
        (x, y, 1) on the window to (u, v, 1) · w: parts of the picture's width and height.
    plane : (3,) float
        (x, y, 1) to nearness; the third row of the matrix but for a factor, in perspective.
    outline : (n, 2) float
        The part of the rectangle that is in the window, px.
    nearest : float
        Nearness beyond which nothing is shown.
    is_cut : bool
        Whether some of it is too near to be shown, or behind the eye.
    """

    matrix: Array
    plane: Array
    outline: Polygon
    nearest: float
    is_cut: bool


def place_of(image: Image, sight: ViewTransform) -> Place | None:
    """Return where a picture lies in a window; None where at most its edge is visible."""
    corner = sight.seen([image.corner])[0]
    across, down = (
        sight.axes @ np.asarray(side, np.float64) for side in (image.across, image.down)
    )
    corners = corner + np.array([0 * across, across, across + down, down])
    shown = cut(corners, (0.0, 0.0, 1.0), sight.near) if sight.perspective else corners
    if len(shown) < 3:
        return None
    outline = cut_to_window(sight.placed(shown)[:, :2], sight.width, sight.height)
    if len(outline) < 3:
        return None
    x, y = sight.middle
    unit = 1.0 / sight.focal
    sides = np.column_stack((across, down, corner))
    if not sight.perspective:
        sides[2] = 0.0, 0.0, 1.0
    lengths = np.linalg.norm(sides, axis=0)
    if not lengths.all() or abs(np.linalg.det(sides / lengths)) < EDGE_ON:
        return None
    # the ray through a place: right, up and forward in perspective, right, up and 1 in parallel
    ray = np.array([(unit, 0.0, -x * unit), (0.0, -unit, y * unit), (0.0, 0.0, 1.0)])
    matrix = np.linalg.solve(sides, ray)
    if sight.perspective:
        plane = sight.reference * matrix[2]
        return Place(
            matrix,
            plane,
            outline,
            sight.reference / sight.near,
            bool((corners[:, 2] < sight.near).any()),
        )
    depth = across[2] * matrix[0] + down[2] * matrix[1]
    plane = np.array((0.0, 0.0, sight.reference - corner[2])) - depth
    return Place(matrix, plane, outline, np.inf, False)
