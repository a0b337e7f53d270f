"""The surface of a loop: what all its forms have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from operator import itemgetter
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.geometry import Brep, BSplineSurface, Mesh
from bozzetto.plugin import cached_property
from bozzetto_product.fill.fill_mesh import piece_samples, radius_ratios, segments_of
from bozzetto_product.fill.half_sides import HalfSide, Side
from bozzetto_product.network.net import Loop

if TYPE_CHECKING:
    from bozzetto_product.fill.patch_fill import PatchFill

CUT: Final = -1
"""Half edge of the pieces of a cut between two parts of a loop, which are of none of its edges."""

CHECKS: Final = 33
"""Places along half a side at which joints and deviations are measured."""


@dataclass(frozen=True, eq=False)
class Fill(ABC):
    """The surface of a loop: a `PlaneFill` or a `PatchFill`.

    Parameters
    ----------
    loop : Loop
    sides : tuple of Side
        Those of the domain.
    patches : tuple of BSplineSurface
        What it is made of, one for each face of `brep`; their normals point to where the loop
        runs counter-clockwise.
    spacing : float
        Length of the segments of edges in the mesh, mm.
    key : bytes
        Of all that the surface depends on.
    """

    loop: Loop
    sides: tuple[Side, ...]
    patches: tuple[BSplineSurface, ...]
    spacing: float
    key: bytes

    @property
    @abstractmethod
    def size(self) -> float:
        """Diagonal of the box of the loop, mm."""

    @property
    @abstractmethod
    def mesh(self) -> Mesh:
        """Triangles with normals; vertices on an edge are those of all fills that have it."""

    @property
    @abstractmethod
    def brep(self) -> Brep:
        """Exact faces; the edges are first the pieces of the loop's edges."""

    @property
    @abstractmethod
    def folded(self) -> bool:
        """Whether normals of places beside one another point to opposite sides."""

    @property
    @abstractmethod
    def bent(self) -> PatchFill | None:
        """The same surface as patches, which can be bent; None where these would fold."""

    @property
    def has_holes(self) -> bool:
        """Whether it has more outlines than one."""
        return False

    @abstractmethod
    def places_beside(self, half: HalfSide, number: int, at: Array) -> tuple[Array, Array]:
        """Return places of the surface beside half a side, and unit normals there, (n, 3) each.

        Parameters
        ----------
        half : HalfSide
            One of the loop's.
        number : int
            Of the corner at which it begins.
        at : (n,) float
            Parameters of the half.
        """

    @property
    def g1_degrees(self) -> tuple[float, ...]:
        """Largest angle between the surface and the normals of each half edge; NaN at creases."""
        return self._off_normals[:-1]

    @property
    def cut_degrees(self) -> float:
        """The same angle along cuts between parts of a loop; NaN where there are none."""
        return self._off_normals[CUT]

    @cached_property
    def _off_normals(self) -> tuple[float, ...]:
        worst = np.full(len(self.loop) + 1, np.nan)
        for half, number, at in self._halves():
            normals = half.normals(at)
            if normals is None:
                continue
            _, found = self.places_beside(half, number, at)
            sine = np.linalg.norm(cross_product(found, normals), axis=1)
            angle = np.degrees(np.arctan2(sine, np.abs((found * normals).sum(axis=1))))
            which = np.clip(np.searchsorted(half.breaks, at, "right") - 1, 0, len(half.pieces) - 1)
            for index, piece in enumerate(half.pieces):
                most = float(angle[which == index].max(initial=0.0))
                worst[piece.half_edge] = np.fmax(worst[piece.half_edge], most)
        return tuple(worst.tolist())

    def normals_along(self, half_edge: int, count: int | None = None) -> Array:
        """Return unit normals of the surface along an edge, in the edge's own sense.

        Parameters
        ----------
        half_edge : int
            Which of the loop's.
        count : int, optional
            Places on each piece of the edge, with both of its ends; by default those of the
            vertices of the mesh.

        Returns
        -------
        (k, 3) float
            At the same places of the edge for every fill that has it.
        """
        found: list[tuple[float, Array]] = []
        for half, number, _ in self._halves():
            for index, piece in enumerate(half.pieces):
                if piece.half_edge != half_edge:
                    continue
                low, high = half.breaks[index : index + 2]
                if count is None:
                    segments = segments_of(piece.piece, self.spacing)
                    shares, _ = piece_samples(piece.piece, segments)
                else:
                    shares = np.linspace(0.0, 1.0, count)
                own = shares if piece.forward == half.onward else 1.0 - shares
                _, normals = self.places_beside(half, number, low + (high - low) * own)
                found.append((piece.piece.curve.range[0], normals))
        return np.concatenate([normals for _, normals in sorted(found, key=itemgetter(0))])

    @cached_property
    def deviation(self) -> float:
        """Largest distance of the surface from the edges where they meet, mm."""
        worst = 0.0
        for half, number, at in self._halves():
            off = self.places_beside(half, number, at)[0] - half.value(at)
            worst = max(worst, float(np.linalg.norm(off, axis=1).max()))
        return worst

    def _halves(self) -> list[tuple[HalfSide, int, Array]]:
        at = np.linspace(0.0, 1.0, CHECKS)
        count = len(self.sides)
        return [
            (half, (number + index) % count, at)
            for number, side in enumerate(self.sides)
            for index, half in enumerate(side.halves)
        ]

    @cached_property
    def area(self) -> float:
        """Area of the mesh, mm²."""
        corners = self.mesh.vertices.astype(np.float64)[self.mesh.faces]
        across = cross_product(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        return float(0.5 * np.linalg.norm(across, axis=1).sum())

    @cached_property
    def _qualities(self) -> Array:
        return radius_ratios(self.mesh)

    @property
    def quality_min(self) -> float:
        """Least radius ratio 2 r / R of the mesh's triangles."""
        return float(self._qualities.min())

    @property
    def quality_p5(self) -> float:
        """Radius ratio that 95 % of the mesh's triangles exceed."""
        return float(np.percentile(self._qualities, 5))
