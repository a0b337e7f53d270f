"""Zebra stripes: what a polished surface mirrors of a room full of light tubes.

The tubes are rings round the model, infinitely far away, one above the other like parallels of
latitude. So a stripe is a line along which the mirrored line of sight climbs equally: it runs on
without a break where two surfaces share their tangent planes, and without a kink where they
share their curvature, too (Kaufmann & Klass 1988, "Smoothing surfaces using reflection lines
for families of splines"). The rings stand still in the world, so stripes wander over the model
as the view turns. Straight tubes, as in a light tunnel, meet at its ends, and every nose
and tail would show a star; rings meet nowhere, and close round the zenith.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from bozzetto.arrays import Flags, Floats, Index
    from bozzetto.scene.palette import Color
    from bozzetto.scene.renderer.shading import Fragments
    from bozzetto.scene.renderer.view_transform import ViewTransform

TUBES: Final = 24
"""Tubes from the nadir to the zenith; the gaps between them are as wide."""

SOFTNESS: Final = 0.05
"""Least width of the edge of a stripe, in tubes with their gaps."""

WHITE: Final = (250.0, 249.0, 246.0)
BLACK: Final = (34.0, 35.0, 38.0)
"""Tubes and gaps, sRGB."""

TINT: Final = 0.16
"""Share of the body's own colour in both."""


def with_zebra(
    seen: Fragments,
    part: NDArray[np.int32],
    colors: Sequence[Color],
    tinted: Flags,
    polished: Flags,
    sight: ViewTransform,
) -> Fragments:
    """Return the fragments with the colours of stripes on polished parts.

    Parameters
    ----------
    seen : Fragments
        The visible surface.
    part : (n,) int32
        Which part each pixel shows.
    colors : sequence of (r, g, b)
        Colours of the parts, where they have none at their vertices.
    tinted, polished : (parts,) bool
        Which parts show their vertex colours, and which mirror the tubes; these have a colour
        in every pixel then.
    sight : ViewTransform
        The transform of the window.
    """
    where = np.flatnonzero(polished[part])
    own = np.array(colors, np.float32)[part[where]]
    if len(seen.color):
        color, painted = seen.color.copy(), tinted[part[where]]
        own[painted] = color[where[painted], :3]
    else:
        color = np.full((len(seen.pixel), 4), 255.0, np.float32)
    light = stripes(seen, sight)[where, None]
    black, white = np.array(BLACK, np.float32), np.array(WHITE, np.float32)
    mirrored = black + (white - black) * light
    color[where, :3] = mirrored + np.float32(TINT) * (own - mirrored)
    return replace(seen, color=color)


def stripes(seen: Fragments, sight: ViewTransform) -> Floats:
    """Return how much of a light tube is mirrored at each pixel, 0 … 1, (n,).

    The pattern is 1 within a quarter of each tube's height, counted in tubes, and 0 between. Its
    mean over a pixel is the difference of its integral at both ends: stripes too fine for the
    picture come out grey, instead of making a pattern of their own.

    Parameters
    ----------
    seen : Fragments
        The visible surface.
    sight : ViewTransform
        The transform of the window.
    """
    height = np.arcsin(_climb(seen, sight)) * np.float32(TUBES / np.pi)
    width = np.maximum(_over_pixel(height, seen.pixel, sight), np.float32(SOFTNESS))
    middle, half = height + np.float32(0.25), np.float32(0.5) * width
    return np.asarray((_integral(middle + half) - _integral(middle - half)) / width)


def _climb(seen: Fragments, sight: ViewTransform) -> Floats:
    """Return the sine of the angle by which mirrored lines of sight climb, (n,).

    With the unit vectors n across the surface and s towards the eye, the line of sight goes on
    along 2 (n·s) n − s.
    """
    across, up, near = seen.normal
    right_climbs, up_climbs, near_climbs = np.array((1, 1, -1) * sight.axes[:, 2], np.float32)
    outward = right_climbs * across + up_climbs * up + near_climbs * near
    if not sight.perspective:
        return np.asarray(np.clip(2.0 * near * outward - near_climbs, -1.0, 1.0))
    y, x = np.divmod(seen.pixel, sight.width)
    right = ((sight.middle[0] - 0.5 - x) / sight.focal).astype(np.float32)
    rise = ((y + 0.5 - sight.middle[1]) / sight.focal).astype(np.float32)
    cosine = across * right + up * rise + near
    eye = right_climbs * right + up_climbs * rise + near_climbs
    length = np.sqrt(right * right + rise * rise + np.float32(1))
    return np.asarray(np.clip((2.0 * cosine * outward - eye) / length, -1.0, 1.0))


def _integral(height: Floats) -> Floats:
    """Integrate a pattern that is 1 on the first half of each unit and 0 on the second."""
    whole = np.floor(height)
    return np.asarray(np.float32(0.5) * whole + np.minimum(height - whole, np.float32(0.5)))


def _over_pixel(values: Floats, pixel: Index, sight: ViewTransform) -> Floats:
    """Return by how much values change over their pixels, (n,).

    On each axis the smaller of the steps to both neighbours: across a crease or a contour the
    pattern jumps, and that edge shall stay sharp.
    """
    full = np.full((sight.height + 2, sight.width + 2), np.nan, np.float32)
    full[1:-1, 1:-1].put(pixel, values)
    down = np.abs(np.diff(full[:, 1:-1], axis=0))
    across = np.abs(np.diff(full[1:-1], axis=1))
    rows, columns = np.fmin(down[:-1], down[1:]), np.fmin(across[:, :-1], across[:, 1:])
    return np.asarray(np.nan_to_num(rows.take(pixel)) + np.nan_to_num(columns.take(pixel)))
