"""Which loose parts of a drawing can lie in faces of which others, by what surrounds what."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.lifting import Lifting
from bozzetto_polyhedron.reconstruction.planar_faces import inside


def hanging_order(drawing: Drawing, parts: Sequence[Lifting]) -> list[Lifting]:
    """Return parts so that each one can lie in faces of those before it.

    The long shaft of a bolt lies in a face of its short head. So the body is the largest part of
    those at which all others hang, directly or by others. Where there is none, some are held by
    what lies in their own faces, as both plates of a spool are by its core; then, or where that
    holds not all of them, the body is the largest part.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    parts : sequence of Lifting
        The largest first.
    """
    inside_of = holds(drawing, [part.faces for part in parts], {})
    both = [
        held | {k for k, each in enumerate(inside_of) if n in each}
        for n, held in enumerate(inside_of)
    ]
    orders = [reached(start, way) for way in (inside_of, both) for start in range(len(parts))]
    if not orders:
        return []
    whole = next((each for each in orders if len(each) == len(parts)), orders[0])
    return [parts[k] for k in (*whole, *(k for k in range(len(parts)) if k not in whole))]


def holds(
    drawing: Drawing, parts: Sequence[Sequence[Rings]], around: dict[tuple[Ring, Ring], bool]
) -> list[set[int]]:
    """Return for each part, given by its faces, which others may lie in a face of it.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    parts : sequence of sequence of Rings
        Faces of each.
    around : dict
        Whether a ring appears around another one, as far as it was asked: added to.
    """
    return [
        {
            k
            for k, inner in enumerate(parts)
            if k != number and _may_hold(drawing, outer, inner, around)
        }
        for number, outer in enumerate(parts)
    ]


def reached(start: int, holds: Sequence[set[int]]) -> list[int]:
    """Return what hangs at a part, directly or by others; each after what holds it."""
    order = [start]
    while left := set().union(*(holds[k] for k in order)) - set(order):
        order.append(min(left))
    return order


def _may_hold(
    drawing: Drawing,
    part: Sequence[Rings],
    other: Sequence[Rings],
    around: dict[tuple[Ring, Ring], bool],
) -> bool:
    """Whether a face of a part appears around one of another part."""
    return any(surrounds(drawing, outer[0], inner[0], around) for outer in part for inner in other)


def surrounds(
    drawing: Drawing, outer: Ring, inner: Ring, around: dict[tuple[Ring, Ring], bool]
) -> bool:
    """Whether a ring appears inside another one, up to the noise."""
    if (outer, inner) not in around:
        ring, places = drawing.points[list(outer)], drawing.points[list(inner)]
        near = _distances(places, ring) < 2.0 * drawing.noise
        around[outer, inner] = bool((inside(places, ring) | near).all())
    return around[outer, inner]


def _distances(places: Array, ring: Array) -> Array:
    """Return the distance of places from the sides of a polygon."""
    span = np.roll(ring, -1, axis=0) - ring
    share = ((places[:, None] - ring) * span).sum(2) / np.maximum((span**2).sum(1), 1e-18)
    feet = ring + np.clip(share, 0.0, 1.0)[..., None] * span
    return np.asarray(np.linalg.norm(places[:, None] - feet, axis=2).min(1))
