"""Depths of the corners up to an affine map, from parallel lines and planar faces.

Both are affine facts: if depths z agree with them, so do a z + b x + c y + d. What is left of z
after these is the singular vector of the smallest singular value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses

FREE: Final = 0.25
"""Singular value below which a change of the depths is left open: what lines and faces hold has 0.5
and more, what only the hand holds 0.13 at most."""

MOST_FREE: Final = 2
"""Changes of the depths that are told, at most."""

ROUNDS: Final = 3
"""Solutions, each with the lines of a wrong class weighted down by the one before."""


@dataclass(frozen=True, eq=False)
class AffineDepth:
    """Depths of some corners.

    Parameters
    ----------
    depths : (n,) float64
        For all corners of the drawing, 0 for those that take no part; unit length.
    residual : float
        The smallest singular value: how far lines and faces are from agreeing.
    gap : float
        The singular value after it; if it is as small, the depths are not determined.
    basis : (n, 1 + j) float64
        Depths that agree with lines and faces, and j of which any multiple may be added: the height
        of a pyramid on a box. These are 0 on as many corners as can be.
    """

    depths: Array
    residual: float
    gap: float
    basis: Array


def affine_depth(
    drawing: Drawing,
    classes: ParallelClasses,
    corners: Sequence[int],
    faces: Sequence[Rings],
) -> AffineDepth:
    """Find the depths of one connected part of a drawing.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    corners : sequence of int
        Of the part, at least three.
    faces : sequence of Rings
        Faces of the part that are planar.

    Notes
    -----
    Rows: for each line z_b - z_a = s_c u_c . (q_b - q_a), with the slope s_c of its class, which is
    eliminated; for each face of k corners the k - 3 affine dependencies of its places.
    """
    rows = _LineRows.of(drawing, classes, corners)
    planar = face_rows(drawing.points, corners, faces)
    free = _free_basis(drawing.points[list(corners)])
    weights = np.ones(len(rows.along))
    members = list(corners)
    depths = np.zeros(len(drawing.points))
    values, least = np.zeros(2), np.zeros((len(corners), 1))
    for _ in range(ROUNDS):
        values, least = _solution(rows.eliminated(weights), planar, free)
        depths[members] = least[:, 0]
        weights = rows.weights(least[:, 0], drawing.noise)
    basis = np.zeros((len(depths), least.shape[1]))
    basis[members] = _sparse(drawing.points[members], rows.ends, least)
    return AffineDepth(depths, float(values[0]), float(values[1]), basis)


def face_rows(points: Array, corners: Sequence[int], faces: Sequence[Rings]) -> Array:
    """Return rows that vanish on depths for which every face is planar, (r, len(corners))."""
    column = {corner: place for place, corner in enumerate(corners)}
    found = [np.zeros((0, len(corners)))]
    for face in faces:
        members = [corner for ring in face for corner in ring]
        if len(members) < 4:
            continue
        places = np.column_stack((np.ones(len(members)), points[members]))
        dependencies = np.linalg.svd(places.T)[2][3:]
        rows = np.zeros((len(dependencies), len(corners)))
        rows[:, [column[corner] for corner in members]] = dependencies
        found.append(rows)
    return np.vstack(found)


@dataclass(frozen=True, eq=False)
class _LineRows:
    """Lines of one part: their ends among its corners, classes, and runs along their class."""

    ends: Index
    labels: Index
    along: Array
    corners: int

    @classmethod
    def of(cls, drawing: Drawing, classes: ParallelClasses, corners: Sequence[int]) -> _LineRows:
        column = np.full(len(drawing.points), -1)
        column[list(corners)] = np.arange(len(corners))
        member = np.flatnonzero(column[drawing.lines[:, 0]] >= 0)
        labels = classes.labels[member]
        along = (drawing.spans[member] * classes.directions[labels]).sum(1)
        ends = column[drawing.lines[member]]
        return cls(ends, np.unique(labels, return_inverse=True)[1], along, len(corners))

    def eliminated(self, weights: Array) -> Array:
        """Rows for the depths alone, the slopes of the classes being taken out."""
        count, number = len(self.along), np.arange(len(self.along))
        depth = np.zeros((count, self.corners))
        depth[number, self.ends[:, 1]] = weights
        depth[number, self.ends[:, 0]] = -weights
        slope = np.zeros((count, int(self.labels.max(initial=-1)) + 1))
        slope[number, self.labels] = self.along * weights
        norms = np.linalg.norm(slope, axis=0)
        slope /= np.where(norms > 0, norms, 1.0)
        return np.asarray(depth - slope @ (slope.T @ depth))

    def weights(self, depths: Array, noise: float) -> Array:
        """Smaller weights for lines that differ from the median slope of their class."""
        rise = depths[self.ends[:, 1]] - depths[self.ends[:, 0]]
        along = np.where(np.abs(self.along) < 1e-9, 1e-9, self.along)
        slopes = rise / along
        medians = np.array(
            [np.median(slopes[self.labels == each]) for each in range(self.labels.max() + 1)]
        )
        off = np.abs(rise - medians[self.labels] * along)
        return np.asarray(1.0 / (1.0 + (off / max(3.0 * noise, 0.03) / 0.7) ** 2))


def _free_basis(points: Array) -> Array:
    """Orthonormal basis of depths without a part that is constant or linear, (n, n - 3)."""
    trivial = np.column_stack((np.ones(len(points)), points))
    return np.linalg.svd(trivial)[0][:, 3:]


def _solution(lines: Array, planar: Array, free: Array) -> tuple[Array, Array]:
    """Both smallest singular values, and depths of unit length that agree best, (n, 1 + j)."""
    if free.shape[1] == 0:
        return np.zeros(2), np.zeros((len(free), 1))
    rows = np.vstack((lines, planar)) @ free
    _, values, vectors = np.linalg.svd(rows, full_matrices=True)
    padded = np.zeros(free.shape[1])
    padded[: len(values)] = values
    smallest = np.append(padded[::-1], 1.0)
    open_ones = int((smallest[1:-1] < FREE).sum())
    count = 1 + open_ones if open_ones <= MOST_FREE else 1
    return smallest[:2], np.asarray(free @ vectors[::-1][:count].T)


def _sparse(points: Array, ends: Index, least: Array) -> Array:
    """Return a basis of the same depths of which all but the first are 0 at most corners.

    What vanishes at a corner of three lines and at their other ends, vanishes on all that hangs
    together with it; of all corners, the one is taken by which the most do.
    """
    count = least.shape[1]
    if count == 1:
        return least
    every = np.column_stack((least, np.ones(len(points)), points))
    best: tuple[float, Array] | None = None
    for corner in range(len(points)):
        beside = ends[(ends == corner).any(1)]
        three = beside[beside != corner][:3]
        if len(three) < 3:
            continue
        mixed = np.linalg.svd(every[[corner, *three]], full_matrices=True)[2][4:]
        size = np.linalg.norm(every @ mixed.T, axis=1)
        still = float((1.0 / (1.0 + (size / (0.1 * size.max())) ** 2)).sum())
        if best is None or still > best[0]:
            best = still, mixed
    if best is None:
        return least[:, :1]
    changes = every @ best[1].T
    changes /= np.abs(changes).max(0)
    rest = least @ np.linalg.svd(best[1][:, :count])[2][-1]
    rest -= changes @ np.linalg.lstsq(changes, rest, rcond=None)[0]
    return np.column_stack((rest, changes))
