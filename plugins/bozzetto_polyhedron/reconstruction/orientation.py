"""Faces that run round in one sense, seen from outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.regularity import area_vector


def lines_of(rings: Rings) -> list[tuple[int, int]]:
    """Return the directed lines round a face."""
    return [pair for ring in rings for pair in zip(ring, ring[1:] + ring[:1], strict=True)]


def lines_left_open(faces: Sequence[Rings], lines: Index) -> Flags:
    """Return which lines do not lie between exactly two faces, (m,) of bool."""
    between: dict[tuple[int, int], int] = {}
    for face in faces:
        for first, second in lines_of(face):
            key = min(first, second), max(first, second)
            between[key] = between.get(key, 0) + 1
    return np.array([between.get((int(a), int(b)), 0) != 2 for a, b in lines], bool)


def open_lines(faces: Sequence[Rings], lines: Index) -> int:
    """Count the lines that do not lie between exactly two faces."""
    return int(lines_left_open(faces, lines).sum())


def oriented(vertices: Array, faces: Sequence[Rings]) -> tuple[Rings, ...]:
    """Return faces whose outer rings run counter-clockwise seen from outside.

    Neighbours run through a shared line in opposite directions; what hangs together is turned so
    that its volume is positive. Holes run the other way round than their outer ring.

    Parameters
    ----------
    vertices : (n, 3) array
        mm.
    faces : sequence of Rings
        Rings of corners, in any sense.
    """
    found = [_with_holes(vertices, face) for face in faces]
    owners: dict[tuple[int, int], list[tuple[int, bool]]] = {}
    for number, face in enumerate(found):
        for first, second in lines_of(face):
            key = min(first, second), max(first, second)
            owners.setdefault(key, []).append((number, first < second))
    turned: dict[int, bool] = {}
    for start in range(len(found)):
        if start not in turned:
            part = _spread(found, owners, turned, start)
            if _volume(vertices, [_turned(found[k], turned[k]) for k in part]) < 0.0:
                turned.update({k: not turned[k] for k in part})
    return tuple(_turned(face, turned[number]) for number, face in enumerate(found))


def _with_holes(vertices: Array, face: Rings) -> Rings:
    """Return a face whose holes run against its outer ring."""
    outward = area_vector(vertices[list(face[0])])
    return (
        face[0],
        *(
            ring[::-1] if area_vector(vertices[list(ring)]) @ outward > 0.0 else ring
            for ring in face[1:]
        ),
    )


def _spread(
    faces: Sequence[Rings],
    owners: dict[tuple[int, int], list[tuple[int, bool]]],
    turned: dict[int, bool],
    start: int,
) -> list[int]:
    """Faces that hang together with one, after deciding which of them have to be turned."""
    turned[start] = False
    part = [start]
    for number in part:
        for first, second in lines_of(faces[number]):
            for other, forward in owners[min(first, second), max(first, second)]:
                if other not in turned:
                    turned[other] = turned[number] ^ (forward == (first < second))
                    part.append(other)
    return part


def _turned(face: Rings, turn: bool) -> Rings:
    return tuple(_reversed(ring) for ring in face) if turn else face


def _reversed(ring: Ring) -> Ring:
    """Return a ring the other way round, from the same corner."""
    return ring[:1] + ring[:0:-1]


def _volume(vertices: Array, faces: Sequence[Rings]) -> float:
    """Three times the volume inside faces, about the middle of the vertices."""
    middle = vertices.mean(0)
    return float(
        np.sum(
            [
                (vertices[list(ring)].mean(0) - middle) @ area_vector(vertices[list(ring)])
                for face in faces
                for ring in face
            ]
        )
    )
