"""The surface of a loop as in the paper: triangles, and nothing that CAD takes as a surface."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto.geometry import Mesh
from bozzetto.plugin import cached_property, remembered
from bozzetto_product.fill.edge_pieces import EdgePiece
from bozzetto_product.fill.fill_mesh import piece_samples, segments_of
from bozzetto_product.network.net import Loop
from bozzetto_product.paper.triangulation import Triangles, inner_edges, triangulated
from bozzetto_product.paper.v_spring import Relaxed, relaxed, vertex_normals


@dataclass(frozen=True, eq=False)
class PaperSurface:
    """Triangles through the curves of a loop.

    Parameters
    ----------
    loop : Loop
        What it is of.
    triangles : Triangles
        The border begins at the start of the loop and runs as the loop does.
    starts : (k + 1,) int
        The first point of the border on each half edge, and the number of all.
    """

    loop: Loop
    triangles: Triangles
    starts: Index

    @cached_property
    def normals(self) -> Array:
        """Unit normals of the vertices, from this surface's triangles only, (n, 3)."""
        return vertex_normals(self.triangles.points, self.triangles.faces)

    @cached_property
    def mesh(self) -> Mesh:
        """The triangles with normals; neighbours have the same vertices on their edges."""
        return Mesh(
            self.triangles.points.astype(np.float32),
            self.triangles.faces.astype(np.int32),
            self.normals.astype(np.float32),
        )

    @cached_property
    def area(self) -> float:
        """Area of the triangles, mm²."""
        return float(np.linalg.norm(_across(self.triangles), axis=1).sum() / 2.0)

    @cached_property
    def folded(self) -> bool:
        """Whether two triangles beside one another look to opposite sides."""
        across = _across(self.triangles)
        one, two = inner_edges(self.triangles.faces).faces.T
        return bool(((across[one] * across[two]).sum(axis=1) < 0.0).any())

    def border_of(self, half_edge: int) -> Index:
        """Return the points of the border along an edge, both ends included, in its own sense."""
        low, high = self.starts[half_edge : half_edge + 2]
        numbers = np.arange(low, high + 1) % self.triangles.border
        return numbers if self.loop[half_edge][1] else numbers[::-1]


def _across(triangles: Triangles) -> Array:
    a, b, c = (triangles.points[triangles.faces[:, k]] for k in range(3))
    return cross_product(b - a, c - a)


def border_points(
    loop: Loop, pieces: Sequence[Sequence[EdgePiece]], spacing: float
) -> tuple[Array, Index]:
    """Return points once round a loop, and the first one on each half edge.

    Parameters
    ----------
    loop : Loop
        Head to tail.
    pieces : sequence of sequence of EdgePiece
        Of each half edge of the loop, in the sense of its edge.
    spacing : float
        Length between points, mm.

    Returns
    -------
    points : (b, 3) float
        mm; the same numbers for every loop that has the edge.
    starts : (k + 1,) int
    """
    rows = []
    for (_, forward), own in zip(loop, pieces, strict=True):
        found = [piece_samples(piece, segments_of(piece, spacing))[1] for piece in own]
        line = np.concatenate([places[:-1] for places in found] + [found[-1][-1:]])
        rows.append((line if forward else line[::-1])[:-1])
    starts = np.cumsum([0, *(len(row) for row in rows)])
    return np.concatenate(rows), starts


@remembered(limit=1024)
def paper_surface(
    loop: Loop, pieces: tuple[tuple[EdgePiece, ...], ...], spacing: float
) -> PaperSurface:
    """Return the surface of a loop: triangulated, then relaxed by the V-spring.

    Parameters
    ----------
    loop, pieces, spacing
        See `border_points`.
    """
    points, starts = border_points(loop, pieces, spacing)
    made = triangulated(points, spacing)
    found = evened(made)
    return PaperSurface(loop, Triangles(found.points, made.faces, made.border), starts)


def evened(triangles: Triangles) -> Relaxed:
    """Return the inner points of triangles after the V-spring; the border is held."""
    freedom = np.ones(len(triangles.points))
    freedom[: triangles.border] = 0.0
    return relaxed(triangles.points, triangles.faces, freedom)
