"""The first ring that lines draw on a face, and what hangs on it."""

from __future__ import annotations

from collections import Counter
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.view import Camera
from bozzetto_polyhedron.drawing_on.body_hits import Case
from bozzetto_polyhedron.solid.planar_body import PlanarBody
from bozzetto_polyhedron.solid.triangulation import within_face

IN_PLANE: Final = 1e-6
"""Distance from a plane, as share of the size of the body, within which a point lies in it."""


def off_first_ring(
    body: PlanarBody,
    camera: Camera,
    places: Array,
    points: Array,
    cases: tuple[Case, ...],
    on: Index,
    lines: Index,
) -> tuple[Array, tuple[Case, ...], Index]:
    """Put the first ring over a face onto it, and set free all that hangs on the ring.

    The face is the one on which most ends were found; without such a ring nothing changes.

    Parameters
    ----------
    body : PlanarBody
        What is drawn on.
    camera : Camera
        Through which it was drawn.
    places : (k, 2) float
        Of the ends, px.
    points, cases, on, lines
        See `stroke_ends.PlacedLines`.
    """
    met = Counter(int(k) for k, case in zip(on, cases, strict=True) if case == "face")
    if not met:
        return points, cases, on
    ((face, _),) = met.most_common(1)
    normal, offset = body.normals[face], float(body.offsets[face])
    laid = camera.on_plane(places, offset * normal, normal)
    is_finite = np.asarray(np.isfinite(laid).all(axis=1))
    over = is_finite & within_face(body, face, np.where(is_finite[:, None], laid, 0.0))
    size = float(np.linalg.norm(np.ptp(body.vertices, axis=0)))
    there = np.abs(points @ normal - offset) < IN_PLANE * size
    ring = first_ring(np.where(over | there, face, -1), lines)
    points, made, made_on = points.copy(), list(cases), on.copy()
    for corner in ring:
        if not there[corner]:
            points[corner], made[corner], made_on[corner] = laid[corner], "face", face
    for corner in np.flatnonzero(hanging_on(ring, lines, len(points))).tolist():
        made[corner], made_on[corner] = "free", -1
    return points, tuple(made), made_on


def hanging_on(ring: tuple[int, ...], lines: Index, count: int) -> Flags:
    """Return which of some points lines join to a ring, without those in it, (count,)."""
    away = np.zeros(count, bool)
    reached = list(ring)
    while reached:
        here = reached.pop()
        for one, two in lines.tolist():
            other = two if one == here else one if two == here else -1
            if other >= 0 and other not in ring and not away[other]:
                away[other] = True
                reached.append(other)
    return away


def first_ring(faces: Index, lines: Index) -> tuple[int, ...]:
    """Return the points of the first circuit of lines in one face, () where there is none."""
    after: dict[int, list[int]] = {}
    for one, two in lines.tolist():
        if faces[one] < 0 or faces[one] != faces[two]:
            continue
        before: dict[int, int] = {one: one}
        waiting = [one]
        while waiting and two not in before:
            here = waiting.pop(0)
            for there in after.get(here, ()):
                if there not in before:
                    before[there] = here
                    waiting.append(there)
        if two in before:
            ring = [two]
            while ring[-1] != one:
                ring.append(before[ring[-1]])
            return tuple(ring)
        after.setdefault(one, []).append(two)
        after.setdefault(two, []).append(one)
    return ()
