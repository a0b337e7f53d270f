"""Kernels summed along a skeleton: what a convolution field needs to know of them.

Every sum is in units of the iso-value: 1 is the surface.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.implicit import scalis
from bozzetto_silhouette.implicit.kernels import Compact, InversePower, Kernel
from bozzetto_silhouette.model.state import Kernel as KernelName
from bozzetto_silhouette.outline.medial_axis import Skeleton

THINNEST = 2e-3
"""Smallest radius of a kernel, as a share of the longest side."""

CAUCHY_CORE = 0.5
"""Core of Cauchy's kernel in median radii, for softness 1: with the softness 1.4 it is the
0.7 that fitted a set of icons best."""

_CHUNK = 65536
"""Pairs of a point and a segment that are summed at a time."""


class Sums(Protocol):
    """The kernels of a skeleton's segments at points of the plane, whatever their height."""

    def shares(self, height2: Array) -> Array:
        """Return the field of each segment alone at the squared heights (n,); shape (n, s)."""
        ...

    def total(self, weights: Array, height2: Array, *, slope: bool) -> tuple[Array, Array | None]:
        """Return the weighted field (n,), and if asked for its derivative by the squared height."""
        ...

    def of(self, rows: Index) -> Sums:
        """Return the sums at some of the points, in ascending order."""
        ...


class Summation(Protocol):
    """Kernels along the segments of a skeleton."""

    def over(self, xy: Array) -> Sums:
        """Prepare the sums for points (n, 2) of the plane."""
        ...

    def level(self, total: Array, radius: Array) -> tuple[Array, Array]:
        """Convert a field to a level in squared radii; return that and its derivative by the field.

        On a cylinder of the given radius it is ``1 - (distance / radius)^2``.
        """
        ...


def summation_of(skeleton: Skeleton, name: KernelName, softness: float, widest: float) -> Summation:
    """Return the kernels of a given name along a skeleton.

    Parameters
    ----------
    skeleton : Skeleton
        In the frame of the sums.
    name : str
        The kernel, as a part names it.
    softness : float
        Reach of the kernel in radii: in those at hand for "scalis"; in the largest one for the
        compact kernels, in the median one (see `CAUCHY_CORE`) for Cauchy's. The pure powers
        have no length of their own.
    widest : float
        Largest radius that will be asked for.
    """
    if name == "scalis":
        return ScaleInvariant.of(skeleton, softness)
    radius = np.maximum(skeleton.nodes[:, 2], THINNEST)
    reach = softness * max(float(radius.max()), widest)
    kernels: dict[KernelName, Kernel] = {
        "cauchy": InversePower(4, float(CAUCHY_CORE * softness * np.median(radius)) ** 2),
        "inverse-cubic": InversePower(3),
        "inverse-quartic": InversePower(4),
        "quartic": Compact(2, reach),
        "sextic": Compact(3, reach),
    }
    return LineSummation.of(skeleton, kernels[name])


# -- the default: the radius sits inside the kernel ------------------------------------------------


@dataclass(frozen=True, eq=False)
class ScaleInvariant:
    """The compact sextic of SCALIS."""

    segments: scalis.Segments

    @classmethod
    def of(cls, skeleton: Skeleton, softness: float) -> ScaleInvariant:
        """Return the kernels along a skeleton, with a support of `softness` radii."""
        return cls(scalis.Segments.of(skeleton, softness, THINNEST))

    def over(self, xy: Array) -> Sums:
        """Sort points and segments into pairs within reach."""
        pairs = scalis.pairs_within_reach(xy, self.segments)
        return _ScaleInvariantSums(self.segments, pairs, len(xy))

    def level(self, total: Array, radius: Array) -> tuple[Array, Array]:
        """Return the level, which does not depend on the radius, and its derivative."""
        room = self.segments.sigma**2 - 1.0
        return room * (total ** (2.0 / 7.0) - 1.0), room * (2.0 / 7.0) * total ** (-5.0 / 7.0)


@dataclass(frozen=True, eq=False)
class _ScaleInvariantSums:
    segments: scalis.Segments
    pairs: scalis.Pairs
    count: int

    def shares(self, height2: Array) -> Array:
        value, _ = scalis.segment_integrals(self.segments, self.pairs, height2)
        matrix = np.zeros((self.count, len(self.segments)))
        matrix[self.pairs.point, self.pairs.segment] = value
        return matrix / scalis.iso_value(self.segments.sigma)

    def total(self, weights: Array, height2: Array, *, slope: bool) -> tuple[Array, Array | None]:
        value, change = scalis.segment_integrals(self.segments, self.pairs, height2, slope=slope)
        weight = weights[self.pairs.segment] / scalis.iso_value(self.segments.sigma)
        total: Array = np.bincount(self.pairs.point, value * weight, self.count).astype(float)
        if change is None:
            return total, None
        return total, np.bincount(self.pairs.point, change * weight, self.count).astype(float)

    def of(self, rows: Index) -> Sums:
        return _ScaleInvariantSums(self.segments, self.pairs.of(rows, self.count), len(rows))


# -- the papers': the radius sits in a weight that is linear along the segment ---------------------


@dataclass(frozen=True, eq=False)
class LineSummation:
    """A kernel in closed form, with local weights.

    Each end of a segment has the weight with which an endless line would have its surface at
    the radius there: the papers' local step. What is fitted later multiplies it.

    Attributes
    ----------
    kernel : Kernel
    start, direction : (s, 2) float arrays
        First end and unit direction.
    length, weight, slope : (s,) float arrays
        Length, weight at the first end, and its change per length.
    """

    kernel: Kernel
    start: Array = field(repr=False)
    direction: Array = field(repr=False)
    length: Array = field(repr=False)
    weight: Array = field(repr=False)
    slope: Array = field(repr=False)

    @classmethod
    def of(cls, skeleton: Skeleton, kernel: Kernel) -> LineSummation:
        """Return the kernels along a skeleton; radii below `THINNEST` are raised to it."""
        a, b = skeleton.nodes[skeleton.edges.T]
        span = (b - a)[:, :2]
        length = np.maximum(np.hypot(*span.T), 1e-12)
        begin, end = (1.0 / kernel.cylinder(np.maximum(n[:, 2], THINNEST)) for n in (a, b))
        return cls(kernel, a[:, :2], span / length[:, None], length, begin, (end - begin) / length)

    def over(self, xy: Array) -> Sums:
        """Return the sums at points (n, 2): all segments reach everywhere."""
        return _LineSums(self, xy)

    def level(self, total: Array, radius: Array) -> tuple[Array, Array]:
        """Return the level by the kernel's own root of the field, and its derivative."""
        level, rise = self.kernel.level(total)
        unit = self.kernel.square(radius) / np.square(radius)
        return unit * level, unit * rise


@dataclass(frozen=True, eq=False)
class _LineSums:
    lines: LineSummation
    xy: Array

    def shares(self, height2: Array) -> Array:
        return np.concatenate(
            [self._tables(part, height2, slope=False)[0] for part in self._parts()]
        )

    def total(self, weights: Array, height2: Array, *, slope: bool) -> tuple[Array, Array | None]:
        sums = [
            [table @ weights for table in self._tables(part, height2, slope=slope)]
            for part in self._parts()
        ]
        total, *change = (np.concatenate(column) for column in zip(*sums, strict=True))
        return total, change[0] if slope else None

    def of(self, rows: Index) -> Sums:
        return _LineSums(self.lines, self.xy[rows])

    def _parts(self) -> list[slice]:
        rows = max(1, _CHUNK // max(len(self.lines.length), 1))
        return [slice(k, k + rows) for k in range(0, max(len(self.xy), 1), rows)]

    def _tables(self, part: slice, height2: Array, *, slope: bool) -> list[Array]:
        """Return the field of each segment, and if asked for its slope by the squared height."""
        lines, shape = self.lines, (len(self.xy[part]), len(self.lines.length))
        offset = self.xy[part][:, None, :] - lines.start
        along = (offset * lines.direction).sum(axis=2)
        across = offset[..., 0] * lines.direction[:, 1] - offset[..., 1] * lines.direction[:, 0]
        d2 = (across**2 + height2[part, None]).ravel()
        weight = lines.weight + lines.slope * along
        interval = (-along.ravel(), (lines.length - along).ravel(), d2)
        moments = [lines.kernel.moments(*interval)]
        if slope:
            moments.append(lines.kernel.falls(*interval))
        return [
            weight * zeroth.reshape(shape) + lines.slope * first.reshape(shape)
            for zeroth, first in moments
        ]
