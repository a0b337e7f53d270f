"""Faces of PLY files, from their columns: polygons or strips, with colours or pictures.

The format names no pictures. MeshLab and scanning programs write them as comments
(``comment TextureFile a.jpg``), with places in them for vertices or for the corners of faces.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Index
from bozzetto.errors import FormatError
from bozzetto.exchange.color import WHITE
from bozzetto.exchange.limits import MAX_FACES, MAX_VERTICES, at_most
from bozzetto.exchange.mesh.colored_faces import colored_part
from bozzetto.exchange.mesh.polygons import (
    check_places,
    checked_mesh,
    is_degenerate,
    triangulate,
)
from bozzetto.exchange.mesh.stacked_pictures import Pictures
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.shapes import Color, Shapes, Surface

CORNERS: Final = ("vertex_indices", "vertex_index")

IN_PICTURES: Final = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))
"""Names of the columns in which vertices have places in pictures."""

STRIP_END: Final = -1

MAX_REPEATS: Final = 1e6
"""How often a picture may be repeated on its way to a triangle."""

Columns = dict[str, NDArray[Any]]


def ply_shapes(
    vertex: Columns, face: Columns, strips: Columns, pictures: Sequence[str], reading: Reading
) -> Shapes:
    """Return what the elements of a PLY file make.

    Parameters
    ----------
    vertex, face, strips : dict of str to (n,) array
        Their columns; a list is its values in a row and a column "... length".
    pictures : sequence of str
        Files beside it that the header names.
    reading : Reading
        Where they lie, and what is told.

    Raises
    ------
    FormatError
        If there are no vertices or faces, or they do not fit each other.
    """
    if not {"x", "y", "z"} <= vertex.keys():
        raise FormatError("The vertices of this file have no x, y and z.")
    with np.errstate(invalid="ignore"):  # signalling NaNs; refused below
        places = np.column_stack([np.asarray(vertex[axis], float) for axis in "xyz"])
    at_most(len(places), MAX_VERTICES, "vertices")
    corners, sizes = _polygons(face)
    if not len(corners):
        face = {}
        corners, sizes = _of_strips(*_polygons(strips))
    if not len(corners):
        if len(places):
            raise FormatError(
                "There are no faces in this file, only points. Make a surface of them first, in "
                "a program for scans such as MeshLab."
            )
        raise FormatError("There are no faces in this file.")
    if corners.min() < 0 or corners.max() >= len(places):
        raise FormatError("A face names a vertex that the file does not hold.")
    check_places(places)
    colors = _colors(vertex)
    shades = _colors(face) if colors is None else None
    of_faces: list[Color | None] = [None] * len(sizes)
    if shades is not None:
        of_faces = [(red, green, blue) for red, green, blue, _ in shades.tolist()]
    shown = _with_pictures(places, corners, sizes, vertex, face, of_faces, pictures, reading)
    part = shown or colored_part(places, corners, sizes, of_faces, colors, "PLY", reading)
    return Shapes(surfaces=(part,))


def _polygons(element: Columns) -> tuple[Index, Index]:
    """Return the corners of all polygons in turn, and how many each has."""
    name = next((n for n in CORNERS if f"{n} length" in element), None)
    if name is None:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    values = np.asarray(element[name])
    with np.errstate(invalid="ignore"):
        whole = np.nan_to_num(np.clip(values, -1.0, float(MAX_VERTICES))).astype(np.int64)
    return whole, np.asarray(element[f"{name} length"]).astype(np.int64)


def _of_strips(corners: Index, sizes: Index) -> tuple[Index, Index]:
    """Return strips as triangles: every second one is turned over, a break begins anew."""
    if not len(corners):
        return corners, sizes
    row = np.insert(corners, np.cumsum(sizes)[:-1], STRIP_END)
    ends = np.concatenate(([-1], np.flatnonzero(row == STRIP_END)))
    at = np.arange(max(len(row) - 2, 0))
    at = at[(row[at] >= 0) & (row[at + 1] >= 0) & (row[at + 2] >= 0)]
    at_most(len(at), MAX_FACES, "triangles")
    turned = (at - ends[np.searchsorted(ends, at) - 1] - 1) % 2
    faces = np.column_stack((row[at + turned], row[at + 1 - turned], row[at + 2]))
    return faces.ravel(), np.full(len(faces), 3)


def _with_pictures(
    places: Array,
    corners: Index,
    sizes: Index,
    vertex: Columns,
    face: Columns,
    of_faces: Sequence[Color | None],
    pictures: Sequence[str],
    reading: Reading,
) -> Surface | None:
    """Return polygons with the pictures around them; None if none can be had."""
    seen = _in_pictures(corners, sizes, vertex, face)
    if seen is not None and not pictures:
        reading.tell_of_unused_places("PLY")
    if seen is None or not pictures:
        return None
    number = np.zeros(len(sizes), np.int64)
    if "texnumber" in face:
        number = np.nan_to_num(face["texnumber"]).astype(np.int64)
    number[(number < 0) | (number >= len(pictures))] = -1
    known = Pictures("PLY", reading)
    for each in np.unique(number[number >= 0]).tolist():
        known.add(pictures[each], partial(reading.beside, pictures[each], "picture"))
    corner = triangulate(places[corners], np.arange(len(corners)), sizes)
    owner = np.repeat(np.arange(len(sizes)), np.maximum(sizes - 2, 0))
    proper = ~is_degenerate(corners[corner])
    corner, owner = corner[proper], owner[proper]
    where = seen[corner]
    number = np.where(np.isfinite(where).all(axis=(1, 2)), number[owner], -1)
    plain = np.array([(*(color or WHITE), 255) for color in of_faces], np.uint8)[owner]
    texture = known.texture(number, list(pictures), np.nan_to_num(where), plain)
    if texture is None or not len(corner):
        return None
    return Surface(checked_mesh(places, corners[corner]), "", texture=texture)


def _in_pictures(corners: Index, sizes: Index, vertex: Columns, face: Columns) -> Array | None:
    """Return the place in a picture of each corner, (c, 2), NaN where there is none."""
    if "texcoord length" in face:
        said = np.asarray(face["texcoord length"]).astype(np.int64)
        fits = said == 2 * sizes
        seen = np.full((len(corners), 2), np.nan)
        seen[np.repeat(fits, sizes)] = face["texcoord"][np.repeat(fits, said)].reshape(-1, 2)
    else:
        names = next((pair for pair in IN_PICTURES if set(pair) <= vertex.keys()), None)
        if names is None:
            return None
        seen = np.column_stack([np.asarray(vertex[name], float) for name in names])[corners]
    with np.errstate(invalid="ignore"):
        seen[~(np.abs(seen) <= MAX_REPEATS)] = np.nan
    return seen


def _colors(element: Columns) -> NDArray[np.uint8] | None:
    """Return RGBA of vertices or faces, from bytes or from numbers 0 … 1 as the types say."""
    if not {"red", "green", "blue"} <= element.keys():
        return None
    share = element["red"].dtype.kind == "f"
    opaque = np.full(len(element["red"]), 1.0 if share else 255.0)
    channels = [*(element[name] for name in ("red", "green", "blue")), element.get("alpha", opaque)]
    with np.errstate(invalid="ignore", over="ignore"):
        rgba = np.column_stack([np.asarray(channel, float) for channel in channels])
        rgba = np.nan_to_num(rgba * (255.0 if share else 1.0))
    return np.asarray(np.rint(np.clip(rgba, 0, 255)), np.uint8)
