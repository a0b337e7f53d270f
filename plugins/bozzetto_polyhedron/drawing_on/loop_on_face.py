"""A closed loop drawn on a face: its corners in the plane, with the directions that it has there.

Such a loop is the paper's descendant face (Masry et al. 2004, third case): all of its corners lie
in the face nearest to the viewer.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Index
from bozzetto.errors import UserError
from bozzetto.ink import close_stroke, resample
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.body_hits import face_under
from bozzetto_polyhedron.solid.face_rings import are_simple, sides_of, tangents
from bozzetto_polyhedron.solid.planar_body import PlanarBody

SAMPLES: Final = 160
"""Points at even steps round a loop: 40 on each side of a rectangle."""

CORNER: Final = 0.05
"""Distance of a line from the ink, as share of the size of the loop, from which there is a corner
between: a careful hand stays within a third of it."""

DIRECTION: Final = np.radians(12.0)
"""Angle within which a side runs along an edge of the face, or across it."""

TRIMMED: Final = 0.15
"""Share of a side at either end that is rounded by the hand and does not count for its line."""

PARALLEL: Final = np.radians(15.0)
"""Angle between sides below which their corner stays where it was drawn."""

OPEN: Final = 0.25
"""Largest gap between the ends of a loop, as share of its size."""

MOSTLY: Final = 0.6
"""Share of the samples that one face must have."""


@dataclass(frozen=True, eq=False)
class LoopOnFace:
    """A polygon in the plane of a face.

    Parameters
    ----------
    face : int
        Its number.
    corners : (n, 3) float64
        mm, counter-clockwise seen from outside.
    """

    face: int
    corners: Array


def loop_on_face(
    body: PlanarBody, strokes: Sequence[ArrayLike], camera: Camera, reach: float
) -> LoopOnFace:
    """Find the loop that strokes draw on a face.

    Sides that run nearly along an edge of the face, or across it, do so exactly; sides that lie
    on an edge take its line.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    strokes : sequence of (n, 2) array_like
        One closed stroke, or several whose ends meet in any order, canvas px.
    camera : Camera
        Through which they were drawn.
    reach : float
        Distance within which a side snaps to an edge, px.

    Raises
    ------
    UserError
        If they do not close, or do not lie on one face.
    """
    ring = _ring(strokes)
    face = _face_of(body, camera, ring)
    normal, offset = body.normals[face], float(body.offsets[face])
    points = camera.on_plane(ring, offset * normal, normal)
    if not np.isfinite(points).all():
        raise UserError("The loop leaves the plane of its face. Turn the face towards you first.")
    axes = tangents(normal)
    origin = body.vertices[body.faces[face][0][0]]
    flat = (points - origin) @ axes.T
    scale = _length(flat) / max(_length(ring), 1e-300)
    numbers = _corner_numbers(flat)
    edges = _edges_in(body, face, origin, axes)
    corners = _straightened(flat, numbers, edges, reach * scale)
    if not are_simple([corners]):
        corners = flat[numbers]
    if not are_simple([corners]):
        raise UserError("The loop crosses itself. Draw it again.")
    x, y = corners.T
    if float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) < 0:
        corners = corners[::-1]
    space = origin + corners @ axes
    return LoopOnFace(face, space + np.multiply.outer(offset - space @ normal, normal))


def _ring(strokes: Sequence[ArrayLike]) -> Array:
    """Return the strokes one after another as a closed line of even steps, px."""
    todo = [np.asarray(stroke, float).reshape(-1, 2) for stroke in strokes]
    if not todo or any(len(s) < 2 or not np.isfinite(s).all() for s in todo):
        raise UserError("A loop needs lines that close. Draw them.")
    chain = todo.pop(0)
    while todo:
        ends = [
            (float(np.linalg.norm(stroke[k] - chain[-1])), number, k)
            for number, stroke in enumerate(todo)
            for k in (0, -1)
        ]
        _, number, k = min(ends)
        following = todo.pop(number)
        chain = np.vstack((chain, following if k == 0 else following[::-1]))
    size = float(np.linalg.norm(np.ptp(chain, axis=0)))
    ring = close_stroke(chain)
    if len(ring) < 3 or not np.linalg.norm(ring[0] - ring[-1]) < OPEN * size:
        raise UserError("The loop does not close. Draw on until its ends meet.")
    return np.asarray(resample(ring, count=SAMPLES, closed=True))


def _face_of(body: PlanarBody, camera: Camera, ring: Array) -> int:
    """Return the face that most of the loop lies on."""
    found = [face_under(body, camera, place) for place in ring[::4]]
    counts = Counter(hit[1] for hit in found if hit is not None)
    if counts:
        face, count = min(counts.items(), key=lambda item: (-item[1], item[0]))
        if count >= MOSTLY * len(found):
            return face
    raise UserError("The loop does not lie on one face. Draw it within a face.")


def _length(ring: Array) -> float:
    return float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())


def _corner_numbers(flat: Array) -> Index:
    """Return the samples at corners, by the algorithm of Douglas and Peucker on either half."""
    far = int(np.linalg.norm(flat - flat.mean(axis=0), axis=1).argmax())
    turned = np.roll(np.arange(len(flat)), -far)
    half = int(np.linalg.norm(flat[turned] - flat[far], axis=1).argmax())
    limit = CORNER * float(np.linalg.norm(np.ptp(flat, axis=0)))
    kept = {0, half}
    todo = [(0, half), (half, len(flat))]
    while todo:
        low, high = todo.pop()
        between = np.arange(low + 1, high)
        if not len(between):
            continue
        start, end = flat[turned[low]], flat[turned[high % len(flat)]]
        along = (end - start) / max(float(np.linalg.norm(end - start)), 1e-300)
        offset = flat[turned[between]] - start
        apart = np.abs(offset[:, 0] * along[1] - offset[:, 1] * along[0])
        worst = int(apart.argmax())
        if apart[worst] > limit:
            cut = int(between[worst])
            kept.add(cut)
            todo += [(low, cut), (cut, high)]
    return _without_straight(flat, turned[sorted(kept)], limit)


def _without_straight(flat: Array, numbers: Index, limit: float) -> Index:
    """Return corners without those that lie on the line between their neighbours.

    Where the search for corners begins there need be none.
    """
    while len(numbers) > 3:
        here, past = flat[numbers], flat[np.roll(numbers, 1)]
        along = flat[np.roll(numbers, -1)] - past
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
        offset = here - past
        apart = np.abs(offset[:, 0] * along[:, 1] - offset[:, 1] * along[:, 0])
        least = int(apart.argmin())
        if apart[least] > limit:
            break
        numbers = np.delete(numbers, least)
    return numbers


def _edges_in(body: PlanarBody, face: int, origin: Array, axes: Array) -> Array:
    """Return the edges of a face in its plane, (m, 2, 2)."""
    pairs = [side for ring in body.faces[face] for side in sides_of(ring)]
    return np.asarray((body.vertices[np.array(pairs)] - origin) @ axes.T)


def _straightened(flat: Array, numbers: Index, edges: Array, reach: float) -> Array:
    """Return corners between lines through the ink, in directions of the face, (n, 2)."""
    corners = flat[numbers]
    if len(numbers) < 3:
        raise UserError("The loop encloses no area. Draw it wider.")
    lines = []
    for start, end in zip(numbers, np.roll(numbers, -1), strict=True):
        count = int((end - start) % len(flat))
        trim = round(TRIMMED * count)
        samples = flat[(start + np.arange(trim, count - trim + 1)) % len(flat)]
        run = flat[end] - flat[start]
        lines.append(_line(samples, run / np.linalg.norm(run), edges, reach))
    for k, (after, at) in enumerate(zip(lines, [lines[-1], *lines[:-1]], strict=True)):
        (first, one), (second, two) = at, after
        sine = float(first[0] * second[1] - first[1] * second[0])
        if abs(sine) < np.sin(PARALLEL):
            continue
        offset = two - one
        along = float(offset[0] * second[1] - offset[1] * second[0]) / sine
        corners[k] = one + along * first
    return corners


def _line(samples: Array, run: Array, edges: Array, reach: float) -> tuple[Array, Array]:
    """Return direction and a point of the line of one side."""
    middle = samples.mean(axis=0)
    if len(samples) > 2:
        fitted = np.linalg.svd(samples - middle)[2][0]
        run = fitted if fitted @ run > 0 else -fitted
    along = edges[:, 1] - edges[:, 0]
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    across = np.column_stack((-along[:, 1], along[:, 0]))
    candidates = np.concatenate((along, across))
    cosine = candidates @ run
    best = int(np.abs(cosine).argmax())
    if abs(cosine[best]) > np.cos(DIRECTION):
        run = candidates[best] * np.sign(cosine[best])
    for edge, direction in zip(edges, along, strict=True):
        if abs(direction @ run) > 1 - 1e-9:
            apart = abs(float((middle - edge[0]) @ (-run[1], run[0])))
            reached = (middle - edge[0]) @ direction / np.linalg.norm(edge[1] - edge[0])
            if apart < reach and -0.1 < reached < 1.1:
                return run, edge[0]
    return run, middle
