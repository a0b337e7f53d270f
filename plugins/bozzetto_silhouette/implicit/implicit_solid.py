"""Solids as functions of space: what all kinds of surface have in common.

Whatever a shape was made by, blends, normals and tests see it only through this: a number
that is about the signed distance to its surface, positive inside, and its gradient.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.geometry import Placement
from bozzetto.plugin import cached_property, override


class Sample(NamedTuple):
    """An implicit solid at n points.

    Attributes
    ----------
    value : (n,) float array
        About the distance to the surface, positive inside, in units of length.
    gradient : (n, 3) float array
        Of the value: it points inwards and is about a unit vector near the surface.
    curvature : (n,) float array or float
        One over the radius of the ball that fits there, about: how thin the solid is. 0 where
        it is flat, or nothing is known.
    """

    value: Array
    gradient: Array
    curvature: Array | float = 0.0


class Implicit(Protocol):
    """A solid as a function of space.

    The zero set of `value` is the surface; near it the value is the signed distance, to a few
    per cent within a tenth of the local radius. Inside it grows up to about the local radius;
    outside it falls monotonically with the distance and never falls short of it by more than
    a factor of two. It is finite everywhere.

    Attributes
    ----------
    bounds : (2, 3) float array
        A box around the solid.
    """

    @property
    def bounds(self) -> Array:
        """The box."""
        ...

    def value(self, points: Array) -> Array:
        """Return the values at points (n, 3)."""
        ...

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3)."""
        ...


class Batched(ABC):
    """An implicit solid of which many of one kind are sampled as one batch."""

    @property
    @abstractmethod
    def kind(self) -> Hashable:
        """Key that is equal for solids that can be sampled at once."""

    @staticmethod
    @abstractmethod
    def sample_row(solids: Sequence[Implicit], points: Array, ends: Index) -> Sample:
        """Sample solids of one kind, each at points of its own, as `sample_each` does."""


@dataclass(frozen=True, eq=False)
class Placed(Batched):
    """An implicit solid that was moved, turned, scaled or mirrored."""

    inner: Implicit
    placement: Placement

    @property
    @override
    def kind(self) -> Hashable:
        """Key that is equal for solids that can be sampled at once."""
        return Placed

    @staticmethod
    @override
    def sample_row(solids: Sequence[Implicit], points: Array, ends: Index) -> Sample:
        """Sample solids of this kind, each at points of its own, as `sample_each` does."""
        number = {solid: k for k, solid in enumerate(dict.fromkeys(solids))}
        placed = [solid for solid in number if isinstance(solid, Placed)]
        own = np.repeat([number[solid] for solid in solids], np.diff(ends))
        back = np.array([solid.inward for solid in placed])
        inside = _moved(back, own, points) + back[:, :, 3].take(own, axis=0)
        inner = [solid.inner for solid in solids if isinstance(solid, Placed)]
        found = sample_each(inner, inside, ends)
        scale = np.array([solid.placement.scale for solid in placed]).take(own)
        turns = np.array([solid.placement.rotation for solid in placed]).reshape(-1, 3, 3)
        return Sample(
            found.value * scale, _moved(turns, own, found.gradient), found.curvature / scale
        )

    @cached_property
    def bounds(self) -> Array:
        """The box around the moved box."""
        low, high = self.inner.bounds
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1])
                            for z in (low[2], high[2])])  # fmt: skip
        moved = self.placement.points(corners)
        return np.stack([moved.min(axis=0), moved.max(axis=0)])

    @cached_property
    def _back(self) -> Placement:
        return self.placement.inverse()

    @cached_property
    def inward(self) -> Array:
        """The matrix (3, 4) that takes points into the inner frame."""
        back = self._back
        turn = back.scale * np.reshape(back.rotation, (3, 3))
        return np.column_stack([turn, back.offset])

    def value(self, points: Array) -> Array:
        """Return the values at points (n, 3)."""
        return self.inner.value(self._back.points(points)) * self.placement.scale

    def sample(self, points: Array) -> Sample:
        """Return the values and gradients at points (n, 3)."""
        value, gradient, curvature = self.inner.sample(self._back.points(points))
        scale = self.placement.scale
        return Sample(value * scale, self.placement.directions(gradient), curvature / scale)


def _moved(matrices: Array, own: Index, vectors: Array) -> Array:
    """Multiply vectors (n, 3), each by the matrix with a number (n,); these are (s, 3, 3 or 4)."""
    x, y, z = np.ascontiguousarray(vectors.T)
    result = np.empty_like(vectors)
    for k in range(3):
        one, two, three = (np.ascontiguousarray(matrices[:, k, j]).take(own) for j in range(3))
        result[:, k] = one * x + two * y + three * z
    return result


def sample_each(solids: Sequence[Implicit], points: Array, ends: Index) -> Sample:
    """Sample several solids, each at points of its own; what they have in common is asked once.

    Parameters
    ----------
    solids : sequence of Implicit
        Any kinds.
    points : (n, 3) float array
        Those of all solids in a row.
    ends : (s + 1,) int array
        The points of solid k are those from ``ends[k]`` up to ``ends[k + 1]``.
    """
    if len(solids) == 1:
        return solids[0].sample(points)
    alike: dict[Hashable, list[int]] = {}
    for k, solid in enumerate(solids):
        if ends[k] < ends[k + 1]:
            kind: Hashable = solid.kind if isinstance(solid, Batched) else id(solid)
            alike.setdefault((type(solid), kind), []).append(k)
    if len(alike) == 1:
        (members,) = alike.values()
        return _alike([solids[k] for k in members], points, np.unique(ends))
    count = len(points)
    value, gradient, curvature = np.empty(count), np.empty((count, 3)), np.empty(count)
    for members in alike.values():
        at = np.concatenate([np.arange(ends[k], ends[k + 1]) for k in members])
        own_ends = np.cumsum([0, *(ends[k + 1] - ends[k] for k in members)])
        found = _alike([solids[k] for k in members], points[at], own_ends)
        value[at], gradient[at], curvature[at] = found
    return Sample(value, gradient, curvature)


def _alike(solids: Sequence[Implicit], points: Array, ends: Index) -> Sample:
    """Sample solids of one kind, or the same solid several times."""
    if len(solids) > 1 and isinstance(solids[0], Batched):
        return solids[0].sample_row(solids, points, ends)
    return solids[0].sample(points)
