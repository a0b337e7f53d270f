"""Quad-dominant meshes of surfaces: a field of directions, a lattice along it, quads of its nodes.

The result has the topology of the surface, whatever becomes of the lattice: vertices are joined
only where the mesh stays one. Where a surface is its own mirror image, one half is meshed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.geometry.decimation import decimated
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.mesh_places import MeshPlaces, closest_on_mesh
from bozzetto.geometry.quads.extraction import (
    LEAST_QUALITY,
    nodes,
    paired,
    qualities,
    rings_of,
    tidied,
)
from bozzetto.geometry.quads.mirrors import ON_PLANE, Plane, half, mirror_planes, with_image
from bozzetto.geometry.quads.orientation_field import frames_of, orientations
from bozzetto.geometry.quads.position_field import lattice
from bozzetto.geometry.quads.roughness import calmed, denoised
from bozzetto.geometry.quads.surface import (
    Edges,
    Features,
    across,
    edges_of,
    features_of,
    refined,
    units,
)

if TYPE_CHECKING:
    from collections.abc import Callable

FINE: Final = 0.75
"""Longest edge of the surface that the lattice is laid on, in sides of squares."""

FINER: Final = 0.4
"""The same where there are few squares, among which each counts."""

MOST_FINE: Final = 100
"""So many triangles there may be for each quad."""

MOST_MORE: Final = 4000
"""And so many besides."""

DENSE: Final = 40
"""With more triangles for a quad than this the surface is thinned out first."""

THINNED: Final = 16
"""To so many triangles for a quad."""

SMALL: Final = 8
"""With more triangles for a quad than this what is rough about them is no shape."""

USUAL_SIDE: Final = 1.02
"""Of squares of which there are as many as are wanted: some are triangles."""

CHORD: Final = 0.02
"""Distance from a mirror up to which a vertex lies on it, in sides of squares."""

CLOSE: Final = 0.07
"""Share by which the number of quads may miss before the side of the squares is changed."""

PAIRED: Final = 1.6
"""Triangles for each face where they are joined in pairs: some find no partner."""

MISSES: Final = 10.0
"""How much it counts that the number is missed by more, beside the share of triangles."""

TRIES: Final = 3
"""How many sides are tried."""

TORN: Final = 0.1
"""Share of triangles from which other sides are tried, where there are few faces."""

FEW: Final = 600
"""So many are laid soon."""

OTHERS: Final = (0.95, 1.05, 1.0)
"""Shares of the usual side that are tried."""

SMOOTHED: Final = 4
"""Rounds in which vertices go towards the middle of their neighbours."""

ASIDE: Final = 0.5
"""Distance within which a vertex finds its place on the side that it faces, in sides of squares."""

MOST_DEVIATION: Final = 0.01
"""Distance of the surface from the quads, as a share of the diagonal, up to which they are one."""

COARSE: Final = 0.35
"""Distance up to which they are one where they are few, in sides of squares."""

FOLDED: Final = 0.05
"""Quality below which a quad becomes two triangles: it has an angle of nearly 180°, or more."""

MEASURED: Final = 2000
"""Vertices of the surface, evenly chosen, whose distance from the quads is measured."""

FEWEST: Final = 6
"""A box has so many."""


@dataclass(frozen=True, eq=False)
class QuadMesh:
    """A mesh of quads and some triangles.

    Attributes
    ----------
    points : (n, 3) float
        On the surface, mm.
    quads : (q, 4) int
    triangles : (t, 3) int
    deviation : float
        The largest distance of vertices of the surface from the mesh, of up to twice `MEASURED`
        of them, mm.
    remeshed : bool
        Whether a lattice was laid; else pairs of triangles of the surface are joined.
    """

    points: Array
    quads: Index
    triangles: Index
    deviation: float
    remeshed: bool

    @property
    def count(self) -> int:
        """Faces of both kinds."""
        return len(self.quads) + len(self.triangles)


def quad_dominant(
    mesh: Mesh,
    count: int,
    groups: Index | None = None,
    checkpoint: Callable[[], None] = lambda: None,
) -> QuadMesh:
    """Lay quads over a surface.

    Parameters
    ----------
    mesh : Mesh
        mm; vertices are joined by number, not by place.
    count : int
        Quads and triangles that are wanted; creases and topology may want more.
    groups : (f,) int, optional
        A number for each triangle; quads keep to the borders between them.
    checkpoint : callable
        Called between steps; may raise to stop.
    """
    points = mesh.vertices.astype(np.float64)
    faces = mesh.faces.astype(np.intp)
    kind = np.zeros(len(faces), np.intp) if groups is None else np.asarray(groups, np.intp)
    a, b, c = faces.T
    proper = (a != b) & (b != c) & (c != a)
    faces, kind = faces[proper], kind[proper]
    used, corners = np.unique(faces, return_inverse=True)
    points, faces = points[used], corners.reshape(-1, 3)
    whole = _topology(edges_of(faces), faces)
    if len(faces):
        many = max(count, FEWEST)
        side = float(np.sqrt(_area(points, faces) / many))
        calm = calmed(points, faces, many, side, checkpoint)
        planes = mirror_planes(calm, faces)
        for some in (planes, []) if planes else ([],):
            made = _laid(calm, faces, kind, many, some, [], checkpoint)
            if made is not None and _topology_of(made) == whole:
                diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
                if _deviation(calm, *made) <= max(MOST_DEVIATION * diagonal, COARSE * side):
                    return QuadMesh(*made, _deviation(points, *made), remeshed=True)
    return _pairs_of(points, faces, kind, count, checkpoint)


def _pairs_of(
    points: Array, faces: Index, kind: Index, count: int, checkpoint: Callable[[], None]
) -> QuadMesh:
    """Join triangles in pairs, after taking away what is too many."""
    mesh = Mesh(points.astype(np.float32), faces.astype(np.int32))
    fewer = decimated(mesh, int(PAIRED * count), kind, checkpoint)
    kept, corners = points[fewer.vertices], fewer.faces.astype(np.intp)
    edges = edges_of(corners)
    features = features_of(kept, corners, fewer.groups, edges)
    pairs = paired(kept, corners, fewer.groups, edges, features.edges, features.corner)
    rest = np.setdiff1d(np.arange(len(corners)), pairs.ravel())
    made = kept, rings_of(corners, pairs), corners[rest]
    return QuadMesh(*made, _deviation(points, *made), remeshed=False)


def _laid(
    points: Array,
    faces: Index,
    kind: Index,
    count: int,
    planes: list[Plane],
    done: list[Plane],
    checkpoint: Callable[[], None],
) -> tuple[Array, Index, Index] | None:
    """Lay quads over a surface, over one half of each mirror; None where there are none.

    Of the mirrors in `done` it is a half already.
    """
    if planes:
        plane = planes[0]
        reach = ON_PLANE * float(np.linalg.norm(np.ptp(points, axis=0)))
        part = half(points, faces, kind, plane, reach)
        if part is None or not len(part[1]):
            return None
        made = _laid(*part, (count + 1) // 2, planes[1:], [*done, plane], checkpoint)
        if made is None:
            return None
        own, quads, triangles = made
        edges = edges_of(_fans(quads, triangles))
        on = np.zeros(len(own), bool)
        on[edges.ends[edges.faces[:, 1] < 0]] = True
        on &= np.abs(plane.distances(own)) <= 10.0 * reach
        across_plane = on[edges.ends].all(axis=1) & (edges.faces[:, 1] >= 0)
        if across_plane.any():
            return None  # both halves would have that edge
        own, (quads, triangles) = with_image(own, [quads, triangles], plane, on)
        return own, quads, triangles
    area = _area(points, faces)
    if not area > 0.0:
        return None
    # In units of its own size: the same whatever the unit and the place.
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    size = float(np.sqrt(area))
    local = (points - middle) / size
    surface = Mesh(local.astype(np.float32), faces.astype(np.int32))
    dense = local, faces, kind
    if len(faces) > SMALL * count:
        even = denoised(local, faces, checkpoint)
        dense = even, faces, kind
        if len(faces) > DENSE * count:
            smooth = Mesh(even.astype(np.float32), surface.faces)
            fewer = decimated(smooth, THINNED * count, kind, checkpoint)
            dense = even[fewer.vertices], fewer.faces.astype(np.intp), fewer.groups
    mirrors = [
        Plane(plane.normal, (plane.offset - float(middle @ plane.normal)) / size) for plane in done
    ]
    side = USUAL_SIDE / np.sqrt(count)
    best = None
    least = np.inf
    sides = [side]
    for turn in range(TRIES):
        checkpoint()
        made = _at_scale(surface, dense, sides[turn], mirrors, checkpoint)
        if made is None or not len(made[1]) + len(made[2]):
            break
        found = len(made[1]) + len(made[2])
        miss = abs(np.log(found / count))
        cost = MISSES * max(0.0, miss - CLOSE) + len(made[2]) / found
        if cost < least:
            best, least = made, cost
        if miss > CLOSE:
            sides.append(sides[turn] * np.sqrt(found / count))
        elif len(made[2]) > TORN * found and count <= FEW:
            sides.append(side * OTHERS[turn])  # between its edges others may fit better
        else:
            break
    if best is None:
        return None
    return best[0] * size + middle, best[1], best[2]


def _at_scale(
    surface: Mesh,
    dense: tuple[Array, Index, Index],
    side: float,
    planes: list[Plane],
    checkpoint: Callable[[], None],
) -> tuple[Array, Index, Index] | None:
    """Lay quads with sides of a length; return points, quads and triangles.

    None where the surface is so thin that it is made of slivers at that length.
    """
    longest = (FINER if FEW * side**2 >= 1.0 else FINE) * side
    fine = refined(dense[0], dense[1], longest, int(MOST_FINE / side**2) + MOST_MORE)
    if fine is None:
        return None
    points, faces, origin = fine
    kind = dense[2][origin]
    edges = edges_of(faces)
    features = features_of(points, faces, kind, edges, side)
    frames = frames_of(points, faces, edges)
    angles = orientations(points, faces, edges, features, frames)
    checkpoint()
    found = lattice(points, edges, features, frames, angles, side)
    checkpoint()
    graph = nodes(points, faces, kind, edges, features, found, side)
    checkpoint()
    tidied(graph, side, planes, CHORD * side)
    checkpoint()
    place, corners, groups, lines, used = graph.as_arrays()
    corner = np.array(graph.corner, bool)[used]
    even = _even(features, used, lines)
    ends = edges_of(corners)
    pairs = paired(place, corners, groups, ends, lines, corner)
    rest = np.setdiff1d(np.arange(len(corners)), pairs.ravel())
    quads, triangles = rings_of(corners, pairs), corners[rest]
    place = _smoothed(
        place, quads, triangles, lines, corner, even, surface, points[features.edges], side
    )
    folded = qualities(place, quads) < FOLDED
    return place, quads[~folded], np.concatenate((triangles, _fans(quads[folded], triangles[:0])))


def _even(features: Features, used: Index, lines: Index) -> Flags:
    """Return which vertices lie within a border of groups on a smooth surface, (n,).

    Parameters
    ----------
    features : Features
        Of the surface.
    used : (n,) int
        Vertex of the surface that each one was; those beyond are new.
    lines : (k, 2) int
        Edges on features.
    """
    old = used < len(features.even)
    even = np.zeros(len(used), bool)
    even[old] = features.even[used[old]]
    one, other = np.concatenate((lines, lines[:, ::-1])).T
    even[one[~old[one] & even[other]]] = True
    return even


def _smoothed(
    place: Array, quads: Index, triangles: Index, lines: Index, corner: Flags, even: Flags,
    surface: Mesh, features: Array, side: float,
) -> Array:  # fmt: skip
    """Move vertices towards the middle of their neighbours, on the surface and along features."""
    sides = [
        np.stack((ring, np.roll(ring, -1, axis=1)), axis=2).reshape(-1, 2)
        for ring in (quads, triangles)
    ]
    ends = np.unique(np.sort(np.concatenate(sides), axis=1), axis=0)
    on_line = np.zeros(len(place), bool)
    on_line[lines] = True
    free = ends[~on_line[ends].all(axis=1) | ~_among(ends, lines, len(place))]
    both = np.concatenate((free, free[:, ::-1]))
    both = both[~on_line[both[:, 0]]]
    kept = np.concatenate((lines, lines[:, ::-1]))
    both = np.concatenate((both, kept))
    both = both[~corner[both[:, 0]]]
    many = np.bincount(both[:, 0], minlength=len(place)).astype(float)
    moves = many > 0
    faces = _fans(quads, triangles)
    bound = on_line & ~even
    place = begin = _onto(place, faces, surface, features, bound, corner, side)
    for turn in range(SMOOTHED):
        middle = np.column_stack([
            np.bincount(both[:, 0], place[both[:, 1], axis], len(place)) for axis in range(3)
        ])  # fmt: skip
        step = np.zeros_like(place)
        step[moves] = 0.5 * (middle[moves] / many[moves, None] - place[moves])
        normal = _normals(place, faces)
        flat = step - normal * np.einsum("ij,ij->i", step, normal)[:, None]
        place = place + np.where(bound[:, None], step, flat)
        if turn % 2:
            place = _onto(place, faces, surface, features, bound, corner, side)
    for _ in range(SMOOTHED):
        before, after = (qualities(one, quads) for one in (begin, place))
        worse = quads[(after < before) & (after < LEAST_QUALITY)]
        if not len(worse):
            break
        place[worse] = begin[worse]
    return place


def _among(ends: Index, lines: Index, count: int) -> Flags:
    """Whether edges (e, 2), sorted, are among others (k, 2)."""
    own = np.sort(lines, axis=1)
    return np.isin(ends[:, 0] * count + ends[:, 1], own[:, 0] * count + own[:, 1])


def _onto(
    place: Array, faces: Index, surface: Mesh, features: Array, on_line: Flags, corner: Flags,
    side: float,
) -> Array:  # fmt: skip
    """Return the nearest places on the surface, or on its features.

    A place that faces the same way is looked for nearby: where the mesh is folded its normal is of
    any direction.
    """
    made = place.copy()
    free = np.flatnonzero(~on_line & ~corner)
    near = closest_on_mesh(surface, place[free], _normals(place, faces)[free], ASIDE * side)
    made[free] = near.points(surface)
    bound = np.flatnonzero(on_line & ~corner)
    if len(bound) and len(features):
        flat = np.concatenate((features, features[:, 1:]), axis=1).reshape(-1, 3)
        lines = Mesh(flat.astype(np.float32), np.arange(len(flat), dtype=np.int32).reshape(-1, 3))
        made[bound] = closest_on_mesh(lines, place[bound]).points(lines)
    return made


def _area(points: Array, faces: Index) -> float:
    return 0.5 * float(np.linalg.norm(across(points, faces), axis=1).sum())


def _normals(place: Array, faces: Index) -> Array:
    large = across(place, faces)
    total = np.column_stack([
        np.bincount(faces.ravel(), np.repeat(large[:, axis], 3), len(place)) for axis in range(3)
    ])  # fmt: skip
    return units(np.asarray(total, np.float64))


def _fans(quads: Index, triangles: Index) -> Index:
    """Return triangles of quads, cut along a diagonal, two by two, and then triangles, (f, 3)."""
    cut = quads[:, (0, 1, 2, 0, 2, 3)].reshape(-1, 3)
    return np.concatenate((cut, triangles))


def _deviation(points: Array, place: Array, quads: Index, triangles: Index) -> float:
    """Return the largest distance of points from a mesh of quads."""
    mesh = Mesh(place.astype(np.float32), _fans(quads, triangles).astype(np.int32))
    if not len(mesh.faces):
        return np.inf
    some = points[:: 1 + len(points) // MEASURED]
    return float(closest_on_mesh(mesh, some).distances.max(initial=0.0))


def _topology_of(made: tuple[Array, Index, Index]) -> tuple[int, ...]:
    faces = _fans(made[1], made[2])
    return _topology(edges_of(faces), faces)


def _topology(edges: Edges, faces: Index) -> tuple[int, ...]:
    """Return what must stay: Euler's number, pieces, rings of borders, crowded edges or not."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    used, _corners = np.unique(faces, return_inverse=True)
    place = np.full(int(faces.max(initial=-1)) + 1, -1)
    place[used] = np.arange(len(used))
    euler = len(used) - len(edges.ends) + len(faces)
    shape = (len(used), len(used))

    def pieces(ends: Index) -> Index:
        i, j = place[ends].T
        joined = coo_array((np.ones(len(i)), (i, j)), shape)
        return np.asarray(connected_components(joined, directed=False)[1], np.intp)

    border = edges.ends[edges.faces[:, 1] < 0]
    rings = pieces(border)[place[np.unique(border)]]
    parts = int(pieces(edges.ends).max(initial=-1)) + 1
    return euler, parts, len(np.unique(rings)), int(edges.crowded.any())


def places_on(mesh: Mesh, made: QuadMesh) -> MeshPlaces:
    """Return where the vertices of quads lie on the surface that they were laid over."""
    normals = _normals(made.points, _fans(made.quads, made.triangles))
    return closest_on_mesh(mesh, made.points, normals)
