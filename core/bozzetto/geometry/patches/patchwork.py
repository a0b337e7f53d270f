"""A skin of bicubic patches that know which edges they share: what CAD calls a shell of faces."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import frozen
from bozzetto.geometry.look import Look
from bozzetto.geometry.patches.coons import (
    boundaries,
    coons_nets,
    edge_numbers,
    sides_of,
    with_boundaries,
)
from bozzetto.geometry.patches.patch import turned_over

if TYPE_CHECKING:
    from bozzetto.geometry.placement import Placement

TURNED_SIDES = (0, 3, 2, 1)
"""New order of a patch's sides after u is reversed; all of them change their sense."""


@dataclass(frozen=True, eq=False)
class Patchwork:
    """Bicubic Bézier patches joined along shared edges, exact wherever they are handed over.

    Parameters
    ----------
    nets : (k, 4, 4, 3) float64
        Control nets, mm, ``k >= 1``; x_u × x_v points outward.
    edges : (m, 4, 3) float64
        Cubic Bézier curves, mm.
    sides : (k, 4) int32
        The edges round each patch, ``e`` or ``~e``: see `bozzetto.geometry.patches.coons`. An edge
        belongs to one patch (it lies on the *rim*) or to two, which run it in opposite senses.
    name : str
    color : (r, g, b), optional
        sRGB.
    patch_names : tuple of str, optional
        One for each patch, or none at all.
    patch_looks : tuple of Look, optional
        One for each patch, or none at all.

    Raises
    ------
    ValueError
        If arrays do not belong together: a net does not end in its edges bit for bit, or an
        edge is run twice in the same sense.
    """

    nets: NDArray[np.float64]
    edges: NDArray[np.float64]
    sides: NDArray[np.int32]
    name: str = "skin"
    color: tuple[int, int, int] | None = None
    patch_names: tuple[str, ...] = ()
    patch_looks: tuple[Look, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "nets", frozen(self.nets, np.float64))
        object.__setattr__(self, "edges", frozen(self.edges, np.float64))
        object.__setattr__(self, "sides", frozen(self.sides, np.int32, 4))
        if self.nets.shape != (len(self.sides), 4, 4, 3):
            raise ValueError("a patchwork needs a net of 4 × 4 points for every four sides")
        if self.edges.ndim != 3 or self.edges.shape[1:] != (4, 3):
            raise ValueError("the edges of a patchwork are of four points each")
        numbers = edge_numbers(self.sides)
        if not len(numbers):
            raise ValueError("a patchwork needs a patch")
        if numbers.max() >= len(self.edges):
            raise ValueError("a side names an edge that does not exist")
        if len(np.unique(self.sides)) < self.sides.size:
            raise ValueError("an edge is run twice in the same sense")
        if not np.array_equal(sides_of(self.nets), boundaries(self.edges, self.sides)):
            raise ValueError("a patch does not end in its edges")
        if self.patch_names and len(self.patch_names) != len(self.sides):
            raise ValueError("a patchwork needs a name for every patch, or none")
        if self.patch_looks and len(self.patch_looks) != len(self.sides):
            raise ValueError("a patchwork needs a look for every patch, or none")

    @classmethod
    def of_edges(
        cls,
        edges: ArrayLike,
        sides: ArrayLike,
        name: str = "skin",
        color: tuple[int, int, int] | None = None,
        patch_names: tuple[str, ...] = (),
    ) -> Patchwork:
        """Return the Coons patches between edges (`coons_nets`)."""
        nets = coons_nets(edges, sides)
        return cls(nets, np.asarray(edges, float), np.asarray(sides), name, color, patch_names)

    @property
    def rim(self) -> NDArray[np.intp]:
        """Edges of one patch, in order of their numbers, (r,)."""
        numbers, counts = np.unique(edge_numbers(self.sides), return_counts=True)
        return np.asarray(numbers[counts == 1], np.intp)

    @property
    def pieces(self) -> tuple[NDArray[np.intp], ...]:
        """Patches of each part that is connected by edges."""
        numbers = edge_numbers(self.sides)
        least = np.arange(len(numbers))
        while True:
            of_edge = np.full(len(self.edges), len(numbers))
            np.minimum.at(of_edge, numbers, np.broadcast_to(least[:, None], numbers.shape))
            low = of_edge[numbers].min(axis=1)
            if np.array_equal(low, least):
                return tuple(np.flatnonzero(least == first) for first in np.unique(least))
            least = low

    @property
    def nodes(self) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Places in which edges end.

        Returns
        -------
        places : (n, 3) float
            mm, each once.
        ends : (m, 2) int
            Where each edge starts and ends.
        """
        places, ends = np.unique(
            self.edges[:, [0, 3]].reshape(-1, 3) + 0.0, axis=0, return_inverse=True
        )
        return places, np.asarray(ends, np.intp).reshape(-1, 2)

    def placed(self, placement: Placement) -> Patchwork:
        """Return the patchwork moved by a placement; inside out where the placement mirrors."""
        if placement.is_identity:
            return self
        edges = placement.points(self.edges).reshape(self.edges.shape)
        nets = placement.points(self.nets).reshape(self.nets.shape)
        sides = self.sides
        if placement.mirrors:
            nets, sides = turned_over(nets), ~sides[:, TURNED_SIDES]
        return replace(self, nets=with_boundaries(nets, edges, sides), edges=edges, sides=sides)
