"""The nearest body whose corners lie exactly in the planes of their faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.solid.face_rings import corners_of
from bozzetto_polyhedron.solid.regularities import Regularities

ROUNDS: Final = 60
"""Most steps; four to fifteen are usual."""

PATIENCE: Final = (15, 1e-6)
"""Rounds after which equations that are violated by more than a share of the size have no solution
nearby."""

SETTLED: Final = 1e-12
"""Step, as share of the size, below which the nearest body is found: without this the answer would
depend on how the drawing was turned."""

REACHED: Final = 2e-14
"""Largest violation, as share of the size of the body, at which it is solved."""

ACCEPTED: Final = 1e-12
"""Largest violation that counts as exact where rounding allows no less."""

OFFSET_EASE: Final = 100.0
"""How much farther a plane moves than a corner at the same cost."""

TURN_EASE: Final = 10.0
"""The same for the turn of a normal, in sizes of the body."""

DEPTH_EASE: Final = 2.0
"""The same for a corner along the line of sight, where a drawing says least."""

REDUNDANT: Final = 1e-10
"""Singular values below this share of the largest belong to rows that say the same twice."""


@dataclass(frozen=True, eq=False)
class PlaneFit:
    """Corners, planes, and how well they agree.

    Parameters
    ----------
    vertices : (n, 3) float64
    normals : (f, 3) float64
    offsets : (f,) float64
    violation : float
        Largest of all equations, in units of the input.
    """

    vertices: Array
    normals: Array
    offsets: Array
    violation: float


@dataclass(frozen=True, eq=False)
class Relations:
    """Linear equations between offsets: ``coefficients @ offsets == values``.

    Parameters
    ----------
    coefficients : (r, f) float64
    values : (r,) float64
    """

    coefficients: Array
    values: Array


def incidences(faces: Sequence[Rings]) -> Index:
    """Return all pairs of a face and a vertex of it, (i, 2)."""
    pairs = [(number, v) for number, face in enumerate(faces) for v in corners_of(face)]
    return np.array(pairs, np.intp).reshape(-1, 2)


def fitted_planes(
    vertices: Array,
    pairs: Index,
    regular: Regularities,
    relations: Relations,
    sight: Array | None = None,
) -> PlaneFit:
    """Move corners as little as possible so that all of them lie in the planes of their faces.

    Sequential quadratic programming: each step is the minimum-norm least-squares solution of the
    linearised equations about the drawing itself, so that redundant rows (corners of more than
    three faces) do no harm.

    Parameters
    ----------
    vertices : (n, 3) float
        As drawn; centred, with a size of about 1.
    pairs : (i, 2) int
        Face and vertex of each incidence.
    regular : Regularities
        What is to be regular.
    relations : Relations
        What is known of offsets.
    sight : (n, 3) float, optional
        Unit vectors along which corners move more easily.

    Returns
    -------
    PlaneFit
        Check its `violation`: equations that contradict one another are not solved.
    """
    face, vertex = pairs.T
    count, planes = len(vertices), len(regular.normals)
    columns = _turn_columns(regular)
    turns = sum(int(n) for n in regular.freedom)
    start = np.zeros(3 * count + planes + turns)
    start[: 3 * count] = vertices.ravel()
    heights = np.einsum("ik,ik->i", regular.normals[face], vertices[vertex])
    start[3 * count : 3 * count + planes] = np.bincount(
        face, heights, minlength=planes
    ) / np.bincount(face, minlength=planes)
    ease = _ease(count, planes, turns, sight)
    point, moved = start, np.inf
    best = PlaneFit(vertices, regular.normals, start[3 * count : 3 * count + planes], np.inf)
    for number in range(ROUNDS):
        normals, slopes = _normals(point[3 * count + planes :], regular, columns)
        residual, jacobian = _equations(
            point, normals, slopes, pairs, regular, columns, relations, count
        )
        violation = float(np.abs(residual).max(initial=0.0))
        if not np.isfinite(violation):
            break
        if violation <= max(best.violation, REACHED):
            best = PlaneFit(
                point[: 3 * count].reshape(-1, 3),
                normals,
                point[3 * count : 3 * count + planes],
                violation,
            )
        hopeless = number >= PATIENCE[0] and best.violation > PATIENCE[1]
        if hopeless or (violation < REACHED and moved < SETTLED):
            break
        wanted = -residual + jacobian @ (point - start)
        step = np.linalg.lstsq(jacobian @ ease, wanted, rcond=REDUNDANT)[0]
        following = start + ease @ step
        moved = float(np.abs(following - point).max())
        point = following
    return best


def _ease(count: int, planes: int, turns: int, sight: Array | None) -> Array:
    """Return the square root of the inverse metric in which a step is shortest."""
    ease = np.diag(
        np.concatenate(
            (np.ones(3 * count), np.full(planes, OFFSET_EASE), np.full(turns, TURN_EASE))
        )
    )
    if sight is not None:
        for number, ray in enumerate(sight):
            block = slice(3 * number, 3 * number + 3)
            ease[block, block] += (DEPTH_EASE - 1.0) * np.outer(ray, ray)
    return ease


def _turn_columns(regular: Regularities) -> Index:
    """Return the first column of the turns of each face; followers have those of their leader."""
    first = np.cumsum(regular.freedom) - regular.freedom
    return first[regular.leader]


def _normals(angles: Array, regular: Regularities, columns: Index) -> tuple[Array, Array]:
    """Return the normals and their slopes by the turns, (f, 3) and (f, 2, 3)."""
    turns = regular.turns[regular.leader]
    freedom = regular.freedom[regular.leader]
    padded = np.append(angles, (0.0, 0.0))
    amounts = np.stack((padded[columns], padded[columns + 1]), axis=1)
    amounts *= np.arange(2) < freedom[:, None]
    raw = regular.normals[regular.leader] + np.einsum("fa,fak->fk", amounts, turns)
    length = np.linalg.norm(raw, axis=1, keepdims=True)
    unit = np.where(freedom[:, None] > 0, raw / length, raw)
    across = turns - np.einsum("fak,fk->fa", turns, unit)[..., None] * unit[:, None]
    sign = regular.sign[:, None]
    return sign * unit, (sign / length)[:, None] * across


def _equations(
    point: Array,
    normals: Array,
    slopes: Array,
    pairs: Index,
    regular: Regularities,
    columns: Index,
    relations: Relations,
    count: int,
) -> tuple[Array, Array]:
    """Return the violation of every equation and the Jacobian."""
    face, vertex = pairs.T
    rows, planes = np.arange(len(pairs)), len(normals)
    corners = point[: 3 * count].reshape(-1, 3)
    offsets = point[3 * count : 3 * count + planes]
    jacobian = np.zeros((len(pairs) + len(relations.values), len(point)))
    residual = np.einsum("ik,ik->i", normals[face], corners[vertex]) - offsets[face]
    for axis in range(3):
        jacobian[rows, 3 * vertex + axis] = normals[face, axis]
    jacobian[rows, 3 * count + face] = -1.0
    freedom = regular.freedom[regular.leader]
    for turn in range(2):
        moving = freedom[face] > turn
        jacobian[rows[moving], 3 * count + planes + columns[face[moving]] + turn] = np.einsum(
            "ik,ik->i", slopes[face[moving], turn], corners[vertex[moving]]
        )
    jacobian[len(pairs) :, 3 * count : 3 * count + planes] = relations.coefficients
    difference = relations.coefficients @ offsets - relations.values
    return np.concatenate((residual, difference)), jacobian
