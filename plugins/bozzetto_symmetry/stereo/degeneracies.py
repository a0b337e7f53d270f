"""Pairs of mirrored rays that do not meet in one point before the eye, and why.

Bae, Kijima and Kim (2004) name seven special cases of a pair of rays. They follow from one
picture. A pair on one epipolar line lies in a plane through the eye e that holds the y axis.
There w is the way from the eye along the centre plane, and the ray of `near` and the mirrored
ray of `far` are the lines ``y = e_y + m1 w`` and ``y = -e_y - m2 w``; they meet at
``w = -2 e_y / (m1 + m2)``. So one point before the eye is there unless

1. e_y is 0: both rays start in one place (for parallel rays: the sight is in the plane);
2. one ray has no w, being parallel to the normal: it meets the other only in an eye;
3. neither has: both are the line through the eye and its image (for parallel rays all are
   parallel to the normal, and left and right are seen in one place);
4. m1 + m2 is 0: the rays are parallel;
5. w is below 0, or the rays run opposite ways along the plane, having the vanishing point
   between them: they part, and meet behind an eye.

Two more are special and can be solved:

6. m1 = m2: the rays come from one place of the sheet and meet in the plane, where y is 0
   exactly: it is enough to meet the plane;
7. the eye is at infinity: every ray has an origin of its own in the place of the one eye.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array
from bozzetto_symmetry.stereo.mirror_camera import Stereo

Codes = NDArray[np.int8]

TINY: Final = 1e-8
"""Sines and slopes below which a ray counts as in the plane, along the normal or parallel."""

SAME: Final = 1e-6
"""Distance on the sheet below which two places are one, px."""


class Case(IntEnum):
    """The cases of a pair of mirrored rays."""

    ORDINARY = 0
    EYE_ON_PLANE = 1
    ONE_ALONG_NORMAL = 2
    BOTH_ALONG_NORMAL = 3
    PARALLEL = 4
    BEHIND = 5
    IN_PLANE = 6
    EYE_AT_INFINITY = 7


SOLVABLE: Final = (Case.ORDINARY, Case.IN_PLANE, Case.EYE_AT_INFINITY)
"""The cases that have one point before the eye."""

CAUSES: Final[dict[Case, str]] = {
    Case.EYE_ON_PLANE: "The view lies in the centre plane, where both sides look the same.",
    Case.ONE_ALONG_NORMAL: "One side runs through the vanishing point of left and right.",
    Case.BOTH_ALONG_NORMAL: "Seen from straight ahead, left and right are in one place.",
    Case.PARALLEL: "The lines of sight of left and right never meet.",
    Case.BEHIND: "The lines of sight of left and right would meet behind you.",
}
"""What is wrong in the cases without a point."""

REMEDIES: Final[dict[Case, str]] = {
    Case.EYE_ON_PLANE: "Turn the view by about 15°.",
    Case.ONE_ALONG_NORMAL: "Turn the view, and draw that piece there.",
    Case.BOTH_ALONG_NORMAL: "Turn the view by about 15°.",
    Case.PARALLEL: "Draw the two sides farther apart.",
    Case.BEHIND: "Draw both sides within the box, the right one on the right.",
}
"""What to do about it."""


def special_case(stereo: Stereo, near: ArrayLike, far: ArrayLike) -> Codes:
    """Return the case of each pair of places.

    Parameters
    ----------
    stereo : Stereo
        The camera of the view and its mirror image.
    near, far : (n, 2) array_like
        Pairs on common epipolar lines, px.

    Returns
    -------
    (n,) int8
        Values of `Case`; the first that applies, in the order of the module's list.
    """
    one = np.reshape(np.asarray(near, float), (-1, 2))
    other = np.reshape(np.asarray(far, float), (-1, 2))
    if stereo.slant < TINY:
        return np.full(len(one), Case.EYE_ON_PLANE, np.int8)
    first, second = (stereo.rays(place).directions for place in (one, other))
    level, level_far = (np.hypot(ray[:, 0], ray[:, 2]) for ray in (first, second))
    upright, upright_far = level < TINY, level_far < TINY
    ordinary, apart, parting = Case.ORDINARY, np.zeros(len(one), bool), np.zeros(len(one), bool)
    if stereo.parallel:
        ordinary = Case.EYE_AT_INFINITY
    else:
        # Both slopes at once, over the product of the two levels: nothing is divided.
        slopes = first[:, 1] * level_far + second[:, 1] * level
        apart = np.abs(slopes) < TINY * (level + level_far)
        facing = first[:, 0] * second[:, 0] + first[:, 2] * second[:, 2]
        parting = (slopes * stereo.camera.eye[1] > 0.0) | (facing <= 0.0)
    together = np.linalg.norm(one - other, axis=1) < SAME
    codes = np.select(
        [upright & upright_far, upright | upright_far, apart, parting, together],
        [
            Case.BOTH_ALONG_NORMAL,
            Case.ONE_ALONG_NORMAL,
            Case.PARALLEL,
            Case.BEHIND,
            Case.IN_PLANE,
        ],
        ordinary,
    )
    return codes.astype(np.int8)


def intersect_rays(stereo: Stereo, near: ArrayLike, far: ArrayLike) -> tuple[Array, Codes]:
    """Return points from pairs of places, in all cases that have one.

    Returns
    -------
    points : (n, 3) float
        mm; NaN where there is none. Where both places are one, y is exactly 0.
    codes : (n,) int8
        Why, as in `special_case`.
    """
    codes = special_case(stereo, near, far)
    points = np.full((len(codes), 3), np.nan)
    meeting, planar = np.isin(codes, SOLVABLE), codes == Case.IN_PLANE
    one, other = (np.reshape(np.asarray(place, float), (-1, 2)) for place in (near, far))
    points[meeting] = stereo.intersected(one[meeting], other[meeting])
    points[planar] = stereo.on_plane(one[planar])
    return points, codes


def reasons_of(codes: ArrayLike) -> tuple[str, ...]:
    """Return why there are places without a point and what to do, the commonest case first."""
    counts = np.bincount(np.asarray(codes, np.intp), minlength=len(Case))
    found = sorted((case for case in CAUSES if counts[case]), key=lambda case: -counts[case])
    return tuple(f"{CAUSES[case]} {REMEDIES[case]}" for case in found)
