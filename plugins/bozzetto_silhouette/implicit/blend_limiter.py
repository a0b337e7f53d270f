"""Places where a blend is limited, because all of it would not fit there."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from bozzetto.arrays import Array

if TYPE_CHECKING:
    from scipy.spatial import cKDTree


_CORE = 0.5
"""Share of a place's radius within which all of it holds; from there it fades."""

_NEAREST = 8
"""Places that are asked for at a point: those beyond lie about as far as these, and no nearer."""


@dataclass(frozen=True, eq=False)
class BlendLimiter:
    """The share of a blend at every point: 1 except near some places.

    Attributes
    ----------
    places : (m, 3) float array
    radii : (m,) float array
        How far each is felt.
    shares : (m,) float array
        Of the blend that is left there.
    """

    places: Array
    radii: Array
    shares: Array

    @classmethod
    def none(cls) -> BlendLimiter:
        """Return a limiter that leaves the whole blend everywhere."""
        return cls(np.zeros((0, 3)), np.zeros(0), np.zeros(0))

    def share(self, points: Array) -> Array:
        """Return the share of the blend (n,) at points (n, 3): the least of the places near by."""
        if not len(self.places):
            return np.ones(len(points))
        count = min(_NEAREST, len(self.places))
        distance, index = self._tree.query(
            points, k=np.arange(1, count + 1), distance_upper_bound=float(self.radii.max())
        )
        near = np.isfinite(distance)
        index = np.where(near, index, 0)
        way = np.where(near, distance, np.inf) / self.radii[index]
        fade = np.clip((way - _CORE) / (1.0 - _CORE), 0.0, 1.0)
        fade = fade * fade * (3.0 - 2.0 * fade)
        least: Array = (self.shares[index] * (1.0 - fade) + fade).min(axis=1)
        return least

    def also(self, places: Array, radii: Array, shares: Array) -> BlendLimiter:
        """Add places; of those very close to each other one is kept."""
        cell = np.round(places / (_CORE * radii[:, None])).astype(np.int64)
        _, kept = np.unique(cell, axis=0, return_index=True)
        return BlendLimiter(
            np.vstack([self.places, places[kept]]),
            np.append(self.radii, radii[kept]),
            np.append(self.shares, shares[kept]),
        )

    def joined(self, other: BlendLimiter) -> BlendLimiter:
        """Add the places of another limiter."""
        if not len(other.places):
            return self
        return BlendLimiter(
            np.vstack([self.places, other.places]),
            np.append(self.radii, other.radii),
            np.append(self.shares, other.shares),
        )

    @property
    def signature(self) -> bytes:
        """Bytes that are equal for equal places, radii and shares."""
        return self.places.tobytes() + self.radii.tobytes() + self.shares.tobytes()

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self.places)
