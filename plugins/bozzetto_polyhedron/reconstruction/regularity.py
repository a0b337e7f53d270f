"""How regular a reading of a drawing in space is.

The numbers that affine facts leave open, Z = a z + b x + c y + t e, with an e for each change of
the depths that lines and faces allow, are chosen so that the solid is as regular as people draw:
right angles, equal lengths, symmetry. The measures follow the regularities of Masry et al. 2004
(section on reconstruction by optimisation) as far as a drawing gives evidence for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.lengths import dots, lengths_of
from bozzetto_polyhedron.reconstruction.mirror_planes import mirror_normals, mirror_planes

RIGHT: Final = (0.03, 5.0, 0.13)
"""Cosine at which an angle counts half as a right one: without noise, more for each diagonal of
noise, and at most."""

SAME_LENGTH: Final = 0.06
"""Logarithm of a ratio at which two lengths count half as equal."""

OPPOSITE: Final = 0.15
"""Sine at which the way between two parallel faces counts half as perpendicular to them."""

PARALLEL_FACES: Final = 0.12
"""Sine of the angle between affine normals below which two faces may be parallel."""

SAME_ANGLE: Final = 0.12
"""Difference, radians, at which two angles count half as equal."""

UPRIGHT: Final = 0.08
"""Tangent of the angle on the sheet at which a direction counts half as upright."""

UNDER: Final = (0.04, 2.0)
"""Distance by which a corner may lie under the face that a solid stands on: diagonals, and more for
each diagonal of noise."""

LEAST_AXIS: Final = 3
"""Lines that the axis of a prism has at least."""

MEASURES: Final = (
    "square corners",
    "square dihedral angles",
    "equal lengths in a face",
    "square classes",
    "depth against width, squared logarithm",
    "steepness",
    "axis square to all else",
    "faces opposite one another",
    "frame coverage",
    "equal angles in a face",
    "mirror plane",
    "further mirror planes",
    "frame coverage, sixth power",
    "stands upright",
)
"""Names of the measures in the order of their columns; the first eight are cheap."""

CHEAP: Final = 8
"""Number of measures with which many readings are compared."""


@dataclass(frozen=True, eq=False)
class Relief:
    """A drawing with affine depths, faces, and tables of what is to be compared.

    Parameters
    ----------
    points : (n, 2) float64
        Corners, diagonals.
    depths : (n, 1 + j) float64
        Affine depths, and changes of which any multiple may be added.
    lines : (m, 2) intp
    faces : tuple of Rings
    noise : float
        Diagonals.
    directions : (c, 2) float64
        Of each class the unit vector on the sheet.
    slopes : (c, 3 + j) float64
        How its directions rise by each number of a map: (a, b, c) and the multiples of changes.
    counts : (c,) float64
        Lines of each class.
    corners : (p, 2) intp
        Classes that meet in a corner of a face.
    corner_counts : (p,) float64
        How often they do.
    normals : (f, 2, 3 + j) float64
        How the two parts on the sheet of the area vectors of faces depend on a map.
    areas : (f,) float64
        Areas of the faces on the sheet.
    dihedrals : (d, 2) intp
        Faces that share a line.
    opposite : (o, 2) intp
        Parallel faces with as many corners, none in common.
    middles : (f, 2) float64
        Middles of the faces on the sheet.
    levels : (f, 3 + j) float64
        How their depths depend on a map.
    lengths : (e, 2) intp
        Lines of one face that are not parallel.
    length_weights : (e,) float64
        Neighbours count double.
    angles : (g, 4) intp
        Four corners in the order of a ring: the two angles between them are compared.
    """

    points: Array
    depths: Array
    lines: Index
    faces: tuple[Rings, ...]
    noise: float
    directions: Array
    slopes: Array
    counts: Array
    corners: Index
    corner_counts: Array
    normals: Array
    areas: Array
    dihedrals: Index
    opposite: Index
    middles: Array
    levels: Array
    lengths: Index
    length_weights: Array
    angles: Index

    @property
    def right(self) -> float:
        """Cosine at which an angle counts half as a right one."""
        return min(RIGHT[0] + RIGHT[1] * self.noise, RIGHT[2])

    @cached_property
    def mapped(self) -> Array:
        """How depths depend on the numbers of a map, (n, 3 + j)."""
        return mapped(self.depths, self.points)

    @cached_property
    def used(self) -> Index:
        """Corners in which lines end."""
        return np.unique(self.lines)

    @cached_property
    def drawn(self) -> Array:
        """Length of each line on the sheet, (m,)."""
        return np.asarray(
            np.hypot(*(self.points[self.lines[:, 1]] - self.points[self.lines[:, 0]]).T)
        )

    def unit_directions(self, maps: Array) -> Array:
        """Return the direction of each class in space, (k, c, 3), for maps of shape (k, 3 + j)."""
        along = maps @ self.slopes.T
        flat = np.broadcast_to(self.directions, (*along.shape, 2))
        found = np.concatenate((flat, along[..., None]), axis=2)
        return np.asarray(found / lengths_of(found))

    def heights(self, chosen: Array) -> Array:
        """Return the depths of one map, (n,), diagonals."""
        return np.asarray(self.mapped @ chosen)


def mapped(depths: Array, points: Array) -> Array:
    """Return how depths depend on the numbers of a map, (n, 3 + j).

    Parameters
    ----------
    depths : (n, 1 + j) array
        Affine depths and changes.
    points : (n, 2) array
        On the sheet.
    """
    return np.column_stack((depths[:, :1], points, depths[:, 1:]))


def relief_of(
    points: Array,
    depths: Array,
    lines: Index,
    labels: Index,
    plane_directions: Array,
    faces: Sequence[Rings],
    noise: float,
) -> Relief:
    """Prepare a drawing with affine depths for comparisons.

    Parameters
    ----------
    points : (n, 2) array
        Corners, diagonals.
    depths : (n, 1 + j) array
        Affine depths, and changes of which any multiple may be added.
    lines : (m, 2) array of int
        Lines that take part.
    labels : (m,) array of int
        Their classes, 0 … c - 1, none empty.
    plane_directions : (c, 2) array
        Unit vectors of the classes on the sheet.
    faces : sequence of Rings
        Faces between the lines.
    noise : float
        Standard deviation of a corner, diagonals.
    """
    every = mapped(depths, points)
    number = {(int(a), int(b)): k for k, (a, b) in enumerate(lines)}
    pairs: dict[tuple[int, int], int] = {}
    owners: dict[int, list[int]] = {}
    lengths: list[tuple[int, int, float]] = []
    angles: list[tuple[int, ...]] = []
    for place, face in enumerate(faces):
        for ring in face:
            sides = [
                number[min(a, b), max(a, b)] for a, b in zip(ring, ring[1:] + ring[:1], strict=True)
            ]
            for side, following in zip(sides, sides[1:] + sides[:1], strict=True):
                owners.setdefault(side, []).append(place)
                first, second = sorted((int(labels[side]), int(labels[following])))
                if first != second:
                    pairs[first, second] = pairs.get((first, second), 0) + 1
            lengths += _compared_lengths(sides, labels)
            twice = ring + ring
            angles += [twice[start : start + 4] for start in range(len(ring))]
    spaces = [np.column_stack((points, column)) for column in every.T]
    vectors = np.array(
        [[area_vector(space[list(face[0])]) for space in spaces] for face in faces]
    ).reshape(-1, len(spaces), 3)
    return Relief(
        points,
        depths,
        lines,
        tuple(faces),
        noise,
        plane_directions,
        _class_slopes(points, every, lines, labels, plane_directions),
        np.bincount(labels, minlength=len(plane_directions)).astype(float),
        np.array(list(pairs), np.intp).reshape(-1, 2),
        np.array(list(pairs.values()), float),
        vectors[:, :, :2].transpose(0, 2, 1),
        vectors[:, 0, 2],
        np.array([each for each in owners.values() if len(each) == 2], np.intp).reshape(-1, 2),
        _opposite(faces, vectors[:, 0]),
        np.array([points[list(face[0])].mean(0) for face in faces]).reshape(-1, 2),
        np.array([every[list(face[0])].mean(0) for face in faces]).reshape(-1, every.shape[1]),
        np.array([each[:2] for each in lengths], np.intp).reshape(-1, 2),
        np.array([each[2] for each in lengths]),
        np.array(angles, np.intp).reshape(-1, 4),
    )


def cheap_measures(relief: Relief, maps: Array, right: float | None = None) -> Array:
    """Return the first measures of many maps, (k, CHEAP).

    Parameters
    ----------
    relief : Relief
        What is compared.
    maps : (k, 3 + j) array
        Numbers a, b, c of each map, and the multiples of changes.
    right : float, optional
        Cosine at which an angle counts half as a right one, as the noise asks unless given.
    """
    right = relief.right if right is None else right
    directions = relief.unit_directions(maps)
    square = _near(directions @ directions.transpose(0, 2, 1), right)
    weights = np.outer(relief.counts, relief.counts) * (1.0 - np.eye(len(relief.counts)))
    heights = maps @ relief.mapped.T
    rises = heights[:, relief.lines[:, 1]] - heights[:, relief.lines[:, 0]]
    lengths = np.log(np.hypot(relief.drawn, rises))
    ratios = lengths[:, relief.lengths[:, 0]] - lengths[:, relief.lengths[:, 1]]
    spread = np.maximum(heights[:, relief.used].std(1), 1e-9)
    spread /= relief.points[relief.used].std(0).mean()
    normals = _normals(relief, maps)
    return np.column_stack(
        (
            _mean(square[:, relief.corners[:, 0], relief.corners[:, 1]], relief.corner_counts),
            _square_dihedrals(relief, normals, right),
            _mean(_near(ratios, SAME_LENGTH), relief.length_weights),
            (square * weights).sum((1, 2)) / max(1.0, weights.sum()),
            np.log(spread) ** 2,
            (lengths - np.log(relief.drawn)).mean(1),
            _square_axis(relief, square),
            _opposite_faces(relief, maps, normals),
        )
    )


def costly_measures(relief: Relief, maps: Array) -> Array:
    """Return the measures of many maps that are not cheap, (k, 6), in the order of `MEASURES`.

    Parameters
    ----------
    relief : Relief
        What is compared.
    maps : (k, 3 + j) array
        Numbers a, b, c of each map, and the multiples of changes.
    """
    directions = relief.unit_directions(maps)
    normals = _normals(relief, maps)
    heights = maps @ relief.mapped.T
    flat = np.broadcast_to(relief.points, (*heights.shape, 2))
    space = np.concatenate((flat, heights[..., None]), axis=2)
    coverage = _frame_coverage(directions, relief.counts, relief.right)
    corners, scale = space[:, relief.used], 0.06 + 2.0 * relief.noise
    mirrors = mirror_planes(corners, mirror_normals(directions, normals), scale)
    angles = _equal_angles(relief, space)
    upright = _stands_upright(relief, normals, corners)
    return np.column_stack((coverage, angles, mirrors, coverage**6, upright))


def all_measures(relief: Relief, maps: Array) -> Array:
    """Return all measures of many maps, (k, len(MEASURES)).

    Parameters
    ----------
    relief : Relief
        What is compared.
    maps : (k, 3 + j) array
        Numbers a, b, c of each map, and the multiples of changes.
    """
    return np.hstack((cheap_measures(relief, maps), costly_measures(relief, maps)))


def area_vector(ring: Array) -> Array:
    """Return the area vector of a ring of points, (3,)."""
    x, y, z = (ring - ring[0]).T
    after = np.arange(1, len(ring) + 1) % len(ring)
    return 0.5 * np.array(
        (y @ z[after] - z @ y[after], z @ x[after] - x @ z[after], x @ y[after] - y @ x[after])
    )


def _near(values: Array, scale: float) -> Array:
    """1 at 0, a half at the scale, less beyond."""
    return np.asarray(1.0 / (1.0 + (values / scale) ** 2))


def _mean(values: Array, weights: Array) -> Array:
    """Weighted mean along the last axis; 0 of nothing."""
    total = float(weights.sum())
    return np.asarray(values @ weights / total if total > 0 else np.zeros(len(values)))


def _class_slopes(
    points: Array, every: Array, lines: Index, labels: Index, plane_directions: Array
) -> Array:
    """Return the slope of each class for each number of a map, the mean over its lines."""
    along = ((points[lines[:, 1]] - points[lines[:, 0]]) * plane_directions[labels]).sum(1)
    rises = every[lines[:, 1]] - every[lines[:, 0]]
    count = len(plane_directions)
    below = np.maximum(np.bincount(labels, along**2, count), 1e-18)
    above = [np.bincount(labels, along * rise, count) for rise in rises.T]
    slopes: Array = np.column_stack(above) / below[:, None]
    slopes[:, 1:3] = plane_directions
    return slopes


def _compared_lengths(sides: list[int], labels: Index) -> list[tuple[int, int, float]]:
    """Pairs of lines of one ring that are not parallel; neighbours weigh double."""
    count = len(sides)
    return [
        (sides[i], sides[j], 2.0 if j - i in (1, count - 1) else 1.0)
        for i, j in combinations(range(count), 2)
        if labels[sides[i]] != labels[sides[j]]
    ]


def _normals(relief: Relief, maps: Array) -> Array:
    """Return unit normals of the faces for each map, (k, f, 3)."""
    rows = relief.normals.reshape(-1, maps.shape[1])
    flat = (maps @ rows.T).reshape(len(maps), len(relief.normals), 2)
    areas = np.broadcast_to(relief.areas, flat.shape[:2])
    normals = np.concatenate((flat, areas[..., None]), axis=2)
    return np.asarray(normals / np.maximum(lengths_of(normals), 1e-12))


def _square_dihedrals(relief: Relief, normals: Array, right: float) -> Array:
    """Return the share of lines between two faces at a right angle, (k,)."""
    if not len(relief.dihedrals):
        return np.zeros(len(normals))
    cosines = dots(normals[:, relief.dihedrals[:, 0]], normals[:, relief.dihedrals[:, 1]])
    return np.asarray(_near(cosines, right).mean(1))


def _square_axis(relief: Relief, square: Array) -> Array:
    """Return how square the best class, as the axis of a prism, is to all other lines, (k,)."""
    others = relief.counts * (1.0 - np.eye(len(relief.counts)))
    shares = (square * others).sum(2) / np.maximum(others.sum(1), 1.0)
    return np.asarray(np.where(relief.counts >= LEAST_AXIS, shares, 0.0).max(1))


def _opposite(faces: Sequence[Rings], normals: Array) -> Index:
    """Return pairs of parallel faces with as many corners, none in common."""
    scaled = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    sets = [set(face[0]) for face in faces]
    found = [
        (first, second)
        for first, second in combinations(range(len(faces)), 2)
        if len(faces[first][0]) == len(faces[second][0])
        and not sets[first] & sets[second]
        and np.linalg.norm(np.cross(scaled[first], scaled[second])) < PARALLEL_FACES
    ]
    return np.array(found, np.intp).reshape(-1, 2)


def _opposite_faces(relief: Relief, maps: Array, normals: Array) -> Array:
    """Return how perpendicular two parallel faces are to the way between them, (k,), at best."""
    if not len(relief.opposite):
        return np.zeros(len(maps))
    first, second = relief.opposite.T
    ways = relief.middles[second] - relief.middles[first]
    depth = maps @ (relief.levels[second] - relief.levels[first]).T
    spans = np.concatenate((np.broadcast_to(ways, (*depth.shape, 2)), depth[..., None]), axis=2)
    spans /= np.maximum(lengths_of(spans), 1e-12)
    cosines = dots(spans, normals[:, relief.opposite[:, 0]])
    return np.asarray(_near(np.sqrt(np.maximum(0.0, 1.0 - cosines**2)), OPPOSITE).max(1))


def _stands_upright(relief: Relief, normals: Array, corners: Array) -> Array:
    """Return how upright on the sheet the solid stands on one of its faces, (k,), at best.

    The faces are those with all of it on one side: people draw what stands with its upright lines
    running up the sheet.
    """
    if not len(relief.faces):
        return np.zeros(len(normals))
    heights = np.einsum("kfc,knc->kfn", normals, corners)
    firsts = np.searchsorted(relief.used, [face[0][0] for face in relief.faces])
    own = np.take_along_axis(heights, np.asarray(firsts)[None, :, None], axis=2)[..., 0]
    slack = UNDER[0] + UNDER[1] * relief.noise
    stands = (heights.max(2) < own + slack) | (heights.min(2) > own - slack)
    upward = np.maximum(np.abs(normals[..., 1]), 1e-9)
    return np.asarray(np.where(stands, _near(normals[..., 0] / upward, UPRIGHT), 0.0).max(1))


def _frame_coverage(directions: Array, counts: Array, right: float) -> Array:
    """Largest share of the lines that lies along one orthogonal frame, (k,)."""
    best = np.full(len(directions), float(counts.max() / counts.sum()))
    square = np.abs(directions @ directions.transpose(0, 2, 1)) < 0.2
    number, first, second = np.nonzero(np.triu(square, 1))
    axes, others = directions[number, first], directions[number, second]
    thirds = _cross(axes, others)
    thirds /= lengths_of(thirds)
    frames = np.stack((axes, _cross(thirds, axes), thirds), axis=2)
    nearest = np.abs(directions[number] @ frames).max(2)
    off = np.sqrt(np.maximum(0.0, 1.0 - nearest**2))
    np.maximum.at(best, number, _near(off, right) @ counts / counts.sum())
    return best


def _cross(first: Array, second: Array) -> Array:
    """Cross products of rows, (p, 3)."""
    (a, b, c), (x, y, z) = first.T, second.T
    return np.stack((b * z - c * y, c * x - a * z, a * y - b * x), axis=1)


def _equal_angles(relief: Relief, space: Array) -> Array:
    """Share of neighbouring angles in faces that are equal, (k,)."""
    if not len(relief.angles):
        return np.zeros(len(space))
    sides = np.diff(space[:, relief.angles], axis=2)
    sides /= np.maximum(lengths_of(sides), 1e-12)
    turns = np.arccos(np.clip(-dots(sides[:, :, :2], sides[:, :, 1:]), -1.0, 1.0))
    return np.asarray(_near(turns[..., 0] - turns[..., 1], SAME_ANGLE).mean(1))
