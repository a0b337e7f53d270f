"""Two solids combined, as a function of space."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.plugin import cached_property, override
from bozzetto_silhouette.implicit.blend import flipped, smooth_maximum, summed
from bozzetto_silhouette.implicit.implicit_solid import (
    Batched,
    Implicit,
    Placed,
    Sample,
    sample_each,
)
from bozzetto_silhouette.model.state import Operation

_DOUBLINGS = 3
"""Of the power of the smooth minimum of reaches: with the eighth, three equal ones give 87 % of
each."""

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
class Composite(Batched):
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

    @property
    @override
    def kind(self) -> Hashable:
        """Key that is equal for solids that can be sampled at once."""
        return self.operation, self.blend > 0.0

    @staticmethod
    @override
    def sample_row(solids: Sequence[Implicit], points: Array, ends: Index) -> Sample:
        """Sample solids of this kind, each at points of its own, as `sample_each` does."""
        composites = [solid for solid in solids if isinstance(solid, Composite)]
        return Row(composites, ends).sample(points)

    def value(self, points: Array) -> Array:
        """Return the values at points (n, 3)."""
        return self.sample(points).value

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3)."""
        return Row((self,), np.array([0, len(points)])).sample(points)

    def sides(self, points: Array) -> Sides:
        """Sample both solids; where one cannot matter, only its bound is given."""
        return Row((self,), np.array([0, len(points)])).sides(points)

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


@dataclass(frozen=True, eq=False)
class Row:
    """Composites of one `kind`, each with points of its own in a row of points.

    Parameters
    ----------
    solids : sequence of Composite
    ends : (s + 1,) int array
        Those of solid k are the points from ``ends[k]`` up to ``ends[k + 1]``.
    """

    solids: Sequence[Composite]
    ends: Index

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3); blended only where it may be felt."""
        reach = self._spread([solid.reach for solid in self.solids])
        first, second = self._samples(points, reach)
        if self.operation == "merge":
            return self.blended(Sides(first, second, self._local_reach(first, second, reach)))
        found, apart = self._sharp(first, second)
        near = np.flatnonzero(apart < reach)
        if len(near):
            some = Row(self.solids, np.searchsorted(near, self.ends))
            one, other = (_at(sample, near) for sample in (first, second))
            within = reach if reach.ndim == 0 else reach[near]
            blended = some.blended(Sides(one, other, some._local_reach(one, other, within)))
            for column, values in zip(found, blended, strict=True):
                np.asarray(column)[near] = values
        return found

    def _sharp(self, first: Sample, second: Sample) -> tuple[Sample, Array]:
        """Combine two samples without a blend; return how far the values (n,) are apart, too."""
        a, b = first.value, second.value
        if self.operation == "carve":
            b = -b
        leads = a <= b if self.operation in ("carve", "intersect") else a >= b
        other = -second.gradient if self.operation == "carve" else second.gradient
        return Sample(
            np.where(leads, a, b),
            np.where(leads[:, None], first.gradient, other),
            np.where(leads, first.curvature, second.curvature),
        ), np.abs(a - b)

    @property
    def operation(self) -> Operation:
        """The operation of all of them."""
        return self.solids[0].operation

    def blended(self, sides: Sides) -> Sample:
        """Combine two samples into one by the operation and its blend."""
        return self.solids[0].blended(sides)

    def sides(self, points: Array) -> Sides:
        """Sample both solids; where one cannot matter, only its bound is given."""
        reach = self._spread([solid.reach for solid in self.solids])
        first, second = self._samples(points, reach)
        return Sides(first, second, self._local_reach(first, second, reach))

    def _spread(self, each: Sequence[float] | Sequence[Array]) -> Array:
        """Return something of every solid for its points."""
        if len(self.solids) == 1:
            return np.asarray(each[0])
        return np.repeat(np.array(each), np.diff(self.ends), axis=0)

    def _fall(self, points: Array, sides: Sequence[Implicit]) -> Array:
        """Return bounds of values outside, by the boxes."""
        low, high = (self._spread([side.bounds[k] for side in sides]) for k in (0, 1))
        return -_FALL * box_distance(points, (low, high))

    def _samples(self, points: Array, reach: Array) -> tuple[Sample, Sample]:
        firsts = [solid.first for solid in self.solids]
        seconds = [solid.second for solid in self.solids]
        operation = self.operation
        if operation == "intersect":
            return sample_each(firsts, points, self.ends), sample_each(seconds, points, self.ends)
        far = self._fall(points, seconds)
        if operation == "carve":
            first = sample_each(firsts, points, self.ends)
            wanted = far > -first.value - reach
            return first, _where(seconds, points, self.ends, far, wanted)
        near = self._fall(points, firsts)
        # The first is asked once: it may be a long chain, which two questions at every link
        # would make exponential.
        leads = near >= far
        second = _where(seconds, points, self.ends, far, ~leads)
        wanted = leads | (near > second.value - reach)
        first = _where(firsts, points, self.ends, near, wanted)
        late = leads & (far > first.value - reach)
        return first, _where(seconds, points, self.ends, far, late, second)

    def _local_reach(self, first: Sample, second: Sample, reach: Array) -> Array:
        """Return the reach of the blend (n,): that of the thinner solid there, below the largest.

        A smooth minimum, so that fillets narrow without a kink. It is what Gourmel et al. and
        MATISSE (Bernhardt et al., 2008) ask of a blend: not to wash out what is small.
        """
        if self.solids[0].blend <= 0.0:
            return np.zeros(len(first.value))
        blend = self._spread([solid.blend for solid in self.solids])
        narrow = reach / blend
        one, other = (np.minimum(narrow * s.curvature, _NARROWEST) for s in (first, second))
        for _ in range(_DOUBLINGS):
            one, other = one * one, other * other
        narrowed = 1.0 + (one + other)
        for _ in range(_DOUBLINGS):
            narrowed = np.sqrt(narrowed)
        return np.broadcast_to(reach / narrowed, len(first.value))


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


def _at(sample: Sample, chosen: Index) -> Sample:
    """Return a sample at some of its points."""
    value, gradient, curvature = sample
    if np.ndim(curvature):
        curvature = np.asarray(curvature)[chosen]
    return Sample(value[chosen], gradient[chosen], curvature)


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


def box_distance(points: Array, bounds: Array | tuple[Array, Array]) -> Array:
    """Return the distance (n,) of points (n, 3) from a box (2, 3), 0 inside; or each from its own.

    Boxes of their own are two arrays (n, 3), of low and high corners.
    """
    low, high = bounds
    beyond = np.maximum(np.maximum(low - points, points - high), 0.0)
    distance: Array = np.sqrt(np.einsum("ij,ij->i", beyond, beyond))
    return distance


def _where(
    solids: Sequence[Implicit],
    points: Array,
    ends: Index,
    bound: Array,
    wanted: Flags,
    known: Sample | None = None,
) -> Sample:
    """Sample solids where wanted; give what is known, or a bound of the value, elsewhere."""
    if wanted.all():
        return sample_each(solids, points, ends)
    if known is None:
        known = Sample(bound.copy(), np.zeros_like(points))
    curvature = np.broadcast_to(known.curvature, len(points)).copy()
    chosen = np.flatnonzero(wanted)
    if len(chosen):
        known.value[chosen], known.gradient[chosen], curvature[chosen] = sample_each(
            solids, points[chosen], np.searchsorted(chosen, ends)
        )
    return known._replace(curvature=curvature)
