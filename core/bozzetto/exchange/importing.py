"""Files to shapes, drawings and pictures."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.files import read_bytes
from bozzetto.exchange.formats import Format, Kind, find, function, readers
from bozzetto.exchange.limits import MAX_INK_BYTES, MAX_MESH_BYTES
from bozzetto.exchange.named_pictures import pictures_named_in
from bozzetto.exchange.polygons import welded
from bozzetto.exchange.solid_check import bounds_volume
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.shapes import Shapes, Solid
from bozzetto.ink.drawing import Drawing
from bozzetto.scene.stored_picture import Picture

__all__ = ["is_picture", "read_drawing", "read_image", "read_mesh", "read_picture"]


def is_picture(path: str | os.PathLike[str]) -> bool:
    """Whether a file's ending is that of a picture; the file is not looked into."""
    ending = PurePath(path).suffix.lower()
    return any(ending in one.endings for one in readers("image"))


def read_mesh(path: str | os.PathLike[str]) -> Shapes:
    """Read a mesh file: OBJ, STL, PLY or GLB.

    Parameters
    ----------
    path : path

    Returns
    -------
    Shapes
        A `Solid` for every part that is closed and looks outwards, a `Surface` for every
        other. Corners that a file keeps apart only because their normals differ are one
        vertex in a solid.

    Raises
    ------
    UserError
        If the ending is unknown, or the file is missing or may not be read.
    FormatError
        If the file is damaged, too large, or uses something we do not read.
    """
    chosen = _format_of(path, "mesh")
    data = read_bytes(path, MAX_MESH_BYTES)
    shapes: Shapes = _parsed(path, chosen, "read_shapes", data)
    solids, surfaces = list(shapes.solids), []
    for part in shapes.surfaces:
        closed = _as_closed(part.mesh)
        name = part.name or PurePath(path).stem
        if closed is None:
            surfaces.append(replace(part, name=name))
        else:
            solids.append(Solid(closed, name, part.color))
    return Shapes(tuple(solids), tuple(surfaces))


def _as_closed(mesh: Mesh) -> Mesh | None:
    if bounds_volume(mesh):
        return mesh
    kept, faces = welded(mesh.vertices, mesh.faces)
    if len(kept) == len(mesh.vertices):
        return None
    colors = None if mesh.colors is None else mesh.colors[kept]
    joined = Mesh(mesh.vertices[kept], faces, colors=colors)
    return joined if bounds_volume(joined) else None


def read_drawing(path: str | os.PathLike[str]) -> Drawing:
    """Read ink JSON, InkML or SVG, with the pictures that the file names.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`, and if a picture is missing.
    """
    chosen = _format_of(path, "ink")
    drawing: Drawing = _parsed(
        path, chosen, "read_drawing", read_bytes(path, MAX_INK_BYTES), PurePath(path).stem
    )
    try:
        pictures = pictures_named_in(drawing.extra, Path(path).parent)
    except UserError as error:
        raise FormatError(f"{PurePath(path).name}: {error.message}") from error
    return replace(drawing, pictures=pictures) if pictures else drawing


def read_image(path: str | os.PathLike[str]) -> NDArray[np.uint8]:
    """Read a picture, turned the way it was taken.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, sRGB, straight alpha; first row on top.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`.
    """
    return _content_and_pixels(path)[1]


def read_picture(path: str | os.PathLike[str]) -> Picture:
    """Read a picture as modelers keep it: packed, called like the file without its ending.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`.
    """
    content, pixels = _content_and_pixels(path)
    return Picture.of_file(content, pixels, PurePath(path).stem)


def _content_and_pixels(path: str | os.PathLike[str]) -> tuple[bytes, NDArray[np.uint8]]:
    chosen = _format_of(path, "image")
    content = read_bytes(path, MAX_MESH_BYTES)
    return content, _parsed(path, chosen, "read_pixels", content)


def _format_of(path: str | os.PathLike[str], kind: Kind) -> Format:
    """The format of a file to be read; a folder has none."""
    if os.path.isdir(path):
        raise UserError(f"“{os.fspath(path)}” is a folder. Choose a file inside it.")
    return find(path, readers(kind))


def _parsed(path: str | os.PathLike[str], chosen: Format, name: str, *given: Any) -> Any:
    """Read, and say which file it was if that fails."""
    try:
        return function(chosen, name)(*given)
    except UserError as error:
        raise FormatError(f"{PurePath(path).name}: {error.message}") from error
