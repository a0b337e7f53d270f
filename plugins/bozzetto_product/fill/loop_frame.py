"""The sides of a loop in a frame of unit size, as fills ask for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.plugin import cached_property
from bozzetto_product.fill.half_sides import Side
from bozzetto_product.fill.patch_space import SIDE_NODES, side_nodes
from bozzetto_product.fill.quadric import Quadric, quadric_through
from bozzetto_product.fill.quintic import DEGREE, bernstein, refinement

LEANING: Final = 0.05
"""Sine between the normals along the sides and those of a quadric, root mean square, up to which
they are about its own: in the middle of long sides those of corners are up to 5° off."""

LEANING_BY_ALONE: Final = 1.0 / 3000.0
"""The same by how many times farther off every other quadric is: one that is little alone is only
meant if the normals are its own."""


@dataclass(frozen=True, eq=False)
class LoopSides:
    """The sides of a loop in a frame of its own, of unit size about the origin.

    Parameters
    ----------
    sides : tuple of Side
    controls : (10 n, 3) float
        Control points of the polynomials nearest to the halves, in the order of `PatchSpace`.
    normals : (n, 2, 11, 3) float
        At the Gauss nodes of the halves; NaN where a side is a crease.
    origin : (3,) float
    size : float
        Diagonal of the box of the loop, mm.
    """

    sides: tuple[Side, ...]
    controls: Array
    normals: Array
    origin: Array
    size: float

    @classmethod
    def of(cls, sides: Sequence[Side]) -> LoopSides:
        """Bring sides into their own frame."""
        rows = []
        for side in sides:
            first, second = side.polynomials
            rows += [first, second[DEGREE - 1 : 0 : -1]]
        controls = np.concatenate(rows)
        origin = controls.mean(axis=0)
        size = float(np.linalg.norm(np.ptp(controls, axis=0)))
        size = size if size > 0.0 else 1.0
        normals = np.full((len(sides), 2, SIDE_NODES, 3), np.nan)
        for number, side in enumerate(sides):
            for half in range(2):
                found = side.halves[half].held_normals
                if found is not None:
                    normals[number, half] = found
        return cls(tuple(sides), (controls - origin) / size, normals, origin, size)

    @cached_property
    def slopes(self) -> Array:
        """Derivatives of the halves at the Gauss nodes, by their own parameters, (n, 2, 11, 3)."""
        at = side_nodes()[0]
        rows = [[half.value(at, 1) for half in side.halves] for side in self.sides]
        return np.array(rows) / self.size

    @cached_property
    def _places(self) -> Array:
        """Places of the halves themselves at the Gauss nodes, head to tail, (2 n, 11, 3)."""
        at = side_nodes()[0]
        rows = [half.value(at) for side in self.sides for half in side.halves]
        rows[1::2] = [row[::-1] for row in rows[1::2]]
        return (np.array(rows) - self.origin) / self.size

    @cached_property
    def rest(self) -> float:
        """How far the sides are from their polynomials, share of the size; 0 if they are some."""
        far = 0.0
        for side in self.sides:
            for half, polynomial in zip(side.halves, side.polynomials, strict=True):
                if not half.is_polynomial:
                    off = half.points - refinement(half.knots) @ polynomial
                    far = max(far, float(np.linalg.norm(off, axis=1).max()))
        return far / self.size

    @cached_property
    def quadric(self) -> Quadric | None:
        """The quadric on which all sides lie, if normals that are told along them are its own."""
        at, share = side_nodes()
        ring = np.concatenate((self.controls, self.controls[:1]))
        halves = ring[np.arange(0, len(ring) - 1, DEGREE)[:, None] + np.arange(DEGREE + 1)]
        lengths = np.linalg.norm(bernstein(at, 1) @ halves, axis=-1) * share
        places = (bernstein(at) @ halves).reshape(-1, 3)
        if not self.is_smooth:
            places = self._places.reshape(-1, 3)
        found = quadric_through(places, lengths.ravel())
        if found is None or not (self.is_smooth or found.is_exact):
            return None
        held = self.normals.copy()
        held[:, 1] = held[:, 1, ::-1]
        sine = np.linalg.norm(cross_product(found.normals(places), held.reshape(-1, 3)), axis=1)
        told = sine[np.isfinite(sine)]
        most = min(LEANING, LEANING_BY_ALONE * found.alone)
        return found if not len(told) or float(np.sqrt((told**2).mean())) <= most else None

    @cached_property
    def is_smooth(self) -> bool:
        """Whether normals are told along all sides."""
        return bool(np.isfinite(self.normals).all())
