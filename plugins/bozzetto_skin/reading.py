"""The curves of what others hand over, as polylines."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.geometry import Curve, Shapes, flattened

STEPS: Final = 24
"""Steps along each span of a curve: its polyline is a thousandth of the span off at most, which
is less than a skin's triangles are."""

FLAT: Final = 1e-4
"""Distance of the polyline of a patch's edge from the edge, per its extent."""

MOST_POINTS: Final = 1_000_000
"""Points of all polylines together, above which curves are refused: a state holds them all."""


def polylines(shapes: Shapes) -> tuple[Array, ...]:
    """Return the curves and the edges of patches and breps as polylines, (n, 3) each, mm.

    Bones of skeletons are left out, for they run inside a shape, and so are meshes.

    Raises
    ------
    UserError
        If there is no curve, or they have too many points.
    """
    found = tuple(line for line in _each(shapes) if len(line) > 1)
    if not found:
        raise UserError(
            "There is no curve to draw a skin over. Choose an object that has curves or patches, "
            "such as one of Symmetry or a car."
        )
    if sum(len(line) for line in found) > MOST_POINTS:
        raise UserError(
            "These curves have more than a million points. Choose fewer of them, or thin them out."
        )
    return found


def _each(shapes: Shapes) -> Iterator[Array]:
    for curve in shapes.curves:
        yield _sampled(curve)
    for brep in shapes.breps:
        yield from map(_sampled, brep.edges)
    for patchwork in shapes.patchworks:
        for edge in patchwork.edges:
            extent = float(np.linalg.norm(np.ptp(edge, axis=0)))
            if extent > 0:
                yield flattened(edge[None], FLAT * extent)[0]


def _sampled(curve: Curve) -> Array:
    """Sample a curve: a polyline at its corners, any other at even steps of each span."""
    if curve.degree == 1:
        return curve.control_points
    from scipy.interpolate import BSpline

    knots, degree = curve.knots, curve.degree
    spans = np.unique(knots[degree : len(knots) - degree])
    if len(spans) < 2:
        return curve.control_points[:1]
    shares = np.arange(STEPS) / STEPS
    at = np.append((spans[:-1, None] + np.diff(spans)[:, None] * shares).ravel(), spans[-1])
    weights = np.ones(len(curve.control_points)) if curve.weights is None else curve.weights
    above = np.column_stack((curve.control_points * weights[:, None], weights))
    place = BSpline(knots, above, degree)(at)
    return np.asarray(place[:, :3] / place[:, 3:])
