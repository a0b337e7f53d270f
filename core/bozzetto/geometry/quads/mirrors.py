"""Planes in which a surface is its own mirror image, and halves of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.quads.surface import across, edges_of

SAME: Final = 2e-5
"""Distance of a vertex from the image of another, as a share of the diagonal."""

ON_PLANE: Final = 2e-5
"""Distance from the plane up to which a vertex is moved onto it, as a share of the diagonal."""

ALIKE: Final = 1e-6
"""Share by which two axes of inertia must differ to be told apart."""


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane: points whose product with the unit normal is the offset."""

    normal: Array
    offset: float

    def distances(self, points: Array) -> Array:
        """Return the signed distances of points (n, 3), (n,)."""
        return np.asarray(points @ self.normal - self.offset)

    def images(self, points: Array) -> Array:
        """Return the mirror images of points (n, 3)."""
        return np.asarray(points - 2.0 * self.distances(points)[:, None] * self.normal)

    def onto(self, points: Array) -> Array:
        """Return the feet of points (n, 3) on the plane."""
        return np.asarray(points - self.distances(points)[:, None] * self.normal)


def mirror_planes(points: Array, faces: Index) -> list[Plane]:
    """Return planes in which a surface is its own mirror image, at right angles to one another.

    Looked for along the axes of the frame and the surface's own axes of inertia, through the
    middle of its area.

    Parameters
    ----------
    points : (n, 3) float
        All in use.
    faces : (f, 3) int
        Triangles.
    """
    from scipy.spatial import cKDTree

    area = np.linalg.norm(across(points, faces), axis=1)
    middles = points[faces].mean(axis=1)
    if not area.sum() > 0.0:
        return []
    centre = area @ middles / area.sum()
    spread = (middles - centre).T @ ((middles - centre) * area[:, None]) / area.sum()
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    tree = cKDTree(points)
    found: list[Plane] = []
    for normal in (*np.eye(3), *np.linalg.eigh(spread)[1].T):
        if any(abs(float(normal @ plane.normal)) > ALIKE for plane in found):
            continue
        plane = Plane(normal, float(centre @ normal))
        reach, _ = tree.query(plane.images(points), distance_upper_bound=SAME * diagonal)
        if np.isfinite(reach).all():
            found.append(plane)
    return found


def half(
    points: Array, faces: Index, kind: Index, plane: Plane, reach: float
) -> tuple[Array, Index, Index] | None:
    """Return the half of a surface on the positive side of a plane; None where one lies in it.

    Parameters
    ----------
    points, faces, kind
        Of the surface: (n, 3), (f, 3), and a group for each triangle, (f,).
    plane : Plane
        Through the surface.
    reach : float
        Up to this distance vertices are moved onto the plane.

    Returns
    -------
    points, faces, kind
        Those on the border lie on the plane.
    """
    distance = plane.distances(points)
    on = np.abs(distance) <= reach
    points = np.where(on[:, None], plane.onto(points), points)
    side = np.where(on, 0, np.sign(distance)).astype(int)
    cut = np.sort(side[faces], axis=1)
    if (cut == 0).all(axis=1).any():
        return None
    # Edges that cross the plane are cut once, and both triangles have the same vertex.
    edges = edges_of(faces)
    crossing = (side[edges.ends] != 0).all(axis=1) & (side[edges.ends].sum(axis=1) == 0)
    a, b = edges.ends[crossing].T
    share = (distance[a] / (distance[a] - distance[b]))[:, None]
    middle = np.full(len(edges.ends), -1)
    middle[crossing] = len(points) + np.arange(len(a))
    points = np.concatenate((points, plane.onto(points[a] + share * (points[b] - points[a]))))
    side = np.concatenate((side, np.zeros(len(a), int)))
    whole = (side[faces] >= 0).all(axis=1)
    rows, groups = [faces[whole]], [kind[whole]]
    crossed = np.flatnonzero((cut[:, 0] < 0) & (cut[:, 2] > 0))
    made = []
    for face, middles, group in zip(
        faces[crossed].tolist(), middle[edges.of_side[crossed]].tolist(), kind[crossed].tolist(),
        strict=True,
    ):  # fmt: skip
        ring = []
        for corner, between in zip(face, middles, strict=True):
            if side[corner] >= 0:
                ring.append(corner)
            if between >= 0:
                ring.append(between)
        made += [(ring[0], ring[k], ring[k + 1], group) for k in range(1, len(ring) - 1)]
    if made:
        more = np.array(made, np.intp)
        rows.append(more[:, :3])
        groups.append(more[:, 3])
    kept, owner = np.concatenate(rows), np.concatenate(groups)
    used, corners = np.unique(kept, return_inverse=True)
    return points[used], corners.reshape(-1, 3), owner


def with_image(
    points: Array, rings: list[Index], plane: Plane, on: Flags
) -> tuple[Array, list[Index]]:
    """Return a half and its mirror image, joined along the plane.

    Parameters
    ----------
    points : (n, 3) float
        Of the half.
    rings : list of (k, m) int
        Faces of several sizes m.
    plane : Plane
        The mirror.
    on : (n,) bool
        Vertices that both share: they are put onto the plane.

    Returns
    -------
    points, rings
        Of each size the faces of the half come first, then as many images.
    """
    points = np.where(on[:, None], plane.onto(points), points)
    image = np.arange(len(points))
    image[~on] = len(points) + np.arange(int((~on).sum()))
    both = np.concatenate((points, plane.images(points[~on])))
    return both, [np.concatenate((ring, image[ring][:, ::-1])) for ring in rings]
