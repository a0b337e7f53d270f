"""The shape under the pen: inflation of a stroke that is still being drawn.

A membrane under pressure, -laplace(u) = const with u = 0 on the outline, and the height
sqrt(u): a strip comes out with a circular section, a disc as a ball (up to the factor that
is set from the inscribed radius). It is exact at the outline, needs no skeleton and takes
a few milliseconds. After Dvoroznak et al., "Monster Mash", 2020.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.ink.closing import signed_area
from bozzetto.ink.crossings import self_crossings
from bozzetto_silhouette.distance import RimDistance
from bozzetto_silhouette.elements import Elements, factorised
from bozzetto_silhouette.plan import Plan, plan_of
from bozzetto_silhouette.sampling import sample_rim
from bozzetto_silhouette.shell import sewn_shell, vertex_normals

__all__ = ["Inflation", "inflate", "membrane"]

Points = NDArray[np.float64]

SPECK = 1e-3
"""Enclosed area, as a share of the square of the size, below which nothing is shown."""

TANGLE = 100
"""A line that crosses itself more often is a scribble: what it encloses would take seconds
to sort out, and is no shape."""


@dataclass(frozen=True, eq=False)
class Inflation:
    """A surface to be shown while drawing.

    Attributes
    ----------
    vertices : (v, 3) float array
    faces : (f, 3) int32 array
        Oriented outwards.
    normals : (v, 3) float array
    """

    vertices: Points
    faces: NDArray[np.int32]
    normals: Points


def membrane(plan: Plan) -> Points:
    """Solve -laplace(u) = 1 on a plan with u = 0 on its rim, linear finite elements.

    Returns
    -------
    (n,) float array
    """
    rim = len(plan.after)
    elements = Elements.of(plan)
    u = np.zeros(len(plan.points))
    u[rim:] = factorised(elements.stiffness()[rim:, rim:]).solve(elements.mass[rim:])
    return u


def _pieces(points: Points) -> list[tuple[Points, ...]]:
    """What a closed, perhaps crossing, line encloses: rings of each piece, sorted out."""
    import shapely

    polygon = shapely.Polygon(points)
    if not polygon.is_valid and len(self_crossings(points, closed=True)) > TANGLE:
        return []
    valid = polygon if polygon.is_valid else shapely.make_valid(polygon)
    result = []
    for part in shapely.get_parts(valid):
        if part.geom_type not in ("Polygon", "MultiPolygon"):
            continue
        for piece in shapely.get_parts(part):
            if piece.area < SPECK:
                continue
            rings = [shapely.get_coordinates(r)[:-1] for r in (piece.exterior, *piece.interiors)]
            turned = [
                r if (signed_area(r) > 0) == (k == 0) else r[::-1] for k, r in enumerate(rings)
            ]
            result.append(tuple(turned))
    return result


def inflate(
    outline_points: ArrayLike, *, cells: int = 24, inflation: float = 1.0
) -> Inflation | None:
    """Inflate an open stroke, closed by a straight chord.

    Parameters
    ----------
    outline_points : (n, 2) array_like
        Samples so far.
    cells : int
        Cells along the longest side.
    inflation : float
        Factor on the depth.

    Returns
    -------
    Inflation or None
        None when there is nothing to show yet. Never raises for any finite or infinite
        input: a preview must not get in the way of the pen.
    """
    points = np.asarray(outline_points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] < 2:
        return None
    points = points[np.isfinite(points).all(axis=1), :2]
    if len(points) < 3:
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    size, middle = float((high - low).max()), 0.5 * (low + high)
    if not size > 1e-12 * max(1.0, float(np.abs(points).max())):
        return None
    inner = (points - middle) / size
    inner = inner[np.any(np.abs(np.diff(inner, axis=0, prepend=inner[:1] - 1.0)) > 1e-3, axis=1)]
    if len(inner) < 3:
        return None
    try:
        shells = [_inflated(rings, 1.0 / cells, inflation) for rings in _pieces(inner)]
    except (ValueError, RuntimeError, IndexError, ArithmeticError):
        # Degenerate ink on the way to something better: show nothing for this frame.
        return None
    if not shells:
        return None
    offsets = np.cumsum([0] + [len(v) for v, _ in shells[:-1]])
    vertices = np.concatenate([v for v, _ in shells])
    faces = np.concatenate([f + o for (_, f), o in zip(shells, offsets, strict=True)])
    normals = vertex_normals(vertices, faces)
    vertices = vertices * size
    vertices[:, :2] += middle
    return Inflation(vertices, faces.astype(np.int32), normals)


def _inflated(
    rings: tuple[Points, ...], step: float, inflation: float
) -> tuple[Points, NDArray[np.int32]]:
    rim = sample_rim(rings, step, 0.35 * step)
    plan = plan_of(rim, np.zeros((0, 2)), step)
    u = np.maximum(membrane(plan), 0.0)
    inner = plan.points[len(plan.after) :]
    radius = float(RimDistance(plan.points[: len(plan.after)], plan.after)(inner).distance.max())
    height = np.sqrt(u)
    height *= inflation * radius / max(float(height.max()), 1e-12)
    return sewn_shell(plan, height, height)
