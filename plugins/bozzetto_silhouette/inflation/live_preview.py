"""The shape under the pen: inflation of a stroke that is still being drawn.

A membrane under pressure (`membrane`): exact at the outline, it needs no skeleton and takes
a few milliseconds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Faces
from bozzetto.geometry import Mesh
from bozzetto.ink import self_crossings, signed_area
from bozzetto.scene import Layer, Scene, Shaded
from bozzetto_silhouette.inflation.closed_surface import sewn_shell, shell_normals
from bozzetto_silhouette.inflation.membrane import Membrane
from bozzetto_silhouette.model.sketch_plane import Sheet
from bozzetto_silhouette.outline.boundary_sampling import sample_rim
from bozzetto_silhouette.outline.domain_mesh import plan_of
from bozzetto_silhouette.outline.signed_distance import RimDistance

SPECK = 1e-3
"""Enclosed area, as a share of the square of the size, below which nothing is shown."""

MOST_CROSSINGS = 100
"""A line that crosses itself more often is a scribble: what it encloses would take seconds
to sort out, and is no shape."""


INK_PER_CELL = 4
"""Samples of the ink looked at in each cell: more than that does not show in so coarse a mesh."""


MOST_STEPS = 90
"""Steps along the outline: a spidery one gets a coarser mesh, to be there in time."""


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

    vertices: Array
    faces: Faces
    normals: Array


def _pieces(points: Array, holes: Sequence[Array]) -> list[tuple[Array, ...]]:
    """Return the rings of each piece that a closed, perhaps crossing, line encloses.

    What lies in the rings of `holes` is left out.
    """
    import shapely

    polygon = shapely.Polygon(points)
    if not polygon.is_valid and len(self_crossings(points, closed=True)) > MOST_CROSSINGS:
        return []
    valid = polygon if polygon.is_valid else shapely.make_valid(polygon)
    for hole in holes:
        valid = shapely.difference(valid, shapely.buffer(shapely.Polygon(hole), 0.0))
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
    outline_points: ArrayLike, *, cells: int = 20, holes: Sequence[Array] = ()
) -> Inflation | None:
    """Inflate an open stroke, closed by a straight chord.

    Parameters
    ----------
    outline_points : (n, 2) array_like
        Samples so far.
    cells : int
        Cells along the longest side.
    holes : sequence of (k, 2) array
        Rings of what the stroke is drawn around, which will be holes.

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
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(inner, axis=0).T))])
    inner = inner[np.diff(np.floor(arc * cells * INK_PER_CELL), prepend=-1.0) > 0.0]
    if len(inner) < 3:
        return None
    try:
        inside = [(hole - middle) / size for hole in holes]
        shells = [_inflated(rings, 1.0 / cells) for rings in _pieces(inner, inside)]
    except (ValueError, RuntimeError, IndexError, ArithmeticError):
        # Degenerate ink on the way to something better: show nothing for this frame.
        return None
    if not shells:
        return None
    offsets = np.cumsum([0] + [len(v) for v, _, _ in shells[:-1]])
    vertices = size * np.concatenate([v for v, _, _ in shells])
    vertices[:, :2] += middle
    faces = np.concatenate([f + o for (_, f, _), o in zip(shells, offsets, strict=True)])
    return Inflation(vertices, faces.astype(np.int32), np.concatenate([n for _, _, n in shells]))


def inflated_scene(points: ArrayLike, sheet: Sheet, holes: Sequence[Array] = ()) -> Scene:
    """Return a scene of the shape that an outline (n, 2), still being drawn, inflates to."""
    inflation = inflate(points, holes=holes)
    if inflation is None:
        return Scene()
    mesh = Mesh(
        sheet.to_world(inflation.vertices).astype(np.float32),
        inflation.faces,
        sheet.turn(inflation.normals).astype(np.float32),
    )
    return Scene((Layer("preview", (Shaded(mesh, pickable=False),)),))


def _inflated(rings: tuple[Array, ...], step: float) -> tuple[Array, Faces, Array]:
    length = sum(float(np.hypot(*(np.roll(r, -1, axis=0) - r).T).sum()) for r in rings)
    step = max(step, length / MOST_STEPS)
    rim = sample_rim(rings, step, 0.5 * step, thinness=0.8)
    plan = plan_of(rim, np.zeros((0, 2)), step)
    # A plan may have had to halve edges of its rim: the samples' radii come by the feet.
    count = len(plan.after)
    closest = RimDistance(rim.points, rim.after)(plan.points[count:])
    square = Membrane.of(plan).round(closest.distance, rim.radius[closest.segment])
    height = np.sqrt(square)
    return *sewn_shell(plan, height, height), shell_normals(plan, square, square)
