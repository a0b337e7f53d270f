"""A surface pulled to a stroke: seen from there, its contour follows what was drawn.

Through each place of the stroke goes a ray. Across the stroke, in the plane of the ray, the surface
reaches farthest in one place; a bump of the clamped plate, the change that bends least, brings that
place to the ray. As the bump moves the contour, this is repeated. The boundary stays as it is, and
so do tangent planes along smooth edges.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.ink import Stroke, resample
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.moved_patches import Offsets, moved_patches
from bozzetto_product.fill.patch_fill import PatchFill
from bozzetto_product.network.reflection import Reflection

PLACES: Final = 48
"""Places along a stroke."""

GRID: Final = 24
"""Cells along each direction of a patch in which contours are sought."""

ROUNDS: Final = 6
"""Most times that the contour is sought anew."""

SETTLED: Final = 1e-4
"""Change, as share of the loop's size, at which no further round is worth it."""

BORDER: Final = 0.12
"""Distance from the border, as share of a patch, within which the stroke says less and less."""

TIE: Final = 0.02
"""Height, as share of the loop's size, that a place at the border is worth less than one in the
middle: of what is seen on edge, the middle is taken."""

FEWEST: Final = 4
"""Places of a stroke over a surface from which on it means it."""

MOST_TURN: Final = 1.0
"""Degrees by which a pull may turn a surface along a smooth edge."""


@dataclass(frozen=True, eq=False)
class Pulled:
    """A surface after a pull.

    Parameters
    ----------
    fill : Fill
    problem : str
        Why it is as before, for a person; "" where it followed.
    """

    fill: Fill
    problem: str = ""


_BESIDE: Final = (
    "a stroke over it does not run along its contour. Turn the view until you see the surface from "
    "the side, and draw where its contour is to be."
)
_FOLDS: Final = "a stroke pulls it so far that it would fold or leave its smooth edges. Pull less."

_HOLED: Final = "it has holes. Draw curves from its outline to them, and pull what is between."


def pulled(
    fill: Fill,
    stroke: Stroke,
    mirror: Reflection | None = None,
    *,
    checkpoint: Callable[[], None] = lambda: None,
) -> Pulled:
    """Return a surface whose contour follows a stroke.

    Parameters
    ----------
    fill : Fill
        As it is without this stroke.
    stroke : Stroke
        In the view through which the contour is meant.
    mirror : Reflection, optional
        In which the stroke's mirror image is meant instead.
    checkpoint : callable
        Called between the rounds.
    """
    sights = _Sights.of(stroke, mirror)
    if sights is None:
        return Pulled(fill, _BESIDE)
    start = fill.bent
    if start is None:
        return Pulled(fill, _HOLED if fill.has_holes else _FOLDS)
    made = start
    tie = TIE * start.size
    sense, on_edge = sights.sense(start, tie)
    for _ in range(ROUNDS):
        checkpoint()
        tie, on_edge = tie if on_edge else TIE * tie, False
        contour = sights.contour(made, sense, tie)
        if contour is None:
            return Pulled(fill, _BESIDE)
        moved = moved_patches(start, made, contour)
        step = float(np.abs(moved.solution.free - made.solution.free).max())
        made = moved
        if step < SETTLED:
            break
    turned = np.nanmax([0.0, *made.g1_degrees]) - np.nanmax([0.0, *start.g1_degrees])
    if made.folded or turned > MOST_TURN:
        return Pulled(fill, _FOLDS)
    return Pulled(made)


@dataclass(frozen=True, eq=False)
class _Sights:
    """Rays through a stroke; a plane along the stroke and one across it through each."""

    origins: Array
    upward: Array
    along: Array

    @classmethod
    def of(cls, stroke: Stroke, mirror: Reflection | None) -> _Sights | None:
        chord = stroke.points[-1] - stroke.points[0]
        length = float(np.linalg.norm(chord))
        if not np.isfinite(length) or length <= 0.0:
            return None
        rays = stroke.camera.rays(resample(stroke.points, count=PLACES))
        right, up, _ = stroke.camera.axes
        way = (chord[0] * right - chord[1] * up) / length
        origins, directions = rays.origins, rays.directions
        if mirror is not None:
            origins = mirror.points(origins)
            directions = directions - 2.0 * (directions @ mirror.normal)[:, None] * mirror.normal
            way = way - 2.0 * float(way @ mirror.normal) * mirror.normal
        upward = cross_product(directions, way)
        upward /= np.maximum(np.linalg.norm(upward, axis=1, keepdims=True), 1e-300)
        return cls(origins, upward, cross_product(upward, directions))

    def sense(self, fill: PatchFill, tie: float) -> tuple[float, bool]:
        """Return to which side the contour is farthest that the stroke is near, and if on edge.

        What is seen on edge has both at one place; it bulges to where it is pulled.
        """
        both = [self.contour(fill, sense, tie) for sense in (1.0, -1.0)]
        found = [each for each in both if each is not None]
        if len(found) < len(both):
            return (-1.0 if both[0] is None else 1.0), False
        up, down = (float(np.abs(each.heights).mean()) for each in found)
        if abs(up - down) <= 2.0 * tie:
            above = found[0].heights.mean() + found[1].heights.mean() > 0.0
            return (-1.0 if above else 1.0), True
        return (1.0 if up < down else -1.0), False

    def contour(self, fill: PatchFill, sense: float, tie: float) -> Offsets | None:
        """Return the places that reach farthest across the stroke; None where it runs beside."""
        places, cells, parameters, inside = _grid(fill)
        start, end = cells.T
        best: list[tuple[int, int, float, float]] = []
        for number, (origin, up, along) in enumerate(
            zip(self.origins, self.upward, self.along, strict=True)
        ):
            off, height = (places - origin) @ along, (places - origin) @ up
            crossed = np.flatnonzero((off[start] > 0.0) != (off[end] > 0.0))
            if not len(crossed):
                continue
            one, two = off[start[crossed]], off[end[crossed]]
            share = one / (one - two)
            reach = (1.0 - share) * height[start[crossed]] + share * height[end[crossed]]
            deep = (1.0 - share) * inside[start[crossed]] + share * inside[end[crossed]]
            top = int(np.argmax(sense * reach + tie * deep))
            best.append((number, int(crossed[top]), float(share[top]), float(reach[top])))
        if len(best) < FEWEST:
            return None
        rays = np.array([row[0] for row in best])
        lines = np.array([row[1] for row in best])
        share = np.array([row[2] for row in best])[:, None]
        at = (1.0 - share) * parameters[start[lines]] + share * parameters[end[lines]]
        weights = np.clip(at.min(axis=1) / BORDER, 0.0, 1.0) ** 2
        if (weights > 0.5).sum() < FEWEST:
            return None
        heights = np.array([row[3] for row in best])
        patches = start[lines] // (GRID + 1) ** 2
        return Offsets(patches, at, self.upward[rays], heights, weights)


def _grid(fill: PatchFill) -> tuple[Array, Index, Array, Array]:
    """Return places, lines between neighbours, parameters, and how far inside places are."""
    at = np.linspace(0.0, 1.0, GRID + 1)
    u, v = (part.ravel() for part in np.meshgrid(at, at, indexing="ij"))
    places = np.concatenate([patch.value(u, v) for patch in fill.patches])
    numbers = np.arange(len(u)).reshape(GRID + 1, GRID + 1)
    own = np.concatenate(
        (
            np.column_stack((numbers[:-1].ravel(), numbers[1:].ravel())),
            np.column_stack((numbers[:, :-1].ravel(), numbers[:, 1:].ravel())),
        )
    )
    count = len(fill.patches)
    lines = (own + len(u) * np.arange(count)[:, None, None]).reshape(-1, 2)
    parameters = np.tile(np.column_stack((u, v)), (count, 1))
    return places, lines, parameters, parameters.min(axis=1)
