"""A piece of a surface laid flat, as rigidly as it goes.

L. Liu, L. Zhang, Y. Xu, C. Gotsman and S. J. Gortler, *A local/global approach to mesh
parameterization*, 2008: in turn every triangle takes the rotation that fits it best, and all
vertices the places that fit these rotations best. It begins with the piece seen along its mean
normal.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Flags, Index

ROUNDS: Final = 24
"""Steps of both kinds; after so many a half ball is within a hundredth of where it ends."""

WEIGHTS: Final = (0.02, 20.0)
"""Bounds of a cotangent: triangles thin as needles would take all the say, or none."""


FOLDED: Final = 1e-4
"""Share of a piece that may lie on itself. Folds as thin as needles, such as lie along creases,
cannot be laid flat at all: without them whole pieces would fall apart into single triangles."""


class Piece(NamedTuple):
    """Triangles that hang together, with vertices of their own along their border.

    Attributes
    ----------
    face : (f,) int array
        Which faces of the mesh these are.
    points : (v, 3) float array
    triangles : (f, 3) int array
        Into the points; two that share a point hang together around it.
    """

    face: Index
    points: Array
    triangles: Index


def flattened_piece(piece: Piece) -> Array:
    """Return the places (v, 2) of a piece laid flat, in the unit of its points.

    Its triangles may still be turned over or lie on each other.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import splu

    triangles = piece.triangles
    rest = _flat_triangles(piece.points[triangles])
    weight = _cotangents(rest)
    places = _seen(piece)
    if len(triangles) == 1:
        single: Array = rest[0]
        return single
    count = len(piece.points)
    one, two = np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)
    rows, columns, values = one.ravel(), two.ravel(), weight.ravel()
    half = coo_array((values, (rows, columns)), shape=(count, count)).tocsr()
    off = half + half.T
    matrix = coo_array(
        (off.sum(axis=1), (np.arange(count), np.arange(count))), shape=(count, count)
    ).tocsr() - off  # fmt: skip
    solver = splu(
        matrix[1:, 1:].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
    )
    # Edges as complex numbers: a rotation is a factor.
    flat = rest[..., 0] + 1j * rest[..., 1]
    edges = np.roll(flat, -1, axis=1) - np.roll(flat, -2, axis=1)
    z = places[:, 0] + 1j * places[:, 1]
    for _ in range(ROUNDS):
        now = z[one] - z[two]
        turn = (weight * now * edges.conj()).sum(axis=1)
        turn /= np.maximum(np.abs(turn), 1e-300)
        pull = weight * edges * turn[:, None]
        right = np.bincount(rows, pull.real.ravel(), count) - np.bincount(
            columns, pull.real.ravel(), count
        )
        up = np.bincount(rows, pull.imag.ravel(), count) - np.bincount(
            columns, pull.imag.ravel(), count
        )
        found = solver.solve(np.column_stack([right[1:], up[1:]]))
        z = np.concatenate([[0.0], found[:, 0] + 1j * found[:, 1]])
    return np.column_stack([z.real, z.imag])


def folded(areas: Array) -> float:
    """Return the share of triangles that lie the wrong way round, from all signed areas."""
    return -float(np.minimum(areas, 0.0).sum()) / max(float(np.abs(areas).sum()), 1e-300)


def stretch(piece: Piece, places: Array) -> tuple[Array, Array]:
    """Return by how much each triangle is drawn out along both its axes, ≥ and ≤, (f,) each.

    The second is negative where a triangle is turned over.
    """
    rest = _flat_triangles(piece.points[piece.triangles])
    flat = places[piece.triangles]
    base = np.stack([rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]], axis=2)
    now = np.stack([flat[:, 1] - flat[:, 0], flat[:, 2] - flat[:, 0]], axis=2)
    area = base[:, 0, 0] * base[:, 1, 1] - base[:, 0, 1] * base[:, 1, 0]
    inverse = np.empty_like(base)
    inverse[:, 0, 0], inverse[:, 1, 1] = base[:, 1, 1], base[:, 0, 0]
    inverse[:, 0, 1], inverse[:, 1, 0] = -base[:, 0, 1], -base[:, 1, 0]
    jacobian = now @ inverse / np.maximum(area, 1e-300)[:, None, None]
    a, b, c, d = jacobian.reshape(-1, 4).T
    alike, against = np.hypot(a + d, b - c), np.hypot(a - d, b + c)
    return 0.5 * (alike + against), 0.5 * (alike - against)


def areas(corners: Array) -> Array:
    """Return the signed areas of flat triangles (f, 3, 2)."""
    (ax, ay), (bx, by) = (corners[:, 1] - corners[:, 0]).T, (corners[:, 2] - corners[:, 0]).T
    return np.asarray(0.5 * (ax * by - ay * bx))


def _seen(piece: Piece) -> Array:
    """Return the points (v, 2) as seen along the mean normal."""
    corners = piece.points[piece.triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    length = float(np.linalg.norm(normal))
    normal = normal / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    least = np.eye(3)[np.abs(normal).argmin()]
    right = np.cross(least, normal)
    right /= np.linalg.norm(right)
    return np.asarray(piece.points @ np.column_stack([right, np.cross(normal, right)]))


def _flat_triangles(corners: Array) -> Array:
    """Return triangles (f, 3, 3) in planes of their own, (f, 3, 2), the first edge to the right."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    length = np.linalg.norm(first, axis=1)
    along = np.einsum("fd,fd->f", first, second) / np.maximum(length, 1e-300)
    height = np.linalg.norm(np.cross(first, second), axis=1) / np.maximum(length, 1e-300)
    flat = np.zeros((len(corners), 3, 2))
    flat[:, 1, 0] = length
    flat[:, 2, 0], flat[:, 2, 1] = along, height
    return flat


def _cotangents(flat: Array) -> Array:
    """Return the cotangent of the angle at each corner, (f, 3), within `WEIGHTS`."""
    one, two = np.roll(flat, -1, axis=1) - flat, np.roll(flat, -2, axis=1) - flat
    dot = (one * two).sum(axis=2)
    cross = one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0]
    return np.asarray(np.clip(dot / np.maximum(np.abs(cross), 1e-300), *WEIGHTS), np.float64)


def lies_once(piece: Piece, places: Array) -> bool:
    """Whether no triangle is turned over and none lies on another, but for `FOLDED`.

    If all are the right way round, how often a point is covered is how often the border winds
    around it: once within a border that does not meet itself.
    """
    import shapely

    area = areas(places[piece.triangles])
    total = float(np.abs(area).sum())
    if folded(area) > FOLDED:
        return False
    rings = [places[ring] for ring in borders(piece.triangles)]
    if not rings:
        return False
    sizes = [ring_area(ring) for ring in rings]
    outer = int(np.argmax(sizes))
    if any(size > 0.0 for k, size in enumerate(sizes) if k != outer):
        return False
    holes = [ring for k, ring in enumerate(rings) if k != outer]
    polygon = shapely.Polygon(rings[outer], holes)
    if shapely.is_valid(polygon):
        return True
    # A border may touch itself, but what is covered twice is not there in a valid polygon.
    return abs(float(shapely.make_valid(polygon).area) - float(area.sum())) <= FOLDED * total


def ring_area(ring: Array) -> float:
    """Return the signed area within a closed ring (n, 2)."""
    x, y = (ring - ring[0]).T
    return float(0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def borders(triangles: Index) -> list[Index]:
    """Return the closed rings of vertices along the border; the surface is on their left."""
    begin, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    count = np.int64(triangles.max(initial=0)) + 1
    open_edge: Flags = ~np.isin(begin * count + end, end * count + begin)
    following = dict(zip(begin[open_edge].tolist(), end[open_edge].tolist(), strict=True))
    rings: list[Index] = []
    while following:
        first, at = following.popitem()
        ring = [first]
        while at != first and at in following:
            ring.append(at)
            at = following.pop(at)
        rings.append(np.array(ring, np.intp))
    return rings
