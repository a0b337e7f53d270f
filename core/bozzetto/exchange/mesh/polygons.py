"""Polygons and loose triangles of files, as triangles over shared vertices."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import FormatError
from bozzetto.exchange.limits import MAX_COORDINATE, MAX_FACES, at_most, exceeds
from bozzetto.geometry.mesh import Mesh

Faces = NDArray[np.int32]

CORNERS_AT_ONCE: Final = 1 << 18
"""Corners of polygons that are looked at in one go: some dozen megabytes."""

MAX_EFFORT: Final = 150_000_000
"""Squared corners of all faces that are cut one by one: six seconds of work."""

TOO_MANY_CORNERS: Final = (
    "Its faces have too many corners to be cut into triangles. Triangulate it in the program "
    "that made it, and save it again."
)

PER_POLYGON: Final = 1_000
"""Cost of a small polygon, in the same measure."""


ROUNDING: Final = 1e-6
"""Of places, as a share of the largest coordinate: some units in the last place of float32."""


def weld(vertices: NDArray[np.float32], faces: ArrayLike) -> tuple[NDArray[np.intp], Faces]:
    """Make one vertex of all that are at bit for bit the same place.

    Parameters
    ----------
    vertices : (v, 3) float32
        Places, in the units of the file.
    faces : (f, 3) array_like of int
        Vertices of each triangle.

    Returns
    -------
    kept : (m,) int
        The vertices that stay, by their first occurrence and in their order.
    faces : (f, 3) int32
        The faces over them.
    """
    clean = np.ascontiguousarray(vertices + np.float32(0.0))  # -0.0 becomes 0.0
    rows = clean.view([("x", "<f4"), ("y", "<f4"), ("z", "<f4")]).ravel()
    _, first, inverse = np.unique(rows, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank: Faces = np.empty(len(order), np.int32)
    rank[order] = np.arange(len(order), dtype=np.int32)
    joined: Faces = rank[inverse.ravel()][np.asarray(faces)]
    return first[order], joined


def weld_rounded(
    vertices: NDArray[np.float32], kept: NDArray[np.intp], faces: Faces
) -> tuple[NDArray[np.intp], Faces]:
    """Make one vertex of border vertices that are apart by rounding, of a mesh that is welded.

    A sine of a whole turn is not quite none: spheres and tubes of other programs have a seam so.

    Parameters
    ----------
    vertices : (v, 3) float32
        As `weld` takes them.
    kept, faces
        As `weld` returns them.

    Returns
    -------
    kept, faces
        As `weld` returns them; faces may name a vertex twice.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    one, other = faces.astype(np.int64), np.roll(faces, -1, axis=1).astype(np.int64)
    edges = np.minimum(one, other) * len(kept) + np.maximum(one, other)
    edges, uses = np.unique(edges, return_counts=True)
    border = np.unique(np.divmod(edges[uses == 1], max(len(kept), 1)))
    if len(border) < 2:
        return kept, faces
    points = vertices[kept[border]].astype(np.float64)
    cell = 2.0 * ROUNDING * max(float(np.abs(points).max()), 1e-30)
    nearest = KDTree(points).query(points, [2], p=np.inf, distance_upper_bound=2.0 * cell)[0]
    close = np.isfinite(np.asarray(nearest)[:, 0])
    if not close.any():
        return kept, faces
    border, points = border[close], points[close]
    # Two within half a cell of each other are in one cell of at least one of eight grids, whose
    # cells have numbers of 20 bits along each axis.
    shifts = np.array(list(np.ndindex(2, 2, 2)))
    cells = np.floor(points / cell + 0.5 * shifts[:, None]).astype(np.int64) + (1 << 19)
    keys = np.arange(8)[:, None]
    for k in range(3):
        keys = (keys << 20) | cells[..., k]
    _, number = np.unique(keys, return_inverse=True)
    ends = np.tile(np.arange(len(border)), 8), len(border) + number.ravel()
    count = int(ends[1].max()) + 1
    graph = coo_array((np.ones(len(ends[0]), np.int8), ends), shape=(count, count))
    label = connected_components(graph, directed=False)[1][: len(border)]
    _, first, which = np.unique(label, return_index=True, return_inverse=True)
    target = np.arange(len(kept))
    target[border] = border[first[which.ravel()]]
    used, number = np.unique(target, return_inverse=True)
    return kept[used], np.asarray(number.ravel()[faces], np.int32)


def is_degenerate(faces: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Return which triangles name a vertex twice."""
    a, b, c = faces.T
    return np.asarray((a == b) | (b == c) | (c == a))


def without_degenerate(faces: Faces) -> Faces:
    """Remove triangles that name a vertex twice."""
    return np.asarray(faces[~is_degenerate(faces)])


def triangulate(
    vertices: NDArray[np.float64], corners: NDArray[np.int64], sizes: NDArray[np.int64]
) -> Faces:
    """Cut polygons into triangles.

    Convex ones are cut as a fan from their first corner; for the others manifold3d finds
    the triangles in the plane of their area vector.

    Parameters
    ----------
    vertices : (v, 3) float
        Places, in the units of the file.
    corners : (n,) int
        The corners of all polygons, one polygon after the other; existing vertices.
    sizes : (p,) int
        How many corners each has. Those with fewer than three are left out.

    Returns
    -------
    (f, 3) int32
        Polygon after polygon, wound as the polygons are.
    """
    at_most(int(np.maximum(sizes - 2, 0).sum()), MAX_FACES, "triangles")
    starts = np.cumsum(sizes) - sizes
    faces: list[Faces] = []
    owners: list[NDArray[np.int64]] = []
    effort = 0
    for size in np.unique(sizes[sizes >= 3]).tolist():
        whole = np.flatnonzero(sizes == size)
        step = max(1, CORNERS_AT_ONCE // size)
        for which in (whole[k : k + step] for k in range(0, len(whole), step)):
            rings = corners[starts[which, None] + np.arange(size)]
            if size == 4:
                rings = _turned_quads(vertices, rings)
            tips = np.arange(1, size - 1)
            fans = np.stack((np.repeat(rings[:, :1], size - 2, axis=1), rings[:, tips],
                             rings[:, tips + 1]), axis=2)  # fmt: skip
            if size > 4:
                hollow = np.flatnonzero(~_convex(vertices[rings]))
                effort += len(hollow) * (size * size + PER_POLYGON)
                if exceeds(effort, MAX_EFFORT):
                    raise FormatError(TOO_MANY_CORNERS)
                for row in hollow:
                    fans[row] = _cut(vertices[rings[row]], rings[row], fans[row])
            faces.append(fans.reshape(-1, 3).astype(np.int32))
            owners.append(np.repeat(which, size - 2))
    if not faces:
        return np.zeros((0, 3), np.int32)
    order = np.argsort(np.concatenate(owners), kind="stable")
    return np.concatenate(faces)[order].astype(np.int32)


def _turned_quads(vertices: NDArray[np.float64], rings: NDArray[np.int64]) -> NDArray[np.int64]:
    """Rotate quadrangles to begin at the corner whose diagonal lies inside."""
    a, b, c, d = np.moveaxis(vertices[rings], 1, 0)
    area = np.cross(c - a, d - b)
    inside = [
        np.einsum("pi,pi->p", np.cross(one - tip, two - tip), area)
        for one, tip, two in ((b, a, c), (c, a, d))
    ]
    outside = np.minimum(*inside) < 0
    return np.where(outside[:, None], np.roll(rings, -1, axis=1), rings)


def _convex(rings: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which polygons, shape (p, k, 3), turn the same way at every corner."""
    edges = np.roll(rings, -1, axis=1) - rings
    turns = np.cross(edges, np.roll(edges, -1, axis=1))
    fans = np.cross(rings[:, 1:-1] - rings[:, :1], rings[:, 2:] - rings[:, :1])
    area = fans.sum(axis=1)
    return np.asarray((np.einsum("pki,pi->pk", turns, area) >= 0).all(axis=1))


def _cut(
    ring: NDArray[np.float64], indices: NDArray[np.int64], fan: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Triangulate one polygon that is not convex; fall back to a fan where that fails."""
    import manifold3d

    area = np.cross(ring[1:-1] - ring[0], ring[2:] - ring[0]).sum(axis=0)
    drop = int(np.argmax(np.abs(area)))
    flat = ring[:, [(drop + 1) % 3, (drop + 2) % 3]]
    if area[drop] < 0:
        flat = flat[:, ::-1]
    try:
        cut = np.asarray(manifold3d.triangulate([np.ascontiguousarray(flat)]), np.int64)
    except (RuntimeError, ValueError):
        return fan
    return indices[cut] if cut.shape == fan.shape else fan


def check_places(vertices: NDArray[np.floating]) -> None:
    """Refuse coordinates that are not finite or absurdly large.

    Raises
    ------
    FormatError
    """
    with np.errstate(invalid="ignore"):
        sane = bool((np.abs(vertices) <= MAX_COORDINATE).all())
    if not sane:
        raise FormatError("A vertex is not finite, or further away than a mesh can reach.")


def checked_mesh(
    vertices: NDArray[np.floating],
    faces: NDArray[np.integer],
    normals: NDArray[np.floating] | None = None,
    colors: NDArray[np.uint8] | None = None,
) -> Mesh:
    """Make a mesh of a file's arrays, if they can be trusted.

    Raises
    ------
    FormatError
        If a coordinate is not finite or absurdly large, or a face names a vertex that the
        file does not hold.
    """
    if not len(faces):
        raise FormatError("There are no faces in this file.")
    check_places(vertices)
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise FormatError("A face names a vertex that the file does not hold.")
    if colors is not None and len(colors) != len(vertices):
        raise FormatError("There are not as many colours in this file as vertices.")
    if normals is not None and (len(normals) != len(vertices) or not np.isfinite(normals).all()):
        normals = None  # shading can be had again from the faces
    return Mesh(
        vertices.astype(np.float32),
        faces.astype(np.int32),
        None if normals is None else normals.astype(np.float32),
        colors,
    )
