"""Depths of a part that no line joins to a body, told by its lines, its faces and its seats.

Lines of the part have the slopes of the body's parallel ones, and its faces are planes; a ring that
lies in a face of the body is as deep as this. Where both ends of a hole lie in faces these tell the
slope of its sides, too, which need not be that of any line of the body: how much it costs to give
up that they look parallel to one is a likelihood ratio.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.affine_depth import face_rows
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.lifting import Lifting
from bozzetto_polyhedron.reconstruction.parallel_classes import (
    HAND,
    ParallelClasses,
    angle_between,
)
from bozzetto_polyhedron.reconstruction.regularity import area_vector

GAP: Final = 0.7
"""Standard deviation of how far a ring that lies in a face is drawn from it, in units of the noise
of a corner, in 120 drawings of holes."""

FREEDOM: Final = 4.0
"""Degrees of freedom of Student's distribution of these gaps: the noise is itself estimated from
few corners, and the depth of a ring follows from lines whose errors it has in common, so that of
holes in strokes one in twenty is drawn off by three standard deviations."""

WORST: Final = 12.0
"""What a gap costs at most, nats."""

SAME_DEPTH: Final = 1e-5
"""Weight with which depths that nothing tells are 0."""


@dataclass(frozen=True, eq=False)
class PartDepths:
    """Equations for the depths of a part: its lines and its planar faces.

    Parameters
    ----------
    corners : tuple of int
        Of the part, k.
    rows : (r, k) float64
        What is to be as deep as `values`, (r,).
    """

    corners: tuple[int, ...]
    rows: Array
    values: Array

    @classmethod
    def of(
        cls,
        drawing: Drawing,
        classes: ParallelClasses,
        depths: Array,
        known: Sequence[int],
        part: Lifting,
    ) -> PartDepths:
        """Return the equations of a part beside the corners whose depths are known."""
        slopes = _slopes(drawing, classes, depths, known)
        column = np.full(len(drawing.points), -1)
        column[list(part.corners)] = np.arange(len(part.corners))
        planar = face_rows(drawing.points, part.corners, part.faces)
        rows, values = [planar], [np.zeros(len(planar))]
        along = (drawing.spans * classes.directions[classes.labels]).sum(1)
        inner = column[drawing.lines[:, 0]] >= 0
        for label in np.unique(classes.labels[inner]):
            chosen = np.flatnonzero(inner & (classes.labels == label))
            block = np.zeros((len(chosen), len(part.corners)))
            block[np.arange(len(chosen)), column[drawing.lines[chosen, 1]]] = 1.0
            block[np.arange(len(chosen)), column[drawing.lines[chosen, 0]]] = -1.0
            if np.isfinite(slopes[label]):
                values.append(slopes[label] * along[chosen])
            else:
                axis = along[chosen] / np.linalg.norm(along[chosen])
                block -= np.outer(axis, axis @ block)
                values.append(np.zeros(len(chosen)))
            rows.append(block)
        return cls(part.corners, np.vstack(rows), np.concatenate(values))

    def places(self, corners: Sequence[int]) -> Index:
        """Return where corners stand among those of the part."""
        return np.searchsorted(self.corners, corners)

    def solved(self, seats: Sequence[tuple[Array, Ring]]) -> tuple[Array, float]:
        """Return depths with rings at given levels, and the root mean square misfit of these."""
        count = len(self.corners)
        rows, values = [self.rows, SAME_DEPTH * np.eye(count)], [self.values, np.zeros(count)]
        for level, corners in seats:
            rows.append(np.eye(count)[self.places(corners)])
            values.append(level)
        matrix, right = np.vstack(rows), np.concatenate(values)
        depths = np.linalg.lstsq(matrix, right, rcond=None)[0]
        off = (matrix @ depths - right) ** 2
        return depths, float(np.sqrt(off.sum() / max(1, count)))


def _slopes(
    drawing: Drawing, classes: ParallelClasses, depths: Array, known: Sequence[int]
) -> Array:
    """Return the slope of each class in the body, NaN for those it has not."""
    lines = np.isin(drawing.lines[:, 0], known)
    labels = classes.labels[lines]
    along = (drawing.spans[lines] * classes.directions[labels]).sum(1)
    rise = depths[drawing.lines[lines, 1]] - depths[drawing.lines[lines, 0]]
    count = len(classes.directions)
    below = np.bincount(labels, along**2, count)
    above = np.bincount(labels, along * rise, count)
    return np.where(below > 0.0, above / np.where(below > 0.0, below, 1.0), np.nan)


def with_own_sides(
    drawing: Drawing, classes: ParallelClasses, known: Sequence[int], sides: Index
) -> tuple[ParallelClasses, float]:
    """Return classes in which some lines have slopes of their own, and what that costs.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    known : sequence of int
        Corners of the body.
    sides : (k,) intp
        Lines that part from those of the body with which they were joined.

    Returns
    -------
    ParallelClasses
    float
        Nats. Lines that are parallel to one of the body look so up to the hand's unsteadiness, a
        normal distribution; others have any angle. The cost is the logarithm of the ratio of both
        densities at the angle to the closest direction of the body, summed over directions; at
        least 0, for a slope that no line of the body has was free before.
    """
    labels, directions = classes.labels.copy(), [*classes.directions]
    body = np.isin(drawing.lines[:, 0], known)
    angles, spreads = _angles(drawing, classes, body)
    cost = 0.0
    for label in np.unique(classes.labels[sides]).tolist():
        own = np.zeros(len(labels), bool)
        own[sides] = classes.labels[sides] == label
        angle, spread = (float(each[label]) for each in _angles(drawing, classes, own))
        deviations = np.hypot(spreads, spread)
        ratios = np.log(np.sqrt(np.pi / 2.0) / deviations)
        ratios -= 0.5 * (angle_between(angles, np.full(len(angles), angle)) / deviations) ** 2
        cost += max(0.0, float(np.nanmax(ratios, initial=0.0)))
        if (classes.labels[~own] == label).any():
            labels[own] = len(directions)
            directions.append(np.array((np.cos(angle), np.sin(angle))))
    return ParallelClasses(labels, np.array(directions)), cost


def _angles(drawing: Drawing, classes: ParallelClasses, lines: Flags) -> tuple[Array, Array]:
    """Return the mean angle of some lines of each class and its deviation; NaN where none are."""
    count = len(classes.directions)
    labels, spans = classes.labels[lines], drawing.spans[lines]
    squares = np.bincount(labels, (spans**2).sum(axis=1), count)
    doubled = (spans[:, 0] + 1j * spans[:, 1]) ** 2
    sums = np.bincount(labels, doubled.real, count) + 1j * np.bincount(labels, doubled.imag, count)
    present = squares > 0.0
    angles = np.where(present, 0.5 * np.angle(sums), np.nan)
    lengths = np.sqrt(np.where(present, squares, np.nan))
    return angles, np.hypot(HAND, drawing.noise / lengths)


def plane_of(drawing: Drawing, depths: Array, face: Rings) -> tuple[Array, Array]:
    """Return the middle of a face and its unit normal."""
    ring = list(face[0])
    space = np.column_stack((drawing.points[ring], depths[ring]))
    normal = area_vector(space)
    return space.mean(0), normal / max(1e-12, float(np.linalg.norm(normal)))


def level_of(drawing: Drawing, plane: tuple[Array, Array], ring: Ring) -> tuple[Array, Ring]:
    """Return the depths that a ring has in a plane, which is not seen edge-on."""
    middle, normal = plane
    across = (drawing.points[list(ring)] - middle[:2]) @ normal[:2]
    return middle[2] - across / normal[2], ring


def gap_of(drawing: Drawing, off: float, normal: Array) -> float:
    """Return how far a ring is drawn from a face, in units of the noise.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    off : float
        Distance of the ring from the plane along the line of sight, diagonals.
    normal : (3,) array
        Of the plane. What is off along it appears as off |n_z| sqrt(1 - n_z²) on the sheet.
    """
    upright = abs(float(normal[2]))
    return off * upright * float(np.sqrt(max(0.0, 1.0 - upright**2))) / max(1e-6, drawing.noise)


def gap_cost(gap: float) -> float:
    """Return what a gap costs that a ring in a face is drawn with, nats."""
    odds = 1.0 + (gap / GAP) ** 2 / FREEDOM
    return min(WORST, 0.5 * (FREEDOM + 1.0) * float(np.log(odds)))
