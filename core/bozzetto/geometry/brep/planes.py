"""Plane faces within polygons and curves, with holes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, frozen
from bozzetto.errors import UserError
from bozzetto.geometry.brep.brep import (
    GAP,
    Brep,
    Face,
    ParameterCurve,
    Trim,
    loop_ring,
    refuse_far,
    signed_area,
)
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Color, Curve

LINE_KNOTS: Final = frozen((0.0, 0.0, 1.0, 1.0), np.float64)
"""Knots of a straight line between two points."""

LEAST_WIDTH: Final = 1e-6
"""Least width of an outline, as share of its length: below it there is no plane to find."""

Outline = ArrayLike | Sequence[Curve]
"""Corners (n, 3) of a polygon, each once; or curves that follow one another, mm."""


def plane_face(
    loops: Iterable[Outline],
    *,
    normal: ArrayLike | None = None,
    name: str = "brep",
    color: Color | None = None,
) -> Brep:
    """Return the plane face within closed outlines.

    Parameters
    ----------
    loops : iterable of (n, 3) array_like or sequence of Curve
        The outer outline, then those of holes; polygons by their corners, each once, or curves
        each of which begins where the one before ends. A closed curve is an outline by itself.
        Holes may run either way.
    normal : (3,) array_like, optional
        The side to which the face looks; by default that from which the outer outline runs
        counter-clockwise.
    name : str
        What the shape is called.
    color : (r, g, b), optional
        sRGB.

    Returns
    -------
    Brep
        One face.

    Raises
    ------
    UserError
        If an outline has no area, does not close, crosses itself or another one, or they do not
        lie in one plane.
    """
    outlines = [_curves_of(loop) for loop in loops]
    if not outlines:
        raise UserError("A face needs an outline. Draw a closed line first.")
    points = np.concatenate([c.control_points for outline in outlines for c in outline])
    refuse_far(points)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    frame = _frame(outlines[0], normal, size)
    local = (points - frame[0]) @ frame[1:].T
    off = float(np.abs(local[:, 2]).max())
    if off > GAP * size:
        raise UserError(
            f"The outline does not lie in one plane: it leaves it by {off:.3g} mm."
            " Make it plane, or span a curved surface instead."
        )
    surface = _plane(frame, local[:, :2].min(axis=0), local[:, :2].max(axis=0))
    edges: list[Curve] = []
    rings: list[tuple[Trim, ...]] = []
    for number, outline in enumerate(outlines):
        trims = []
        for curve in outline:
            flat = (curve.control_points - frame[0]) @ frame[1:3].T
            path = ParameterCurve(curve.degree, curve.knots, flat, curve.weights)
            trims.append(Trim(len(edges), True, path))
            edges.append(curve)
        if (signed_area(loop_ring(tuple(trims))) > 0) != (number == 0):
            trims = [Trim(trim.edge, False, trim.curve) for trim in reversed(trims)]
        rings.append(tuple(trims))
    _refuse_crossings(rings)
    return Brep(tuple(edges), (Face(surface, tuple(rings)),), name, color)


def _curves_of(outline: Outline) -> tuple[Curve, ...]:
    """Return the clamped curves of an outline that closes."""
    if isinstance(outline, Sequence) and len(outline) and isinstance(outline[0], Curve):
        curves = tuple(curve.clamped() for curve in outline if isinstance(curve, Curve))
        ends = np.array([curve.control_points[[0, -1]] for curve in curves])
        every = np.concatenate([curve.control_points for curve in curves])
        step = np.abs(ends[:, 1] - np.roll(ends[:, 0], -1, axis=0)).max()
        if step > GAP * np.linalg.norm(np.ptp(every, axis=0)):
            raise UserError("The outline does not close. Join its ends first.")
        return curves
    corners = np.asarray(outline, float)
    if corners.ndim != 2 or corners.shape[1] != 3 or len(corners) < 3:
        raise UserError("An outline needs at least three corners in space.")
    if not np.isfinite(corners).all() or (corners == np.roll(corners, -1, axis=0)).all(1).any():
        raise UserError("Corners of an outline must be finite, and apart from the next one.")
    following = np.roll(corners, -1, axis=0)
    return tuple(
        Curve(1, LINE_KNOTS, np.stack(side)) for side in zip(corners, following, strict=True)
    )


def _frame(outline: Sequence[Curve], normal: ArrayLike | None, size: float) -> Array:
    """Return the middle of an outline, and unit vectors along u, v and the normal, (4, 3).

    u runs along the longest side, so that a rectangle is all of its surface. The normal is
    that of Newell (Sutherland, Sproull & Schumacker 1974): twice the area of the polygon's
    shadows along the axes.
    """
    ring = np.concatenate([c.value(np.linspace(*c.range, 33 if c.degree > 1 else 2))[:-1]
                           for c in outline])  # fmt: skip
    middle = ring.mean(axis=0)
    spokes = ring - middle
    area = np.cross(spokes, np.roll(spokes, -1, axis=0)).sum(axis=0)
    length = float(np.linalg.norm(area))
    if not length > LEAST_WIDTH * size * size:
        raise UserError("The outline encloses no area. Draw it wider.")
    up = area / length
    if normal is not None and float(up @ np.asarray(normal, float)) < 0:
        up = -up
    steps = np.roll(ring, -1, axis=0) - ring
    longest = steps[np.argmax(np.einsum("nk,nk->n", steps, steps))]
    u = longest - (longest @ up) * up
    u /= np.linalg.norm(u)
    return np.stack((middle, u, np.cross(up, u), up))


def _plane(frame: Array, low: Array, high: Array) -> BSplineSurface:
    """Return the rectangle of a plane between two corners in its own coordinates, mm."""
    middle, along_u, along_v, _ = frame
    net = np.array(
        [[middle + u * along_u + v * along_v for v in (low[1], high[1])] for u in (low[0], high[0])]
    )
    return BSplineSurface(
        (1, 1), np.repeat((low[0], high[0]), 2), np.repeat((low[1], high[1]), 2), net
    )


def _refuse_crossings(rings: list[tuple[Trim, ...]]) -> None:
    import shapely

    polygon = shapely.Polygon(loop_ring(rings[0]), [loop_ring(ring) for ring in rings[1:]])
    if not polygon.is_valid:
        raise UserError(
            "The outlines cross: holes must lie within the outer one and apart from one another. "
            "Draw the crossing part again."
        )
