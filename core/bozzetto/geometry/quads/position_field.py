"""A square lattice on a surface along a field of directions: each vertex knows its place in it.

The place is two angles, 2π to a side of a square. They shall grow along the directions as fast as
the squares are long, which is a least-squares problem over unit complex numbers (Ray, Li, Lévy,
Sheffer, Alliez 2006, *Periodic global parameterization*, section 3), solved from coarse to fine:
vertices are joined in pairs, and the system of pairs follows from that of vertices (Galerkin).
Where no such lattice fits it is torn, as in Jakob, Tarini, Panozzo, Sorkine-Hornung 2015, *Instant
field-aligned meshes*.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.arrays import Array, Index

if TYPE_CHECKING:
    from bozzetto.geometry.quads.orientation_field import Frames
    from bozzetto.geometry.quads.surface import Edges, Features

FEATURE: Final = 10.0
"""How much it counts that a feature is a line of the lattice."""

COARSEST: Final = 150
"""Vertices at which the system is solved directly."""

SMOOTHED: Final = 24
"""Rounds of relaxation at each level."""

LAST: Final = 40
"""Rounds at the vertices themselves, in which all count alike."""

STEP: Final = 0.6
"""Share of a Jacobi step that is gone."""

JOINED: Final = 12
"""Rounds of joining pairs in one level, at most."""

# How the places (Re s, Im s, Re t, Im t) of a vertex stand in its neighbour's frame, which is
# turned by 0, 1, 2, 3 quarters: the entry of each, and its sign.
ENTRY: Final = np.array(((0, 1, 2, 3), (2, 3, 0, 1), (0, 1, 2, 3), (2, 3, 0, 1)))
SIGN: Final = np.array(((1, 1, 1, 1), (1, -1, 1, 1), (1, -1, 1, -1), (1, 1, 1, -1)), float)


@dataclass(frozen=True, eq=False)
class Lattice:
    """The lattice at vertices and along edges.

    Attributes
    ----------
    first, second : (n, 3) float
        Unit directions of its lines at each vertex.
    shift : (n, 2) float
        How far each vertex lies from its nearest node along these, in sides of squares.
    step : (e, 2) int
        How many squares the node of the second vertex of an edge lies from that of the first, in
        the frame of the first.
    error : (e,) float
        How badly that fits, in sides of squares.
    """

    first: Array
    second: Array
    shift: Array
    step: Index
    error: Array


def lattice(
    points: Array,
    edges: Edges,
    features: Features,
    frames: Frames,
    angles: Array,
    side: float,
) -> Lattice:
    """Return a lattice of squares of a side along directions.

    Parameters
    ----------
    points : (n, 3) float
        Vertices.
    edges, features, frames
        Of the surface.
    angles : (n,) float
        Of the directions in the frames.
    side : float
        Of a square, in the unit of the points.
    """
    from scipy.sparse import coo_array, csr_array, diags_array

    count = len(points)
    cosine, sine = np.cos(angles)[:, None], np.sin(angles)[:, None]
    first = cosine * frames.first + sine * frames.second
    second = cosine * frames.second - sine * frames.first
    i, j = edges.ends.T
    quarter = np.rint((angles[j] - angles[i] - frames.turn) / (0.5 * np.pi)).astype(int) % 4
    along = points[j] - points[i]
    there = (first[j], second[j], -first[j], -second[j])
    # The second vertex's directions as they stand to the first's.
    like = np.choose(quarter[:, None], (there[0], -there[1], -there[0], there[1]))
    like2 = np.choose(quarter[:, None], (there[1], there[0], -there[1], -there[0]))
    steps = 0.5 / side * np.column_stack((
        np.einsum("ij,ij->i", along, first[i] + like),
        np.einsum("ij,ij->i", along, second[i] + like2),
    ))  # fmt: skip
    # Rows: places of the second vertex in the first's frame, minus the first's, moved on.
    e = np.arange(len(i))
    weight = np.sqrt(frames.weight)
    rows, columns, values = [], [], []
    for place in range(4):
        rows.append(4 * e + place)
        columns.append(4 * j + ENTRY[quarter, place])
        values.append(weight * SIGN[quarter, place])
    for part in range(2):
        c, s = np.cos(2 * np.pi * steps[:, part]), np.sin(2 * np.pi * steps[:, part])
        for row, column, value in ((0, 0, c), (0, 1, -s), (1, 0, s), (1, 1, c)):
            rows.append(4 * e + 2 * part + row)
            columns.append(4 * i + 2 * part + column)
            values.append(-weight * value)
    shape = (4 * len(i), 4 * count)
    gradient = csr_array(
        coo_array((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape)
    )
    matrix = csr_array(gradient.T @ gradient)
    pull = np.zeros((count, 4))
    on_line = features.line & ~features.corner
    lies = np.abs(np.einsum("ij,ij->i", features.along, first)) > np.abs(
        np.einsum("ij,ij->i", features.along, second)
    )
    pull[on_line & lies, 2] = pull[on_line & ~lies, 0] = FEATURE
    pull[features.corner, 0] = pull[features.corner, 2] = FEATURE
    held = np.repeat(pull.reshape(-1, 2).max(axis=1), 2)
    matrix = csr_array(matrix + diags_array(held))
    places = _solved(matrix, pull.ravel(), frames.weight, steps, quarter, edges, count)
    places = places.reshape(-1, 2, 2)
    angle = np.arctan2(places[..., 1], places[..., 0]) / (2 * np.pi)
    # The second vertex's angles in the first's frame.
    turned = places.reshape(-1, 4)[j[:, None], ENTRY[quarter]] * SIGN[quarter]
    theirs = np.arctan2(turned[:, 1::2], turned[:, ::2]) / (2 * np.pi)
    apart = angle[i] + steps - theirs
    step = np.rint(apart)
    return Lattice(first, second, angle, step.astype(np.intp), np.abs(apart - step).max(axis=1))


def _solved(
    matrix: Any,
    pull: Array,
    weight: Array,
    steps: Array,
    quarter: Index,
    edges: Edges,
    count: int,
) -> Array:
    """Solve from coarse to fine; return places (4 n,)."""
    from scipy.sparse import csr_array

    levels = [(matrix, pull)]
    carriers: list[Any] = []
    ends = edges.ends
    while count > COARSEST:
        carrier, ends, weight, steps, quarter, fewer = _coarser(ends, weight, steps, quarter, count)
        matrix = csr_array(carrier.T @ matrix @ carrier)
        pull = carrier.T @ pull
        levels.append((matrix, pull))
        carriers.append(carrier)
        stalls, count = fewer > 0.9 * count, fewer
        if stalls:
            break
    matrix, pull = levels[-1]
    dense = matrix.toarray() if count <= 4 * COARSEST else np.zeros((0, 0))
    if not len(dense):  # what does not hang together is not joined
        places = np.tile((1.0, 0.0), len(pull) // 2)
    elif pull.any():
        places = np.linalg.lstsq(dense + 1e-9 * np.eye(len(dense)), pull, rcond=None)[0]
    else:
        places = np.linalg.eigh(dense)[1][:, 0]
    for number in range(len(levels) - 1, -1, -1):
        matrix, pull = levels[number]
        if number < len(carriers):
            places = carriers[number] @ places
        diagonal = matrix.diagonal()
        diagonal = np.where(diagonal > 0.0, diagonal, 1.0)
        places = _alike(places)
        for _ in range(SMOOTHED):
            places = places - STEP * (matrix @ places - pull) / diagonal
            if not pull.any():
                places /= np.sqrt((places * places).mean()) or 1.0
        places = _alike(places)
    for _ in range(LAST):
        places = _alike(places - STEP * (matrix @ places - pull) / diagonal)
    return places


def _alike(places: Array) -> Array:
    """Return places of length one."""
    pairs = places.reshape(-1, 2)
    length = np.linalg.norm(pairs, axis=1, keepdims=True)
    made = np.where(length > 1e-150, pairs / np.where(length > 1e-150, length, 1.0), (1.0, 0.0))
    return made.ravel()


def _coarser(
    ends: Index, weight: Array, steps: Array, quarter: Index, count: int
) -> tuple[Any, Index, Array, Array, Index, int]:
    """Join vertices in pairs along strong edges.

    Returns
    -------
    carrier : (4 n, 4 m) sparse
        Places of vertices from those of pairs.
    ends, weight, steps, quarter
        Edges between pairs; of several between two pairs the strongest tells how places are
        carried, and all their weights count.
    fewer : int
        m.
    """
    from scipy.sparse import coo_array, csr_array

    partner = np.full(count, -1)
    rank = np.empty(len(ends), np.intp)
    rank[np.lexsort((np.arange(len(ends)), -weight))] = np.arange(len(ends))
    joined = np.full(count, -1)  # the edge to the pair's first vertex
    open_edges = np.arange(len(ends))
    for _ in range(JOINED):
        if not len(open_edges):
            break
        best = np.full(count, len(ends))
        i, j = ends[open_edges].T
        np.minimum.at(best, i, rank[open_edges])
        np.minimum.at(best, j, rank[open_edges])
        own = rank[open_edges]
        chosen = open_edges[(best[i] == own) & (best[j] == own)]
        partner[ends[chosen, 0]] = ends[chosen, 1]
        partner[ends[chosen, 1]] = ends[chosen, 0]
        joined[ends[chosen, 1]] = chosen
        open_edges = open_edges[(partner[i] < 0) & (partner[j] < 0)]
    roots = joined < 0
    number = np.cumsum(roots) - 1
    owner = np.where(roots, number, 0)
    follows = np.flatnonzero(~roots)
    edge = joined[follows]
    owner[follows] = number[ends[edge, 0]]
    # How the places of each vertex follow from those of its pair: (quarter, steps), as along edges.
    own_quarter = np.zeros(count, np.intp)
    own_steps = np.zeros((count, 2))
    own_quarter[follows], own_steps[follows] = quarter[edge], steps[edge]
    every = np.arange(count)
    rows, columns, values = [], [], []
    for part in range(2):
        c = np.cos(2 * np.pi * own_steps[:, part])
        s = np.sin(2 * np.pi * own_steps[:, part])
        for row, column, value in ((0, 0, c), (0, 1, -s), (1, 0, s), (1, 1, c)):
            place = 2 * part + row  # in the pair's frame; then into the vertex's own
            rows.append(4 * every + ENTRY[own_quarter, place])
            columns.append(4 * owner + 2 * part + column)
            values.append(SIGN[own_quarter, place] * value)
    fewer = int(roots.sum())
    carrier = csr_array(
        coo_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            (4 * count, 4 * fewer),
        )
    )
    i, j = ends.T
    # From pair of i to i, along the edge, and back to the pair of j.
    between = owner[i] != owner[j]
    i, j, w = i[between], j[between], weight[between]
    turn = (own_quarter[i] + quarter[between] - own_quarter[j]) % 4
    moved = own_steps[i] + _turned(steps[between], own_quarter[i])
    moved = moved - _turned(own_steps[j], turn)
    a, b = owner[i], owner[j]
    swapped = a > b
    low, high = np.minimum(a, b), np.maximum(a, b)
    moved[swapped] = -_turned(moved[swapped], -turn[swapped] % 4)
    turn = np.where(swapped, -turn % 4, turn)
    order = np.lexsort((-w, low * np.int64(fewer) + high))
    key = (low * np.int64(fewer) + high)[order]
    first = np.r_[True, key[1:] != key[:-1]] if len(key) else np.zeros(0, bool)
    total = np.bincount(np.cumsum(first) - 1, w[order]).astype(np.float64)
    top = order[first]
    pairs = np.asarray(np.column_stack((low[top], high[top])), np.intp)
    return carrier, pairs, total, moved[top], np.asarray(turn[top], np.intp), fewer


def _turned(steps: Array, quarter: Index) -> Array:
    """Return steps (n, 2) of a frame that is turned by quarters, in the frame that is not."""
    x, y = steps.T
    return np.column_stack((
        np.choose(quarter, (x, -y, -x, y)), np.choose(quarter, (y, x, -y, -x)),
    ))  # fmt: skip
