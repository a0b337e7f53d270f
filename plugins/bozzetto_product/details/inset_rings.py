"""Outlines inset by gaps and drafts, and whether there is room for that."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.course import TURNED
from bozzetto_product.details.floor import Offset
from bozzetto_product.details.levels import inset_points
from bozzetto_product.details.ring import Ring, spline_of_stretch

ROOM: Final = 1.02
"""How much thicker than a detail is deep the body must be."""

PLACES: Final = 65
"""Places of a stretch through which an inset outline goes."""

LOOKS: Final = 12
"""Places along each axis of a region at which the thickness of the body is looked at."""

GAP: Final = "The gap is wider than the outline has room for. Make the gap smaller."
DRAFT: Final = (
    "The walls would meet before the floor. Make the draft angle or the depth smaller, or the "
    "outline rounder."
)
GROOVE: Final = (
    "The walls of the gap would meet before its floor. Make the draft angle or the depth smaller, "
    "or the gap wider."
)

Thickness = Callable[[Array, Array], Array]
"""Points and outward normals, (n, 3), to how far the body reaches behind them, (n,) mm."""


def inner_ring(chart: Chart, offset: Offset, ring: Ring, gap: float) -> Ring:
    """Return the border of a button in its opening, run the other way: the region lies between."""
    rows = []
    for number in range(len(ring.stretches)):
        t = np.linspace(number, number + 1.0, PLACES)
        t[-1] -= 1e-12 * max(1.0, t[-1])
        rows.append(chart.flat(inset_points(chart, offset, ring, t, gap, 0.0)))
    return replace(_joined(rows), folds=ring.folds).reversed()


def far_rings(
    chart: Chart, offset: Offset, rings: Sequence[Ring], draft: float, thickness: Thickness
) -> tuple[Ring, ...]:
    """Return where outlines leave the body on its far side: smaller by the draft."""
    if draft == 0.0:
        return tuple(rings)
    made = []
    for ring in rings:
        rows = []
        for number in range(len(ring.stretches)):
            t = np.linspace(number, number + 1.0, PLACES)
            t[-1] -= 1e-12 * max(1.0, t[-1])
            flat, along = ring.value(t), ring.tangents(t)
            along = along / np.linalg.norm(along, axis=1, keepdims=True)
            points, _ = offset(flat)
            deep = thickness(points, np.broadcast_to(chart.normal, points.shape))
            if not np.isfinite(deep).all():
                raise UserError(TURNED)
            left, on = ring.inset_by(t, np.tan(draft) * deep)
            inward = np.column_stack((-along[:, 1], along[:, 0]))
            rows.append(flat + left[:, None] * inward + on[:, None] * along)
        made.append(_joined(rows))
    check_inset(made, rings, made, DRAFT)
    return tuple(made)


def _joined(rows: list[Array]) -> Ring:
    """Return stretches through points; where ends differ a little they meet in the middle."""
    starts = [0.5 * (rows[k - 1][-1] + rows[k][0]) for k in range(len(rows))]
    made = []
    for row, start, end in zip(rows, starts, [*starts[1:], starts[0]], strict=True):
        share = np.linspace(0.0, 1.0, len(row))[:, None]
        moved = row + (1.0 - share) * (start - row[0]) + share * (end - row[-1])
        moved[0], moved[-1] = start, end
        made.append(spline_of_stretch(moved))
    return Ring(tuple(made))


Outline = Ring | Array


def check_inset(
    region: Sequence[Outline], before: Sequence[Ring], after: Sequence[Outline], sentence: str
) -> None:
    """Raise `UserError` unless outlines bound one region, and none turned back when it was inset.

    Parameters
    ----------
    region : sequence of Ring or (n, 2) float
        The outline round it, then those of holes.
    before, after : sequence of Ring or (n, 2) float
        Outlines, and the same inset, at the same parameters.
    sentence : str
        What to say.
    """
    import shapely

    rows = [_polygon(outline) for outline in region]
    turned = [shapely.LinearRing(row).is_ccw for row in rows]
    sound = shapely.Polygon(rows[0], rows[1:]).is_valid and turned[0] and not any(turned[1:])
    for ring, inset in zip(before, after, strict=True):
        old = ring.polyline[:-1]
        new = inset if not isinstance(inset, Ring) else inset.value(ring.polyline_at[:-1])
        steps = np.roll(old, -1, axis=0) - old, np.roll(new, -1, axis=0) - new
        sound = sound and bool(((steps[0] * steps[1]).sum(axis=1) > 0.0).all())
    if not sound:
        raise UserError(sentence)


def _polygon(outline: Outline) -> Array:
    return outline.polyline[:-1] if isinstance(outline, Ring) else outline


def check_room(offset: Offset, ring: Ring, depth: float, thickness: Thickness) -> None:
    """Raise `UserError` where the body is not thicker than a detail is deep."""
    import shapely

    region = shapely.Polygon(ring.polyline[:-1])
    low, high = ring.polyline.min(axis=0), ring.polyline.max(axis=0)
    axes = [np.linspace(low[k], high[k], LOOKS) for k in range(2)]
    flat = np.column_stack([grid.ravel() for grid in np.meshgrid(*axes, indexing="ij")])
    flat = np.vstack((flat[shapely.contains_xy(region, *flat.T)], ring.polyline[::4]))
    points, normals = offset(flat)
    known = np.isfinite(points).all(axis=1)
    least = float(thickness(points[known], normals[known]).min(initial=np.inf))
    if least < ROOM * depth:
        raise UserError(
            f"The body is only {least:.3g} mm thick here. Make the detail less deep, or cut it "
            "through."
        )
