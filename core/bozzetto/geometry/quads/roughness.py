"""Surfaces without the roughness of scans, which is finer than the squares that are laid over them.

Directions would follow it, and creases would be found everywhere. Real creases stay: normals are
averaged with those that are alike only, as in Zheng, Fu, Au and Tai 2011, *Bilateral normal
filtering for mesh denoising*; where even that finds too many of them, vertices go towards their
neighbours and back, which takes away what is short and keeps what is long: Taubin 1995, *A signal
processing approach to fair surface design*, section 3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.geometry.quads.surface import Edges, across, creases_of, edges_of, filtered_normals

if TYPE_CHECKING:
    from collections.abc import Callable

    from bozzetto.arrays import Array, Flags, Index

FEW: Final = 0.1
"""Length of the creases, in sides of squares, for each square that is wanted, up to which squares
follow them: on scans there are several times as many."""

LESS: Final = 0.5
"""Share of the creases that is left of roughness at most when it is faired; real ones stay."""

FORTH: Final = 0.5
BACK: Final = -0.53
"""Shares of the way towards the middle of its neighbours that a vertex goes in the two halves of a
round."""

ROUNDS: Final = 4
"""Rounds of fairing after which creases are looked for anew."""

MOST_TIMES: Final = 6
"""How often that is done at most."""

PASSES: Final = 3
"""How often normals are filtered."""

UPDATES: Final = 5
"""Rounds in which vertices follow filtered normals each time."""

MOVED: Final = 0.35
"""Distance by which vertices may have moved, in sides of squares: what is farther out is shape."""

NEARLY_ALL: Final = 0.95
"""Share of the vertices for which that holds: noise has outliers."""


def calmed(
    points: Array, faces: Index, count: int, side: float, checkpoint: Callable[[], None]
) -> Array:
    """Return vertices moved so that creases are hardly more than squares can follow, (n, 3).

    The points themselves where that holds already, where the creases are real, or where it would
    change the shape.

    Parameters
    ----------
    points : (n, 3) float
        Vertices.
    faces : (f, 3) int
        Triangles.
    count : int
        Squares that are wanted.
    side : float
        Of a square, in the unit of the points.
    checkpoint : callable
        Called between steps; may raise to stop.
    """
    edges = edges_of(faces)
    made, length = points, _length_of_creases(points, faces, edges)
    for _ in range(MOST_TIMES):
        checkpoint()
        if length <= FEW * count * side:
            break
        faired = _faired(made, edges)
        before, length = length, _length_of_creases(faired, faces, edges)
        if length > LESS * before:
            break
        made = faired
    near = np.linalg.norm(made - points, axis=1) <= MOVED * side
    return made if near.mean() >= NEARLY_ALL else points


def denoised(points: Array, faces: Index, checkpoint: Callable[[], None]) -> Array:
    """Return vertices moved to where triangles have filtered normals, (n, 3).

    Flat faces and their creases stay as they are. Vertices are updated as by Sun, Rosin, Martin
    and Langbein 2007, *Fast and effective feature-preserving mesh denoising*, equation 9.
    """
    edges = edges_of(faces)
    fixed = _on_border(points, edges)
    many = np.maximum(np.bincount(faces.ravel(), minlength=len(points)), 1)[:, None]
    made = points.copy()
    for _ in range(PASSES):
        checkpoint()
        normal = filtered_normals(across(made, faces), edges)
        for _ in range(UPDATES):
            to_middle = made[faces].mean(axis=1)[:, None] - made[faces]
            out = np.einsum("fj,fkj->fk", normal, to_middle)
            step = np.column_stack([
                np.bincount(faces.ravel(), (out * normal[:, axis, None]).ravel(), len(points))
                for axis in range(3)
            ])  # fmt: skip
            step[fixed] = 0.0
            made += step / many
    return made


def _length_of_creases(points: Array, faces: Index, edges: Edges) -> float:
    ends = edges.ends[creases_of(points, faces, edges)]
    return float(np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1).sum())


def _faired(points: Array, edges: Edges) -> Array:
    """Move vertices towards the middle of their neighbours and back; borders stay."""
    from scipy.sparse import coo_array

    i, j = edges.ends.T
    ones = np.ones(2 * len(i))
    beside: Any = coo_array((ones, (np.r_[i, j], np.r_[j, i])), (len(points), len(points))).tocsr()
    many = np.maximum(np.bincount(edges.ends.ravel(), minlength=len(points)), 1)[:, None]
    free = ~_on_border(points, edges)[:, None]
    made = points
    for _ in range(ROUNDS):
        for share in (FORTH, BACK):
            made = made + share * free * (beside @ made / many - made)
    return made


def _on_border(points: Array, edges: Edges) -> Flags:
    on = np.zeros(len(points), bool)
    on[edges.ends[(edges.faces[:, 1] < 0) | edges.crowded]] = True
    return on
