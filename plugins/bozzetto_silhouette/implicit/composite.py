"""Two solids combined, as a function of space."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.plugin import cached_property
from bozzetto_silhouette.implicit.blend import flipped, smooth_maximum, summed
from bozzetto_silhouette.implicit.implicit_solid import Implicit, Placed, Sample
from bozzetto_silhouette.model.state import Operation

_NARROWING = 8
"""Power of the smooth minimum of reaches: three equal ones give 87 % of each."""

_NARROWEST = 1e6
"""Thinner than this share of the body nothing is blended."""

_FALL = 0.5
"""Outside a box every value falls at least at this rate: the promise of `Implicit`."""


class Sides(NamedTuple):
    """Both solids at n points.

    Attributes
    ----------
    first, second : Sample
    reach : (n,) float array
        Of the blend of the two there.
    """

    first: Sample
    second: Sample
    reach: Array


@dataclass(frozen=True, eq=False)
class Composite:
    """The result of an operation on two implicit solids.

    Parameters
    ----------
    first, second : Implicit
        In the same frame.
    operation : {"add", "merge", "carve", "intersect"}
    blend : float
        Radius of the blend as a share of the local radius of the thinner one; 0 is a sharp
        crease.
    reach : float
        The largest radius of the blend, as a length.
    """

    first: Implicit
    second: Implicit
    operation: Operation
    blend: float
    reach: float

    @cached_property
    def bounds(self) -> Array:
        """A box around the solid; blends fill no more than a quarter of their reach."""
        (low, high), (other_low, other_high) = self.first.bounds, self.second.bounds
        if self.operation == "carve":
            return np.stack([low, high])
        if self.operation == "intersect":
            low, high = np.maximum(low, other_low), np.minimum(high, other_high)
            return np.stack([np.minimum(low, high), np.maximum(low, high)])
        swell = 0.25 * self.reach
        return np.stack([np.minimum(low, other_low) - swell, np.maximum(high, other_high) + swell])

    def value(self, points: Array) -> Array:
        """Return the values at points (n, 3)."""
        return self.sample(points).value

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3)."""
        return self.blended(self.sides(points))

    def sides(self, points: Array) -> Sides:
        """Sample both solids; where one cannot matter, only its bound is given."""
        first, second = self._samples(points)
        return Sides(first, second, self._local_reach(first, second))

    def within(self, box: Array, margin: float) -> Composite:
        """Return the same solid with `localized` operands."""
        first, second = (localized(side, box, margin) for side in (self.first, self.second))
        return replace(self, first=first, second=second)

    def felt(self, points: Array) -> Flags:
        """Return where (n,) the blend may make a difference, by the boxes alone."""
        far = self.reach / _FALL
        return (box_distance(points, self.first.bounds) <= far) & (
            box_distance(points, self.second.bounds) <= far
        )

    def blended(self, sides: Sides) -> Sample:
        """Combine two samples into one by the operation and its blend."""
        first, second, reach = sides
        if self.operation == "carve":
            return flipped(smooth_maximum(flipped(first), second, reach))
        if self.operation == "intersect":
            return flipped(smooth_maximum(flipped(first), flipped(second), reach))
        if self.operation == "merge" and self.blend > 0.0:
            return summed(first, second, reach)
        return smooth_maximum(first, second, reach)

    def _samples(self, points: Array) -> tuple[Sample, Sample]:
        if self.operation == "intersect":
            return self.first.sample(points), self.second.sample(points)
        far = -_FALL * box_distance(points, self.second.bounds)
        if self.operation == "carve":
            first = self.first.sample(points)
            return first, _where(self.second, points, far, far > -first.value - self.reach)
        near = -_FALL * box_distance(points, self.first.bounds)
        # The first is asked once: it may be a long chain, which two questions at every link
        # would make exponential.
        leads = near >= far
        second = _where(self.second, points, far, ~leads)
        first = _where(self.first, points, near, leads | (near > second.value - self.reach))
        late = leads & (far > first.value - self.reach)
        return first, _where(self.second, points, far, late, second)

    def _local_reach(self, first: Sample, second: Sample) -> Array:
        """Return the reach of the blend (n,): that of the thinner solid there, below the largest.

        A smooth minimum, so that fillets narrow without a kink. It is what Gourmel et al. and
        MATISSE (Bernhardt et al., 2008) ask of a blend: not to wash out what is small.
        """
        if self.blend <= 0.0:
            return np.zeros(len(first.value))
        narrow = self.reach / self.blend
        one, other = (np.minimum(narrow * s.curvature, _NARROWEST) for s in (first, second))
        return np.broadcast_to(
            self.reach * (1.0 + (one**_NARROWING + other**_NARROWING)) ** (-1.0 / _NARROWING),
            len(first.value),
        )


def localized(solid: Implicit, box: Array, margin: float) -> Implicit:
    """Drop the operands of a solid that are too far from a box (2, 3) to matter in it.

    In the box it is the same wherever the values that are blended lie between -margin and
    margin; beyond, it stays outside. A tree of many parts is as fast in a small place as a few.
    """
    if isinstance(solid, Placed):
        back = solid.placement.inverse()
        corners = back.points(_corners(box))
        moved = np.stack([corners.min(axis=0), corners.max(axis=0)])
        inner = localized(solid.inner, moved, margin * back.scale)
        return solid if inner is solid.inner else Placed(inner, solid.placement)
    if not isinstance(solid, Composite) or solid.operation == "intersect":
        return solid
    felt = margin + solid.reach
    if _FALL * _box_gap(box, solid.second.bounds) > felt:
        return localized(solid.first, box, margin)
    if solid.operation != "carve" and _FALL * _box_gap(box, solid.first.bounds) > felt:
        return localized(solid.second, box, margin)
    return solid.within(box, margin)


def signature(solid: Implicit) -> object:
    """Return a key of the solid's values: solids with equal keys are the same function."""
    if isinstance(solid, Placed):
        return (signature(solid.inner), solid.placement)
    if isinstance(solid, Composite):
        own = (solid.operation, solid.blend, solid.reach)
        return (signature(solid.first), signature(solid.second), *own)
    return solid


def _corners(box: Array) -> Array:
    x, y, z = box.T
    return np.array([[i, j, k] for i in x for j in y for k in z])


def _box_gap(box: Array, other: Array) -> float:
    """Return the distance between two boxes (2, 3)."""
    (low, high), (other_low, other_high) = box.tolist(), other.tolist()
    return math.hypot(*(
        max(a - d, c - b, 0.0)
        for a, b, c, d in zip(low, high, other_low, other_high, strict=True)
    ))  # fmt: skip


def box_distance(points: Array, bounds: Array) -> Array:
    """Return the distance (n,) of points (n, 3) from a box (2, 3), 0 inside."""
    beyond = np.maximum(np.maximum(bounds[0] - points, points - bounds[1]), 0.0)
    distance: Array = np.sqrt(np.einsum("ij,ij->i", beyond, beyond))
    return distance


def _where(
    solid: Implicit,
    points: Array,
    bound: Array,
    wanted: Flags,
    known: Sample | None = None,
) -> Sample:
    """Sample a solid where wanted; give what is known, or a bound of the value, elsewhere."""
    if wanted.all():
        return solid.sample(points)
    if known is None:
        known = Sample(bound.copy(), np.zeros_like(points))
    curvature = np.broadcast_to(known.curvature, len(points)).copy()
    chosen = np.flatnonzero(wanted)
    if len(chosen):
        known.value[chosen], known.gradient[chosen], curvature[chosen] = solid.sample(
            points[chosen]
        )
    return known._replace(curvature=curvature)
