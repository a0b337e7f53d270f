"""A piece of a surface laid flat, as rigidly as it goes.

L. Liu, L. Zhang, Y. Xu, C. Gotsman and S. J. Gortler, *A local/global approach to mesh
parameterization*, 2008: in turn every triangle takes the rotation that fits it best, and all
vertices the places that fit these rotations best. It begins with the piece seen along its mean
normal. Where it would cover itself, triangles are wanted as they are seen instead of as they are.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bozzetto.arrays import Array, Flags, Index

ROUNDS: Final = 24
"""Steps of both kinds; after so many a half ball is within a hundredth of where it ends."""

WEIGHTS: Final = (0.02, 20.0)
"""Bounds of a cotangent: triangles thin as needles would take all the say, or none."""


RELIEVED: Final = 6
"""The same each time that something was pressed together."""

MOST_RELIEFS: Final = 5
"""How often that is done."""

HELPED: Final = 0.85
"""Share of the edges that cover something from which pressing did not help."""

MOST_PRESSED: Final = 0.47
"""By how much a triangle is pressed together at most there, as a share of its width."""

NEAR: Final = 0.1
"""How near to where a piece lies over itself it is pressed at first, as a share of its size."""

BESIDE: Final = 1e-3
"""How far beside an edge it is asked what covers it, as a share of its length."""

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


def flattened_piece(piece: Piece) -> tuple[Array, bool]:
    """Lay a piece flat, in the unit of its points.

    What would lie over itself along its border, as the rims of two limbs do that begin side by
    side, is pressed together there: towards how it is seen, where it lies beside each other.

    Returns
    -------
    places : (v, 2) float array
    once : bool
        Whether no triangle is turned over and none lies on another, but for `FOLDED`.
    """
    if len(piece.triangles) == 1:
        single: Array = _flat_triangles(piece.points[piece.triangles])[0][
            np.argsort(piece.triangles[0])
        ]
        return single, True
    laying = _Laying(piece)
    first = places = laying.rounds(_seen(piece), ROUNDS)
    for number in range(MOST_RELIEFS + 1):
        if lies_once(piece, places):
            return places, True
        turned_over = folded(areas(places[piece.triangles])) > FOLDED
        if number == MOST_RELIEFS or turned_over or not laying.press(places, number):
            break
        places = laying.rounds(places, RELIEVED)
    return first, False


class _Laying:
    """A piece on its way into the plane."""

    def __init__(self, piece: Piece) -> None:
        from scipy.sparse import coo_array
        from scipy.sparse.linalg import splu

        self.piece, triangles = piece, piece.triangles
        rest, seen = _flat_triangles(piece.points[triangles]), _seen(piece)
        self.weight = _cotangents(rest)
        self.size = float(np.sqrt(areas(rest).sum()))
        self.count = count = len(piece.points)
        self.one, self.two = np.roll(triangles, -1, axis=1), np.roll(triangles, -2, axis=1)
        pairs = self.one.ravel(), self.two.ravel()
        half = coo_array((self.weight.ravel(), pairs), shape=(count, count)).tocsr()
        off = half + half.T
        matrix = coo_array(
            (off.sum(axis=1), (np.arange(count), np.arange(count))), shape=(count, count)
        ).tocsr() - off  # fmt: skip
        self.solver = splu(
            matrix[1:, 1:].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}
        )
        # Edges as complex numbers: a rotation is a factor.
        self.edges = _opposite(rest)
        self.over = count
        self.share: Array = np.zeros(len(triangles))
        squeezed = np.clip(stretch(piece, seen)[1], 0.0, 1.0)
        self.most: Array = np.minimum(MOST_PRESSED / np.maximum(1.0 - squeezed, 1e-6), 1.0)
        pressed = _opposite(seen[triangles])
        turn = (self.weight * pressed * self.edges.conj()).sum(axis=1)
        self.pressed = pressed * (turn.conj() / np.maximum(np.abs(turn), 1e-300))[:, None]

    def rounds(self, places: Array, rounds: int) -> Array:
        """Return better places (v, 2) after so many steps of both kinds."""
        z = places[:, 0] + 1j * places[:, 1]
        edges = self.edges + self.share[:, None] * (self.pressed - self.edges)
        rows, columns = self.one.ravel(), self.two.ravel()
        for _ in range(rounds):
            now = z[self.one] - z[self.two]
            turn = (self.weight * now * edges.conj()).sum(axis=1)
            turn /= np.maximum(np.abs(turn), 1e-300)
            pull = (self.weight * edges * turn[:, None]).ravel()
            right = np.bincount(rows, pull.real, self.count) - np.bincount(
                columns, pull.real, self.count
            )
            up = np.bincount(rows, pull.imag, self.count) - np.bincount(
                columns, pull.imag, self.count
            )
            found = self.solver.solve(np.column_stack([right[1:], up[1:]]))
            z = np.concatenate([[0.0], found[:, 0] + 1j * found[:, 1]])
        return np.column_stack([z.real, z.imag])

    def press(self, places: Array, number: int) -> bool:
        """Press what is near where the piece lies over itself; False if that is nowhere.

        Parameters
        ----------
        places : (v, 2) float array
            Where it lies.
        number : int
            How often that was done: more and more is taken to be near.
        """
        from scipy.spatial import cKDTree

        over = covered_twice([places[ring] for ring in borders(self.piece.triangles)])
        if not 0 < len(over) <= HELPED * self.over:
            return False
        self.over = len(over)
        reach = NEAR * self.size * (1.0 + 0.5 * number)
        middles = places[self.piece.triangles].mean(axis=1)
        away = np.minimum(cKDTree(over).query(middles, distance_upper_bound=reach)[0] / reach, 1.0)
        self.share = np.minimum(self.share + 0.5 * (1.0 - away**2), self.most)
        return True


def _opposite(corners: Array) -> Array:
    """Return the edges opposite to the corners (f, 3, 2) as complex numbers, (f, 3)."""
    flat = corners[..., 0] + 1j * corners[..., 1]
    return np.roll(flat, -1, axis=1) - np.roll(flat, -2, axis=1)


def covered_twice(rings: Sequence[Array]) -> Array:
    """Return the middles (n, 2) of those edges beside which borders do not wind around just once.

    Parameters
    ----------
    rings : sequence of (n, 2) float arrays
        With the surface on their left.
    """
    start = np.concatenate(list(rings))
    end = np.concatenate([np.roll(ring, -1, axis=0) for ring in rings])
    along = end - start
    middles = 0.5 * (start + end)
    beside = middles + BESIDE * np.column_stack([-along[:, 1], along[:, 0]])
    times = np.zeros(len(beside), np.intp)
    for first in range(0, len(beside), 256):
        x, y = beside[first : first + 256].T[..., None]
        below, under = start[:, 1] <= y, end[:, 1] <= y
        left = along[:, 0] * (y - start[:, 1]) - (x - start[:, 0]) * along[:, 1]
        upwards, downwards = below & ~under & (left > 0.0), ~below & under & (left < 0.0)
        times[first : first + 256] = upwards.sum(axis=1) - downwards.sum(axis=1)
    return np.asarray(middles[times != 1])


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
