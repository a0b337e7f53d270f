"""The fillet of two solids by itself: what their blend adds to the sharp result, or takes away.

It is a thin solid along the crease. Its outer side is the blended surface; its inner side lies
within what it is added to, so that uniting both has no faces in common to decide on.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import override
from bozzetto_silhouette.implicit.blend import ORDER, flipped, reach_by_angle
from bozzetto_silhouette.implicit.composite import Composite, Row
from bozzetto_silhouette.implicit.implicit_solid import Batched, Implicit, Sample
from bozzetto_silhouette.model.state import Operation
from bozzetto_silhouette.numerics.isotropic_remeshing import dot

SUNK = 0.012
"""What the blend adds where the fillet goes under the sharp surface, as a share of the reach."""

SUNK_LEAST = 0.12
"""The same as a share of the spacing of the meshes, which lie so far off their functions."""

SUNK_MOST = 0.06
"""The same as a share of the reach, at most: of 0.25 that there are."""

DEPTH = 0.6
"""How far the fillet reaches into what it is added to, as a share of the reach."""

STEEP = 0.8
"""Slope of the ends of the fillet, where both solids stop telling on each other: values there are
about distances, too."""


class Layers(NamedTuple):
    """A composite at n points as a union: of carved solids the complements are united.

    Attributes
    ----------
    first, second : Sample
        The solids, or their complements.
    blended : Sample
        Of both together.
    reach : (n,) float array
    """

    first: Sample
    second: Sample
    blended: Sample
    reach: Array


def layers(solid: Composite | Row, points: Array) -> Layers:
    """Sample composites as the unions that they are, or whose complements they are."""
    sides = solid.sides(points)
    first, second, blended = sides.first, sides.second, solid.blended(sides)
    if solid.operation in ("carve", "intersect"):
        first, blended = flipped(first), flipped(blended)
    if solid.operation == "intersect":
        second = flipped(second)
    return Layers(first, second, blended, sides.reach)


def layers_each(solids: Sequence[Composite], places: Sequence[Array]) -> list[Layers]:
    """Sample several composites, each at places (n, 3) of its own, as `layers` does."""
    counts = [len(some) for some in places]
    alike: dict[Hashable, list[int]] = {}
    for k, solid in enumerate(solids):
        alike.setdefault(solid.kind, []).append(k)
    found: dict[int, Layers] = {}
    for members in alike.values():
        ends = np.cumsum([0, *(counts[k] for k in members)])
        row = layers(Row([solids[k] for k in members], ends),
                     np.concatenate([places[k] for k in members]))  # fmt: skip
        for k, low, high in zip(members, ends[:-1], ends[1:], strict=True):
            first, second, blended = (_part(sample, low, high) for sample in row[:3])
            found[k] = Layers(first, second, blended, row.reach[low:high])
    return [found[k] for k in range(len(solids))]


def _part(sample: Sample, low: int, high: int) -> Sample:
    value, gradient, curvature = sample
    if isinstance(curvature, np.ndarray):
        curvature = curvature[low:high]
    return Sample(value[low:high], gradient[low:high], curvature)


@dataclass(frozen=True, eq=False)
class FilletSolid(Batched):
    """The solid between the blended surface and the sharp one, and a little below that.

    Parameters
    ----------
    solid : Composite
        With a blend above 0.
    step : float
        Spacing of the meshes of the two.
    cell : float
        Edge of the cells in which it is to be found: it is not thinner than they are.
    """

    solid: Composite
    step: float
    cell: float

    @property
    def bounds(self) -> Array:
        """The box around both."""
        return self.solid.bounds

    @property
    @override
    def kind(self) -> Hashable:
        """Key that is equal for solids that can be sampled at once."""
        return self.solid.kind

    @staticmethod
    @override
    def sample_row(solids: Sequence[Implicit], points: Array, ends: Index) -> Sample:
        """Sample solids of this kind, each at points of its own, as `sample_each` does."""
        fillets = [solid for solid in solids if isinstance(solid, FilletSolid)]
        counts = np.diff(ends)
        step = np.repeat([fillet.step for fillet in fillets], counts)
        cell = np.repeat([fillet.cell for fillet in fillets], counts)
        return _sampled(Row([fillet.solid for fillet in fillets], ends), step, cell, points)

    def value(self, points: Array) -> Array:
        """Return the values at points (n, 3)."""
        return self.sample(points).value

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3)."""
        return _sampled(self.solid, self.step, self.cell, points)


class Shaped(NamedTuple):
    """Bounds of a fillet at n points: it is where all three values are above 0.

    Attributes
    ----------
    top, floor, flank : (n,) float array
        Values of its outer side, of its inner side, and of the ends, where the blend ends.
    slope : (n, 3) float array
        Gradient of the outer side: that of the blended surface, and steeper where it goes under.
    inner : (n, 3) float array
        Gradient of the inner side.
    apart : (n, 3) float array
        Gradient of the ends.
    """

    top: Array
    floor: Array
    flank: Array
    slope: Array
    inner: Array
    apart: Array

    @classmethod
    def of(
        cls, solid: Composite | Row, step: Array | float, cell: Array | float, points: Array
    ) -> tuple[Shaped, Sample]:
        """Sample a fillet at points (n, 3); return also the blended surface there."""
        first, second, blended, reach = layers(solid, points)
        leads = first.value >= second.value
        sharp = np.where(leads, first.value, second.value)
        slope = np.where(leads[:, None], first.gradient, second.gradient)
        added = blended.value - sharp
        sunk = np.clip(SUNK_LEAST * step, SUNK * reach, SUNK_MOST * reach)
        under = 2.0 - added / np.maximum(sunk, 1e-300)
        top = blended.value - sunk * np.clip(under, 0.0, 1.0)
        floor = np.maximum(DEPTH * reach, 2.0 * cell) - sharp
        apart = np.where(leads[:, None], second.gradient - first.gradient,
                         first.gradient - second.gradient)  # fmt: skip
        steep = STEEP / np.maximum(np.sqrt(dot(apart, apart)), 1.0)
        flank = steep * _flank(solid.operation, first, second, reach, sunk)
        goes = ((under > 0.0) & (under < 1.0))[:, None]
        steeper = blended.gradient + np.where(goes, blended.gradient - slope, 0.0)
        return cls(top, floor, flank, steeper, -slope, steep[:, None] * apart), blended


def _sampled(
    solid: Composite | Row, step: Array | float, cell: Array | float, points: Array
) -> Sample:
    """Sample the fillets of one composite, or of a row of them."""
    shaped, blended = Shaped.of(solid, step, cell, points)
    top, floor, flank, _, inner, apart = shaped
    value = np.minimum(np.minimum(top, floor), flank)
    gradient = np.where((value == top)[:, None], blended.gradient, inner)
    ends = (value == flank) & (flank < top)
    return Sample(value, np.where(ends[:, None], apart, gradient))


def _flank(operation: Operation, first: Sample, second: Sample, reach: Array, sunk: Array) -> Array:
    """Return how far within the blend points are, less where it adds half of `sunk`."""
    safe = np.maximum(reach, 1e-300)
    if operation == "merge":
        within = reach + np.minimum(first.value, second.value)
        return within - reach * (0.5 * ORDER * sunk / safe) ** (1.0 / ORDER)
    angled = reach_by_angle(first, second, reach)
    return angled - np.abs(first.value - second.value) - np.sqrt(2.0 * angled * sunk)
