"""Faces and affine depths of one connected part of a drawing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from bozzetto_polyhedron.graph.planar_embedding import (
    Neighbors,
    Ring,
    embedded_faces,
    flipped,
    shared_pairs,
)
from bozzetto_polyhedron.reconstruction.affine_depth import AffineDepth, affine_depth
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.parallel_classes import ParallelClasses
from bozzetto_polyhedron.reconstruction.planar_faces import planar_faces

MOST_FLIPS: Final = 4
"""Pieces between two corners that are turned over in every combination."""

MOST_TURNED: Final = 3
"""Ways to turn such pieces over that are read: faces of the wrong one may fit as well."""

DETERMINED: Final = 1e-6
"""Second singular value above which the lines alone determine the depths."""


@dataclass(frozen=True, eq=False)
class Lifting:
    """One connected part of a drawing, with faces and affine depths.

    Parameters
    ----------
    corners : tuple of int
    faces : tuple of Rings
    depth : AffineDepth
    unique : bool
        Whether the faces follow from the lines alone.
    """

    corners: tuple[int, ...]
    faces: tuple[Rings, ...]
    depth: AffineDepth
    unique: bool


def liftings(
    drawing: Drawing, classes: ParallelClasses, neighbors: Neighbors, corners: tuple[int, ...]
) -> list[Lifting]:
    """Return what one connected part may be, the likeliest first.

    Where the part is 3-connected and planar, its faces are those of its only planar embedding.
    Otherwise pieces that hang between two corners are turned over as planarity asks, and faces are
    sought in space, with depths that parallel lines alone determine. Corners of two lines are those
    of a sheet's border, which is no face.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    classes : ParallelClasses
        Of all its lines.
    neighbors : Neighbors
        Of each corner.
    corners : tuple of int
        Of the part.
    """
    part = {corner: neighbors[corner] for corner in corners}
    rings = embedded_faces(part) if len(corners) > 3 else None
    if rings is not None and not shared_pairs(rings):
        return [_of_rings(drawing, classes, corners, rings, unique=True)]
    found: list[Lifting] = []
    if rings is not None:
        free = {corner for corner, around in part.items() if len(around) == 2}
        turned = [
            _of_rings(drawing, classes, corners, _without_border(each, free), unique=False)
            for each in embeddings(rings)
        ]
        found = _distinct(sorted(turned, key=lambda each: each.depth.residual))[:MOST_TURNED]
    return _distinct(found + _from_space(drawing, classes, corners))


def _distinct(found: list[Lifting]) -> list[Lifting]:
    """Return liftings without those whose faces are the ones of an earlier lifting."""
    kept: dict[frozenset[frozenset[frozenset[int]]], Lifting] = {}
    for each in found:
        key = frozenset(frozenset(frozenset(ring) for ring in face) for face in each.faces)
        kept.setdefault(key, each)
    return list(kept.values())


def embeddings(rings: tuple[Ring, ...]) -> list[tuple[Ring, ...]]:
    """Return the embedding, and those with pieces turned over."""
    pairs = shared_pairs(rings)[:MOST_FLIPS]
    found = []
    for turns in product((False, True), repeat=len(pairs)):
        faces = rings
        for turn, pair in zip(turns, pairs, strict=True):
            if turn and {pair[2], pair[3]} <= set(faces[pair[0]]) & set(faces[pair[1]]):
                faces = flipped(faces, pair)
        if all(len(set(face)) == len(face) > 2 for face in faces):
            found.append(faces)
    return found


def _without_border(rings: tuple[Ring, ...], free: set[int]) -> tuple[Ring, ...]:
    """Return the faces of a sheet: all rings but its border, on which all corners of two lines are.

    A solid has no such corners, and a ring that is one of two faces alone is no border.
    """
    borders = [ring for ring in rings if free <= set(ring)] if free else []
    border = max(borders, key=len, default=())
    inner = tuple(ring for ring in rings if ring != border)
    return inner if all(len(ring) < len(border) for ring in inner) else rings


def _of_rings(
    drawing: Drawing,
    classes: ParallelClasses,
    corners: tuple[int, ...],
    rings: Sequence[Ring],
    *,
    unique: bool,
) -> Lifting:
    """Return the lifting with faces without holes."""
    faces = tuple((ring,) for ring in rings)
    return Lifting(corners, faces, affine_depth(drawing, classes, corners, faces), unique)


def _from_space(
    drawing: Drawing, classes: ParallelClasses, corners: tuple[int, ...]
) -> list[Lifting]:
    """Return liftings with faces that are planar in the depths that the lines determine."""
    if len(corners) < 4:
        return []
    rough = affine_depth(drawing, classes, corners, ())
    if rough.gap < DETERMINED:
        return []
    members = list(corners)
    flat = drawing.points[members]
    depths = (
        rough.depths[members] * flat.std(0).mean() / max(1e-9, float(rough.depths[members].std()))
    )
    number = np.full(len(drawing.points), -1)
    number[members] = np.arange(len(members))
    lines = number[drawing.lines[number[drawing.lines[:, 0]] >= 0]]
    found: list[Lifting] = []
    for tolerance in (0.015 + 1.5 * drawing.noise, 0.03 + 3.0 * drawing.noise):
        local = planar_faces(np.column_stack((flat, depths)), lines, tolerance)
        faces = tuple(
            tuple(tuple(members[corner] for corner in ring) for ring in face) for face in local
        )
        if all(faces != other.faces for other in found):
            depth = affine_depth(drawing, classes, corners, faces) if faces else rough
            found.append(Lifting(corners, faces, depth, unique=False))
    return found
