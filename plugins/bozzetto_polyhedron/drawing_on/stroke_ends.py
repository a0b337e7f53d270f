"""Strokes that are added to a body in any view: where their ends are in space.

The four cases of Masry et al. 2004, "Adding strokes", in their order: at a corner, along an edge,
within the face nearest to the viewer, or free. A free end is found along its ray from what the
other lines say, with everything that is known held fixed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.body_hits import Case, hit_by
from bozzetto_polyhedron.drawing_on.rings_on_faces import off_first_ring
from bozzetto_polyhedron.solid.face_rings import edges_of, sides_of, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import within_face
from bozzetto_polyhedron.solid.visibility import visible_pieces

DIRECTION: Final = np.radians(10.0)
"""Angle on the sheet within which a line runs along a direction of the body."""

AXIS_FIRST: Final = 0.7
"""Angles to the axes of the frame count for so much less than those to other edges."""

FORESHORTENED: Final = 0.1
"""Length on the sheet, as share of that across the line of sight, below which no direction is
read from a line."""

WEAK: Final = 1e-3
"""Weight of the guess that a free end is as far away as what it hangs on."""

PARALLEL: Final = float(np.cos(np.radians(3.0)))
"""Cosine between directions above which they are one."""

RISES: Final = 0.3
"""Cosine of the angle to a face's normal above which a line leaves the face."""

LEVEL: Final = 1e-6
"""Rise of a line, as share of its length, below which it lies in a plane."""

STRAYS: Final = float(np.cos(np.radians(20.0)))
"""Cosine of the angle in space beyond which a line does not run along the axis that it shows."""

SIZE: Final = 0.05
"""Step, as share of the size of the body, with which directions are projected."""

ROUNDS: Final = 3
"""Rounds of directions and depths: in perspective, each depends on the other."""


@dataclass(frozen=True, eq=False)
class PlacedLines:
    """Lines in space between points that lie on a body or off it.

    Parameters
    ----------
    points : (k, 3) float64
        mm.
    cases : tuple of {"corner", "edge", "face", "free"}
        How each was found.
    on : (k,) intp
        Number of the vertex, of the edge in `face_rings.edges_of`, or of the face; −1 if free.
    lines : (m, 2) intp
        Points at the ends of each stroke, in the order of the strokes.
    """

    points: Array
    cases: tuple[Case, ...]
    on: Index
    lines: Index


def placed_lines(
    body: PlanarBody,
    strokes: Sequence[ArrayLike],
    camera: Camera,
    reach: float,
    known: ArrayLike = (),
    *,
    off_rings: bool = False,
) -> PlacedLines:
    """Find where straight strokes lie in space.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    strokes : sequence of (n, 2) array_like
        Canvas px; only the ends count.
    camera : Camera
        Through which they were drawn.
    reach : float
        Distance within which ends meet corners, edges and one another, px.
    known : (k, 3) array_like
        Corners of lines that were drawn before and are no part of the body, mm; their numbers
        follow those of its vertices.
    off_rings : bool
        Whether all ends are free that hang on the first ring over a face.

    Raises
    ------
    UserError
        If a stroke is a dot, or there is none.
    """
    ends = _ends(strokes, reach)
    group = _met(ends, reach)
    count = int(group.max()) + 1
    places = np.array([ends[group == k].mean(axis=0) for k in range(count)])
    lines = group.reshape(-1, 2)
    pieces = visible_pieces(body, camera)
    corners = np.concatenate((body.vertices, np.asarray(known, float).reshape(-1, 3)))
    found = [hit_by(body, corners, camera, pieces, place, reach) for place in places]
    points = np.array([point for point, _, _ in found])
    cases = tuple(case for _, case, _ in found)
    on = np.array([on for _, _, on in found], np.intp)
    points, cases, on = _back_on_faces(body, camera, places, points, cases, on, lines)
    cases, on = _risen(body, camera, places, points, cases, on, lines)
    if off_rings:
        points, cases, on = off_first_ring(body, camera, places, points, cases, on, lines)
    free = np.array([case == "free" for case in cases])
    if free.any():
        runs = _directions_at(body, cases, on, points, lines)
        points = _with_free_ends(body, runs, camera, places, points, free, lines)
    return PlacedLines(points, cases, on, lines)


def _risen(
    body: PlanarBody,
    camera: Camera,
    places: Array,
    points: Array,
    cases: tuple[Case, ...],
    on: Index,
    lines: Index,
) -> tuple[tuple[Case, ...], Index]:
    """Set ends free that only look as if they were on a face or an edge: their lines rise from it.

    That is a line from what is on the body, drawn before, that shows an axis but would not run
    along it.
    """
    axes = _axes_at(body, cases, on)
    made, made_on = list(cases), on.copy()
    for line in lines:
        first, last = sorted(int(end) for end in line)
        if made[last] not in ("face", "edge") or made[first] == "free":
            continue
        face = next((int(made_on[k]) for k in (first, last) if made[k] == "face"), None)
        rising, level = axes, axes[:0]
        if face is not None:
            rising = axes[np.abs(axes @ body.normals[face]) > RISES]
            level = _in_face(body, face)
        ends = [first, last]
        run = _direction_of(body, camera, places[ends], points[ends], rising, level)
        if run is None or (face is not None and abs(run @ body.normals[face]) < RISES):
            continue
        along = points[last] - points[first]
        if abs(run @ along) < STRAYS * float(np.linalg.norm(along)):
            made[last], made_on[last] = "free", -1
    return tuple(made), made_on


def _back_on_faces(
    body: PlanarBody,
    camera: Camera,
    places: Array,
    points: Array,
    cases: tuple[Case, ...],
    on: Index,
    lines: Index,
) -> tuple[Array, tuple[Case, ...], Index]:
    """Set ends back on a face that only look as if they were on an edge before or behind it.

    That is a line from within the face, that shows a direction of it and stays over it.
    """
    points, made, made_on = points.copy(), list(cases), on.copy()
    for one, two in (pair for line in lines for pair in (line, line[::-1])):
        if made[one] != "face" or made[two] != "edge":
            continue
        face = int(made_on[one])
        normal, offset = body.normals[face], float(body.offsets[face])
        along = points[two] - points[one]
        if abs(float(normal @ along)) < LEVEL * float(np.linalg.norm(along)):
            continue
        ends = [int(one), int(two)]
        run = _direction_of(
            body, camera, places[ends], points[[one, one]], _in_face(body, face), normal[None]
        )
        place = camera.on_plane(places[two][None], offset * normal, normal)
        if run is None or abs(float(run @ normal)) > RISES or not np.isfinite(place).all():
            continue
        if within_face(body, face, place)[0]:
            points[two], made[two], made_on[two] = place[0], "face", face
    return points, tuple(made), made_on


def _in_face(body: PlanarBody, face: int) -> Array:
    """Return the directions of the edges of a face, and those across them in its plane, (n, 3)."""
    pairs = np.array([side for ring in body.faces[face] for side in sides_of(ring)])
    along = body.vertices[pairs[:, 1]] - body.vertices[pairs[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return _each_once((*along, *np.cross(body.normals[face], along)))


def direction_on_sheet(
    body: PlanarBody, camera: Camera, places: Array, start: Array
) -> Array | None:
    """Return the axis of a body that a line on the sheet runs along, outward; None if none.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    camera : Camera
        Through which it is seen.
    places : (2, 2) float
        Ends of the line, px.
    start : (3,) float
        Where it begins in space, mm.
    """
    axes, _ = _directions(body)
    run = _direction_of(body, camera, places, np.stack((start, start)), axes, axes[:0])
    if run is None:
        return None
    seen, _ = camera.project(np.stack((start, start + run)))
    return run if (seen[1] - seen[0]) @ (places[1] - places[0]) > 0 else -run


def _ends(strokes: Sequence[ArrayLike], reach: float) -> Array:
    """Return both ends of each stroke one after another, (2 m, 2), px."""
    if not len(strokes):
        raise UserError("There is no stroke to add. Draw a line.")
    ends = []
    for stroke in strokes:
        points = np.asarray(stroke, float).reshape(-1, 2)
        if len(points) < 2 or not np.isfinite(points).all():
            raise UserError("A line needs two ends. Draw it again.")
        if np.linalg.norm(points[-1] - points[0]) <= reach:
            raise UserError("This line is too short. Draw it longer, or come closer.")
        ends += [points[0], points[-1]]
    return np.array(ends)


def _met(ends: Array, reach: float) -> Index:
    """Return a number for each end, the same for ends that meet; never for both of a stroke."""
    group = np.arange(len(ends))
    apart = np.linalg.norm(ends[:, None] - ends[None], axis=-1)
    pairs = [(apart[a, b], a, b) for a in range(len(ends)) for b in range(a) if apart[a, b] < reach]
    for _, one, two in sorted(pairs):
        members = np.flatnonzero((group == group[one]) | (group == group[two]))
        strokes = members // 2
        if len(set(strokes.tolist())) == len(strokes) and (
            apart[np.ix_(members, members)].max() < 2 * reach
        ):
            group[members] = min(group[one], group[two])
    return np.unique(group, return_inverse=True)[1].astype(np.intp)


def _axes_at(body: PlanarBody, cases: tuple[Case, ...], on: Index) -> Array:
    """Return the axes of the frame, and the normals of faces that lines end in, unit vectors."""
    normals = [body.normals[k] for case, k in zip(cases, on, strict=True) if case == "face"]
    return _each_once((*normals, *_directions(body)[0]))


def _directions_at(
    body: PlanarBody, cases: tuple[Case, ...], on: Index, points: Array, lines: Index
) -> tuple[Array, Array]:
    """Return the directions that are near at hand, and all others of the body.

    Near are those of lines of which both ends are known, and the normals of faces that lines end
    in; where there are none, the axes of the frame.
    """
    free = np.array([case == "free" for case in cases])
    known = lines[~free[lines].any(axis=1)]
    along = points[known[:, 1]] - points[known[:, 0]]
    lengths = np.linalg.norm(along, axis=1)
    along = along[lengths > 0.0] / lengths[lengths > 0.0, None]
    normals = [body.normals[k] for case, k in zip(cases, on, strict=True) if case == "face"]
    axes, edges = _directions(body)
    near = _each_once((*normals, *along)) if normals else axes
    every = _each_once((*near, *axes, *along, *edges))
    return near, every[len(near) :]


def _each_once(directions: Sequence[Array]) -> Array:
    """Return directions without those that run along an earlier one, (n, 3)."""
    found: list[Array] = []
    for run in directions:
        if all(abs(run @ known) < PARALLEL for known in found):
            found.append(run)
    return np.array(found).reshape(-1, 3)


def _with_free_ends(
    body: PlanarBody,
    directions: tuple[Array, Array],
    camera: Camera,
    places: Array,
    points: Array,
    free: Flags,
    lines: Index,
) -> Array:
    """Find free ends along their rays by the directions of their lines, all at once.

    Linear least squares: each line that runs along a direction u of the body asks that
    ``u × (P − Q) = 0``; unknown are the distances along the rays.
    """
    rays = camera.rays(places)
    origin, sight = rays.origins, rays.directions
    guess = _guessed_distances(body, camera, origin, sight, points, free, lines)
    axes, others = directions
    points = points.copy()
    points[free] = origin[free] + guess[free, None] * sight[free]
    column = np.cumsum(free) - 1
    for _ in range(ROUNDS):
        rows, values = [], []
        for one, two in lines:
            if not (free[one] or free[two]):
                continue
            run = _direction_of(body, camera, places[[one, two]], points[[one, two]], axes, others)
            if run is None:
                continue
            row, value = np.zeros((2, int(free.sum()))), np.zeros(2)
            for end, side in ((one, 1.0), (two, -1.0)):
                across = tangents(run)
                if free[end]:
                    row[:, column[end]] += side * (across @ sight[end])
                    value -= side * (across @ origin[end])
                else:
                    value -= side * (across @ points[end])
            rows.append(row)
            values.append(value)
        rows.append(WEAK * np.eye(int(free.sum())))
        values.append(WEAK * guess[free])
        along = np.linalg.lstsq(np.concatenate(rows), np.concatenate(values), rcond=None)[0]
        points[free] = origin[free] + along[:, None] * sight[free]
    return points


def _guessed_distances(
    body: PlanarBody, camera: Camera, origin: Array, sight: Array, points: Array, free: Flags,
    lines: Index,
) -> Array:  # fmt: skip
    """Return distances along rays at which free ends are as deep as what they hang on."""
    depth = np.full(len(points), float(camera.view_space(body.vertices)[:, 2].mean()))
    known = ~free
    if known.any():
        depth[known] = camera.view_space(points[known])[:, 2]
    settled = known.copy()
    for _ in range(len(lines)):
        for one, two in lines:
            for here, there in ((one, two), (two, one)):
                if settled[here] and not settled[there]:
                    depth[there], settled[there] = depth[here], True
    start = camera.view_space(origin)[:, 2]
    return np.asarray((depth - start) / (sight @ camera.axes[2]))


def _directions(body: PlanarBody) -> tuple[Array, Array]:
    """Return the axes of the frame and the other directions of edges, unit vectors."""
    edges = edges_of(body.faces)
    along = body.vertices[edges[:, 1]] - body.vertices[edges[:, 0]]
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    axes = body.frame if body.frame is not None else np.zeros((0, 3))
    kept: list[Array] = []
    for run in along:
        if all(abs(run @ known) < 1 - 1e-9 for known in (*axes, *kept)):
            kept.append(run)
    return axes, np.array(kept).reshape(-1, 3)


def _direction_of(
    body: PlanarBody, camera: Camera, places: Array, points: Array, axes: Array, others: Array
) -> Array | None:
    """Return the direction that a line on the sheet runs along, None where none fits."""
    middle = points.mean(axis=0)
    step = SIZE * float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    every = np.concatenate((axes, others))
    if not len(every):
        return None
    pixels, _ = camera.project(np.vstack((middle[None], middle + step * every)))
    if not np.isfinite(pixels).all():
        return None
    runs = pixels[1:] - pixels[0]
    lengths = np.linalg.norm(runs, axis=1)
    drawn = places[1] - places[0]
    drawn = drawn / np.linalg.norm(drawn)
    across, _ = camera.project(np.vstack((middle[None], middle + step * camera.axes[0])))
    full = float(np.linalg.norm(across[1] - across[0]))
    sine = np.abs(runs @ np.array((-drawn[1], drawn[0]))) / np.maximum(lengths, 1e-300)
    angle = np.arcsin(np.clip(sine, 0.0, 1.0))
    angle[: len(axes)] *= AXIS_FIRST
    angle[lengths < FORESHORTENED * full] = np.inf
    best = int(angle.argmin()) if len(angle) else -1
    return np.asarray(every[best]) if best >= 0 and angle[best] < DIRECTION else None
