"""Finer triangles where paint ends, so that its edges do not follow the triangles of the mesh.

The screen shows colours at vertices. Edges across which the paint changes are halved a few times;
every triangle beside a halved edge is divided with it, so no gap opens. The surface stays as it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bozzetto.arrays import Array, Faces, Flags, Index
from bozzetto.geometry import Mesh
from bozzetto_silhouette.appearance.paint_layer import Track, paint_at, painted_over
from bozzetto_silhouette.appearance.vertex_colors import CONTRAST, Coat, bare

FINEST = 0.125
"""Length of the edges that are left, in steps of the mesh: of a step that is seen as 8 px one."""

MOST_FACES = 200_000
"""Triangles that are shown at most: a further level that would make more is left out."""

FULL = 0.9
"""Share of these triangles from which no more are made: the next level would not fit."""

SOFT = 4.0
"""Width of an edge that fades, in edges of the mesh, from which these show it: what lies straight
between two vertices is then less than 12 of 255 off."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """How a mesh is divided, and the paint on what comes out.

    Attributes
    ----------
    points, normals : (n, 3) float array
        Of all vertices at rest, those of the mesh first.
    faces : (f, 3) int32 array
    parents : tuple of (k, 2) int array
        Step by step, the two vertices that each new one lies between.
    paint : Coat
        Of all vertices.
    boxes : (2, 3, f) float array
        The lowest and highest corners of the triangles: kept, for a stroke changes few of them.
    lengths : (f,) float array
        Of their longest sides.
    """

    points: Array
    normals: Array
    faces: Faces
    parents: tuple[Index, ...]
    paint: Coat
    boxes: Array
    lengths: Array

    @classmethod
    def of(cls, mesh: Mesh) -> Refinement:
        """Return a mesh as it is, without paint."""
        points = mesh.vertices.astype(np.float64)
        normals = mesh.vertex_normals().astype(np.float64)
        boxes, lengths = boxes_of(points, mesh.faces), longest_edges(points, mesh.faces)
        return cls(points, normals, mesh.faces, (), bare(len(points)), boxes, lengths)

    def spread(self, values: Array) -> Array:
        """Return values at the vertices of the mesh, (v, d), at all vertices."""
        whole = np.empty((len(self.points), values.shape[1]))
        whole[: len(values)] = values
        filled = len(values)
        for pair in self.parents:
            whole[filled : filled + len(pair)] = whole[pair].mean(axis=1)
            filled += len(pair)
        return whole

    def applied(self, mesh: Mesh) -> Mesh:
        """Divide a mesh with the same triangles, wherever its vertices are; without colours."""
        normals = self.spread(mesh.vertex_normals().astype(np.float64))
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        return replace(
            mesh,
            vertices=self.spread(mesh.vertices.astype(np.float64)).astype(np.float32),
            faces=self.faces,
            normals=normals.astype(np.float32),
            colors=None,
            cover=None,
        )


def refined(fine: Refinement, track: Track, step: float, finest: float = FINEST) -> Refinement:
    """Lay one more stroke on a mesh, whose triangles are divided where it ends.

    Parameters
    ----------
    fine : Refinement
        The mesh with the strokes before.
    track : Track
        The stroke.
    step : float
        Spacing of the mesh, mm; a few edges may be much longer.
    finest : float
        Length of the edges that are left where the paint ends, in steps.
    """
    points, normals, faces, parents = fine.points, fine.normals, fine.faces, list(fine.parents)
    paint, segments, boxes, lengths = fine.paint, track.segments, fine.boxes, fine.lengths
    drawn = track._replace(look=track.look._replace(color=(255, 255, 255), opacity=1.0))
    has_room = len(faces) < FULL * MOST_FACES
    detail = coarsest(lengths, step) if has_room and len(segments.ends) else 0.0
    while detail > 1.5 * finest * step:
        reach = float(segments.radii.max()) + detail
        low, high = segments.points.min(axis=0) - reach, segments.points.max(axis=0) + reach
        # Who shares an edge of this length has one.
        near = meets(boxes, low, high) & (lengths > 0.75 * detail)
        divided, pair = halved(points, normals, faces[near], [drawn], detail)
        if len(faces) - int(near.sum()) + len(divided) > MOST_FACES:
            break
        detail *= 0.5
        if len(pair):
            faces = np.concatenate([faces[~near], divided])
            points, normals = with_middles(points, normals, pair)
            boxes = np.concatenate([boxes[..., ~near], boxes_of(points, divided)], axis=2)
            lengths = np.concatenate([lengths[~near], longest_edges(points, divided)])
            paint = with_mixed(paint, pair)
            parents.append(pair)
    paint = painted_over(paint, track, points, normals, finest * step)
    return Refinement(points, normals, faces, tuple(parents), paint, boxes, lengths)


def with_mixed(coat: Coat, pair: Index) -> Coat:
    """Return a coat (v,), followed by what lies between some pairs of it (k, 2)."""
    return coat.joined(Coat(coat.rgb[pair].mean(axis=1), coat.cover[pair].mean(axis=1)))


def longest_edges(points: Array, faces: Faces) -> Array:
    """Return the length of the longest side of triangles, (f,)."""
    corners = points[faces]
    sides = np.roll(corners, -1, axis=1) - corners
    return np.asarray(np.sqrt(np.einsum("fkd,fkd->fk", sides, sides)).max(axis=1, initial=0.0))


def boxes_of(points: Array, faces: Faces) -> Array:
    """Return the lowest and highest corners of triangles, (2, 3, f)."""
    a, b, c = (np.ascontiguousarray(points[faces[:, k]].T) for k in range(3))
    return np.stack([np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)])


def meets(boxes: Array, low: Array, high: Array) -> Flags:
    """Return which boxes (2, 3, f) meet that between two corners."""
    lowest, highest = boxes
    flags = np.ones(lowest.shape[1], bool)
    for axis in range(3):
        flags &= (lowest[axis] <= high[axis]) & (highest[axis] >= low[axis])
    return flags


def coarsest(lengths: Array, step: float) -> float:
    """Return a length to begin to halve edges at: the longest edge, as a power of two of a step."""
    longest = float(lengths.max(initial=step))
    return float(step * 2.0 ** np.ceil(np.log2(longest / step)))


def halved(
    points: Array, normals: Array, faces: Faces, tracks: Sequence[Track], detail: float
) -> tuple[Faces, Index]:
    """Halve the edges of about a length across which the paint changes.

    Parameters
    ----------
    points, normals : (v, 3) float array
        Of the vertices.
    faces : (f, 3) int32 array
        All around an edge that may be halved.
    tracks : sequence of Track
        The strokes.
    detail : float
        The length, mm.

    Returns
    -------
    faces : (f, 3) int32 array
        What comes out; new vertices are counted on from v.
    pair : (k, 2) int array
        The two vertices that each new one lies between.
    """
    ends, sides = _edges(faces)
    long = np.flatnonzero(_lengths(points, ends) > 0.75 * detail)
    sharp = [_widened(track, detail) for track in tracks if _fade(track) < SOFT * detail]
    split = long[_changes(sharp, points, normals, ends[long], detail)]
    if not len(split):
        return faces, np.zeros((0, 2), np.intp)
    marked = np.full(len(ends), -1)
    marked[split] = len(points) + np.arange(len(split))
    return _divided(faces, marked[sides]), ends[split]


def with_middles(points: Array, normals: Array, pair: Index) -> tuple[Array, Array]:
    """Return points and unit normals (v, 3), followed by those between some pairs (k, 2)."""
    between = normals[pair].sum(axis=1)
    between /= np.maximum(np.linalg.norm(between, axis=1, keepdims=True), 1e-300)
    middles = points[pair].mean(axis=1)
    return np.concatenate([points, middles]), np.concatenate([normals, between])


def _lengths(points: Array, ends: Index) -> Array:
    return np.asarray(np.linalg.norm(points[ends[:, 1]] - points[ends[:, 0]], axis=1))


def _fade(track: Track) -> float:
    """Return the width over which the edge of a stroke fades in most of its places, mm."""
    return track.look.softness * float(np.median(track.segments.radii))


def _widened(track: Track, detail: float) -> Track:
    """Return a stroke that is nowhere so thin that edges of a length cross it unseen."""
    radii = np.maximum(track.segments.radii, 0.5 * detail)
    return track._replace(segments=track.segments._replace(radii=radii))


def _edges(faces: Faces) -> tuple[Index, Index]:
    """Return the edges (e, 2) of triangles, and which of them each side (f, 3) is.

    The side k of a triangle runs from its corner k to the next.
    """
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    size = int(faces.max(initial=0)) + 1
    keys, sides = np.unique(ends[:, 0].astype(np.int64) * size + ends[:, 1], return_inverse=True)
    return np.stack([keys // size, keys % size], axis=1), sides.reshape(-1, 3)


def _changes(
    tracks: Sequence[Track], points: Array, normals: Array, ends: Index, detail: float
) -> Flags:
    """Whether the paint differs between the ends and the middle of edges (e, 2)."""
    used, at = np.unique(ends, return_inverse=True)
    middle = points[ends].mean(axis=1)
    looks = normals[ends].sum(axis=1)
    looks /= np.maximum(np.linalg.norm(looks, axis=1, keepdims=True), 1e-300)
    coat = paint_at(
        tracks,
        np.concatenate([points[used], middle]),
        np.concatenate([normals[used], looks]),
        detail,
    )
    seen = np.column_stack([coat.rgb, 255.0 * coat.cover])
    corners = seen[at.reshape(ends.shape)]
    both = np.concatenate([corners, seen[len(used) :, None]], axis=1)
    return np.asarray(np.ptp(both, axis=1).max(axis=1) > CONTRAST)


def _divided(faces: Faces, middle: Index) -> Faces:
    """Divide triangles (f, 3) at the middles of their sides, (f, 3), −1 where a side stays."""
    count = (middle >= 0).sum(axis=1)
    # Turned so that the first side is halved, and the second, too, if two are.
    first = middle >= 0
    first = np.where((count == 2)[:, None], first & np.roll(first, -1, axis=1), first)
    turn = (first.argmax(axis=1)[:, None] + np.arange(3)) % 3
    rows = np.arange(len(faces))[:, None]
    corners, middles = faces[rows, turn], middle[rows, turn]
    (a, b, c), (ab, bc, ca) = corners.T, middles.T
    one, two, three = (np.flatnonzero(count == k) for k in (1, 2, 3))
    pieces = [faces[count == 0]]
    for kind, triangles in (
        (one, ((a, ab, c), (ab, b, c))),
        (two, ((a, ab, c), (ab, bc, c), (ab, b, bc))),
        (three, ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))),
    ):
        pieces += [np.stack([corner[kind] for corner in one_of], axis=1) for one_of in triangles]
    return np.concatenate(pieces).astype(np.int32)
