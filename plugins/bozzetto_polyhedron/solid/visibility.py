"""Hidden lines, exactly: edges are cut where they cross in the picture, each piece asked once.

Between two crossings the visibility of a piece of an edge cannot change (Appel 1967), so that its
middle decides for all of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.view import Camera
from bozzetto_polyhedron.solid.face_rings import edges_of, sides_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody

AT_END: Final = 1e-9
"""Share of an edge at its ends within which no crossing cuts it: edges that share a corner."""

IN_FRONT: Final = 1e-9
"""Share of the distance by which a face must be nearer than a point to hide it."""

EDGE_ON: Final = 1e-12
"""Sine of the angle to the line of sight below which a face hides nothing."""

NEAREST: Final = 1e-6
"""Depth, as share of the distance of the sheet, before which nothing is seen in perspective."""


@dataclass(frozen=True, eq=False)
class EdgePieces:
    """Pieces of edges, each wholly seen or wholly hidden.

    Parameters
    ----------
    edges : (m, 2) intp
        Ends of all edges, numbers of vertices.
    edge : (k,) intp
        Number of the edge that each piece is of, in order along it.
    ends : (k, 2, 3) float64
        mm.
    hidden : (k,) bool
    """

    edges: Index
    edge: Index
    ends: Array
    hidden: Flags


def visible_pieces(body: PlanarBody, camera: Camera) -> EdgePieces:
    """Cut the edges of a body into pieces that are seen and pieces that faces hide.

    Parameters
    ----------
    body : PlanarBody
        A solid or a sheet.
    camera : Camera
        Parallel or perspective; what lies behind the eye is left out.
    """
    edges = edges_of(body.faces)
    starts, ends, kept = _before_eye(body.vertices[edges], camera)
    places, depths = camera.project(np.concatenate((starts, ends)))
    count = len(starts)
    first, second = places[:count], places[count:]
    one, share = _crossings(first, second)
    if camera.kind == "perspective":
        near, far = depths[:count][one], depths[count:][one]
        share = share * near / ((1.0 - share) * far + share * near)
    owner = np.concatenate((np.arange(count), one, np.arange(count)))
    at = np.concatenate((np.zeros(count), share, np.ones(count)))
    order = np.lexsort((at, owner))
    owner, at = owner[order], at[order]
    whole = (owner[1:] == owner[:-1]) & (at[1:] - at[:-1] > AT_END)
    pieces, low, high = owner[1:][whole], at[:-1][whole], at[1:][whole]
    along = ends - starts
    middles = starts[pieces] + (0.5 * (low + high))[:, None] * along[pieces]
    hidden = _hidden(body, camera, middles, _own_faces(body, edges)[kept[pieces]])
    pieces, low, high, hidden = _joined(pieces, low, high, hidden)
    cut = np.stack(
        (
            starts[pieces] + low[:, None] * along[pieces],
            starts[pieces] + high[:, None] * along[pieces],
        ),
        axis=1,
    )
    return EdgePieces(edges, kept[pieces], cut, hidden)


def _before_eye(lines: Array, camera: Camera) -> tuple[Array, Array, Index]:
    """Return starts and ends of lines (m, 2, 3), clipped before the eye, and which are left."""
    starts, ends = lines[:, 0].copy(), lines[:, 1].copy()
    if camera.kind == "orthographic":
        return starts, ends, np.arange(len(lines))
    limit = NEAREST * camera.distance
    depth = camera.view_space(lines.reshape(-1, 3))[:, 2].reshape(-1, 2)
    kept = np.flatnonzero(depth.max(axis=1) > limit)
    starts, ends, depth = starts[kept], ends[kept], depth[kept]
    span = np.where(depth[:, 1] == depth[:, 0], 1.0, depth[:, 1] - depth[:, 0])
    cut = starts + ((limit - depth[:, 0]) / span)[:, None] * (ends - starts)
    return (
        np.where((depth[:, 0] < limit)[:, None], cut, starts),
        np.where((depth[:, 1] < limit)[:, None], cut, ends),
        kept,
    )


def _crossings(first: Array, second: Array) -> tuple[Index, Array]:
    """Return which segments of the picture are crossed, and at which share of their length."""
    along = second - first
    cross = along[:, None, 0] * along[None, :, 1] - along[:, None, 1] * along[None, :, 0]
    offset = first[None] - first[:, None]
    safe = np.where(cross == 0.0, 1.0, cross)
    at = (offset[..., 0] * along[None, :, 1] - offset[..., 1] * along[None, :, 0]) / safe
    other = (offset[..., 0] * along[:, None, 1] - offset[..., 1] * along[:, None, 0]) / safe
    meets = (cross != 0.0) & (at > AT_END) & (at < 1 - AT_END) & (other > -AT_END)
    one, two = np.nonzero(meets & (other < 1 + AT_END))
    return one, at[one, two]


def _own_faces(body: PlanarBody, edges: Index) -> Flags:
    """Whether an edge is a side of a face, (m, f)."""
    numbers = {(int(a), int(b)): k for k, (a, b) in enumerate(edges)}
    own = np.zeros((len(edges), len(body.faces)), bool)
    for face, rings in enumerate(body.faces):
        for ring in rings:
            own[[numbers[min(side), max(side)] for side in sides_of(ring)], face] = True
    return own


def _hidden(body: PlanarBody, camera: Camera, points: Array, own: Flags) -> Flags:
    """Whether any face that a point does not belong to lies between it and the eye, (k,)."""
    if camera.kind == "orthographic":
        depth = camera.view_space(points)[:, 2]
        reach = float(np.ptp(camera.view_space(body.vertices)[:, 2])) or 1.0
        sight = np.broadcast_to(camera.axes[2] * reach, points.shape)
        depth = np.full_like(depth, reach)
    else:
        sight = points - np.asarray(camera.eye)
        depth = np.linalg.norm(sight, axis=1)
    slope = sight @ body.normals.T
    height = points @ body.normals.T - body.offsets
    facing = np.abs(slope) > EDGE_ON * depth[:, None]
    back = height / np.where(facing, slope, 1.0)
    before = facing & (back > IN_FRONT) & ~own
    if camera.kind == "perspective":
        before &= back < 1.0
    return np.asarray((before & _within(body, points, sight, back)).any(axis=1))


def _within(body: PlanarBody, points: Array, sight: Array, back: Array) -> Flags:
    """Whether rays meet planes within the faces, (k, f), by the parity of crossings.

    Faces are seen along the largest coordinate of their normals.
    """
    sides = [
        (face, *side)
        for face, rings in enumerate(body.faces)
        for ring in rings
        for side in sides_of(ring)
    ]
    face, start, end = np.array(sides, np.intp).T
    drop = np.abs(body.normals).argmax(axis=1)
    across, up = (drop + 1) % 3, (drop + 2) % 3
    hit_x = points[:, across] - back * sight[:, across]
    hit_y = points[:, up] - back * sight[:, up]
    x0, y0 = body.vertices[start, across[face]], body.vertices[start, up[face]]
    x1, y1 = body.vertices[end, across[face]], body.vertices[end, up[face]]
    y = hit_y[:, face]
    straddles = (y0 > y) != (y1 > y)
    rise = np.where(y1 == y0, 1.0, y1 - y0)
    crossed = straddles & (hit_x[:, face] < x0 + (x1 - x0) * (y - y0) / rise)
    first = np.searchsorted(face, np.arange(len(body.faces)))
    return np.asarray(np.add.reduceat(crossed, first, axis=1, dtype=np.intp) % 2 == 1)


def _joined(
    pieces: Index, low: Array, high: Array, hidden: Flags
) -> tuple[Index, Array, Array, Flags]:
    """Join neighbours on one edge that are both seen or both hidden."""
    begins = np.ones(len(pieces), bool)
    begins[1:] = (pieces[1:] != pieces[:-1]) | (hidden[1:] != hidden[:-1])
    first = np.flatnonzero(begins)
    last = np.append(first[1:], len(pieces))[: len(first)] - 1
    return pieces[first], low[first], high[last], hidden[first]
