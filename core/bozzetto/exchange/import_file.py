"""Import of shapes, drawings and pictures from files.

A file is read in a process of its own (`read_process`), with a `Budget`, unless whoever
asks trusts it. The formats' readers refuse what they can see to be too much; the budget ends
what they cannot see.
"""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Faces, Index
from bozzetto.damaged_files import as_format_errors
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.formats import Format, Kind, find, function, readers
from bozzetto.exchange.frame_guess import guessed_frame
from bozzetto.exchange.handover import frame_said
from bozzetto.exchange.limits import MAX_INK_BYTES, MAX_MESH_BYTES, budget_for, unlimited
from bozzetto.exchange.linked_pictures import drawings_named_in, pictures_named_in
from bozzetto.exchange.mesh.manifold_check import bounds_volume
from bozzetto.exchange.mesh.polygons import is_degenerate, weld, weld_rounded
from bozzetto.exchange.mesh.touching_edges import apart_at_touching_edges
from bozzetto.exchange.read_files import file_size, read_bytes, read_start
from bozzetto.exchange.read_process.parent import Checkpoint, read_in_child
from bozzetto.exchange.reading import MeshFile, Reading
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.rig import Skin
from bozzetto.geometry.shapes import Shapes, Solid, Surface
from bozzetto.images.stored_picture import Picture
from bozzetto.ink.drawing import Drawing

FEWEST_FACES: Final = 4
"""Faces of the smallest body, a tetrahedron."""


def is_picture(path: str | os.PathLike[str]) -> bool:
    """Whether a file's ending is that of a picture; the file is not looked into."""
    ending = PurePath(path).suffix.lower()
    return any(ending in one.endings for one in readers("image"))


def is_mesh(path: str | os.PathLike[str]) -> bool:
    """Whether a file is read as shapes, and not as ink or a picture; raises as `read_mesh`.

    Its ending says so; a DXF, which may hold shapes or lines, is looked into, of a very large
    one at its beginning.
    """
    find(path, readers())
    ending = PurePath(path).suffix.lower()
    kinds = {kind for one in readers() if ending in one.endings for kind in one.holds}
    if not {"mesh", "ink"} <= kinds:
        return "mesh" in kinds
    from bozzetto.exchange.cad.dxf_document import mostly_faces

    return mostly_faces(read_start(path, MAX_INK_BYTES))


def read_mesh(
    path: str | os.PathLike[str],
    *,
    trusted: bool = False,
    checkpoint: Checkpoint | None = None,
) -> Shapes:
    """Read a mesh file: OBJ, STL, PLY, OFF, GLB, glTF, 3MF, STEP, IGES, or DXF with faces.

    Parameters
    ----------
    path : path
        The file; its ending names the format.
    trusted : bool
        Read it in this process and without a `Budget`.
    checkpoint : callable, optional
        Called now and then while reading; what it raises ends the reading and passes.

    Returns
    -------
    Shapes
        A `Solid` for every part that is closed and looks outwards, a `Surface` for every
        other. Corners that a file keeps apart only because their normals differ are one
        vertex in a solid. Curves of STEP and IGES files are there, exact.

    Raises
    ------
    UserError
        If the ending is unknown, or the file is missing or may not be read.
    FormatError
        If the file is damaged, too large, takes more than its budget to be read, or uses
        something we do not read.
    """
    return read_mesh_file(path, trusted=trusted, checkpoint=checkpoint).shapes


def read_mesh_file(
    path: str | os.PathLike[str],
    *,
    trusted: bool = False,
    checkpoint: Checkpoint | None = None,
) -> MeshFile:
    """Read a mesh file, with what is told of it.

    Parameters
    ----------
    path, trusted, checkpoint
        As in `read_mesh`.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`, and if a file that it needs is not beside it.
    """
    read: MeshFile = _read("mesh", path, trusted, checkpoint)
    return read


def read_drawing(
    path: str | os.PathLike[str],
    *,
    trusted: bool = False,
    checkpoint: Checkpoint | None = None,
) -> Drawing:
    """Read ink JSON, InkML, SVG or DXF, with the pictures and drawings that the file names.

    Parameters
    ----------
    path, trusted, checkpoint
        As in `read_mesh`.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`, and if a picture or drawing is missing.
    """
    drawing: Drawing = _read("drawing", path, trusted, checkpoint)

    def picture(place: Path) -> Picture:
        return read_picture(place, trusted=trusted, checkpoint=checkpoint)

    def other(place: Path) -> Drawing:
        found: Drawing = _read("drawing", place, trusted, checkpoint)
        return found

    folder = Path(path).parent
    try:
        pictures = pictures_named_in(drawing.facts, folder, picture)
        drawings = drawings_named_in(drawing, folder, other)
    except UserError as error:
        raise FormatError(f"{PurePath(path).name}: {error.message}") from error
    return replace(drawing, pictures=pictures, drawings=drawings)


def read_image(
    path: str | os.PathLike[str],
    *,
    trusted: bool = False,
    checkpoint: Checkpoint | None = None,
) -> NDArray[np.uint8]:
    """Read a picture, turned the way it was taken.

    Parameters
    ----------
    path, trusted, checkpoint
        As in `read_mesh`.

    Returns
    -------
    (h, w, 4) uint8
        RGBA, sRGB, straight alpha; first row on top.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`.
    """
    pixels: NDArray[np.uint8] = _read("image", path, trusted, checkpoint)
    return pixels


def read_picture(
    path: str | os.PathLike[str],
    *,
    trusted: bool = False,
    checkpoint: Checkpoint | None = None,
) -> Picture:
    """Read a picture as modelers keep it: packed, called like the file without its ending.

    Parameters
    ----------
    path, trusted, checkpoint
        As in `read_mesh`.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`.
    """
    picture: Picture = _read("picture", path, trusted, checkpoint)
    return picture


def _read(
    kind: str, path: str | os.PathLike[str], trusted: bool, checkpoint: Checkpoint | None
) -> Any:
    size = file_size(path, _chosen(kind, path)[1])
    if trusted:
        with unlimited():
            return read_here(kind, path)
    try:
        return read_in_child(kind, path, budget_for(size), checkpoint)
    except FormatError as error:
        if error.message.startswith(PurePath(path).name):
            raise
        raise FormatError(f"{PurePath(path).name}: {error.message}") from error


# -- in this process -------------------------------------------------------------------------------


def read_here(kind: str, path: str | os.PathLike[str]) -> Any:
    """Read a file in this process, without a budget.

    Parameters
    ----------
    kind : {"mesh", "drawing", "image", "picture"}
        A drawing is read without the pictures that it names.
    path : path
        The file; its ending names the format.

    Raises
    ------
    UserError, FormatError
        As in `read_mesh`.
    """
    chosen, limit = _chosen(kind, path)
    data = read_bytes(path, limit)
    stem = PurePath(path).stem
    try:
        with as_format_errors():
            match kind:
                case "mesh":
                    return _mesh_file(chosen, data, Path(path))
                case "drawing":
                    return function(chosen, "read_drawing")(data, stem)
                case "image":
                    return function(chosen, "read_pixels")(data)
                case _:
                    pixels = function(chosen, "read_pixels")(data)
                    return Picture.of_file(data, pixels, stem)
    except UserError as error:
        raise FormatError(f"{PurePath(path).name}: {error.message}") from error


def _mesh_file(chosen: Format, data: bytes, path: Path) -> MeshFile:
    """Read a mesh file whose bytes are known, in our frame where it says its own."""
    reading = Reading(path.parent)
    read = function(chosen, "read_shapes")
    shapes: Shapes = read(data, reading) if chosen.links else read(data)
    frame = frame_said(data)
    shapes = replace(shapes, surfaces=tuple(map(_without_strays, shapes.surfaces)))
    guess = None
    if frame is not None:
        shapes = shapes.placed(frame.placement.inverse())
    elif chosen.choices:
        guess = guessed_frame(data, chosen.id, shapes)
    return MeshFile(_with_solids(shapes, path.stem), guess, reading.left_out)


def _with_solids(shapes: Shapes, stem: str) -> Shapes:
    """Turn closed surfaces into solids; parts without a name are called like the file."""
    solids, surfaces = list(shapes.solids), []
    for part in shapes.surfaces:
        closed = _as_closed(part)
        name = part.name or stem
        if closed is None:
            surfaces.append(replace(part, name=name))
        else:
            solids.append(
                Solid(
                    closed.mesh,
                    name,
                    part.color,
                    part.texture,
                    closed.skin,
                    part.groups,
                    path=part.path,
                )
            )
    return replace(shapes, solids=tuple(solids), surfaces=tuple(surfaces))


def _without_strays(part: Surface) -> Surface:
    """Return a part without the vertices that no face uses: they would count for its size."""
    used, faces = np.unique(part.mesh.faces, return_inverse=True)
    if len(used) == len(part.mesh.vertices):
        return part
    return _rearranged(part, used.astype(np.intp), faces.reshape(-1, 3))


def _as_closed(part: Surface) -> Surface | None:
    """Return a surface that bounds a volume, its doubled vertices one where it takes that."""
    count = len(part.mesh.faces)
    if count < FEWEST_FACES or count % 2:  # three edges a face, each edge of two faces
        return None
    if bounds_volume(part.mesh):
        return part
    skin = part.skin
    rest = part.mesh if skin is None or skin.rest is None else skin.rest
    kept, faces = weld(rest.vertices, rest.faces)
    closed = _joined(part, kept, faces)
    if closed is not None:
        return closed
    fewer, faces = weld_rounded(rest.vertices, kept, faces)
    return _joined(part, fewer, faces) if len(fewer) < len(kept) else None


def _joined(part: Surface, kept: Index, faces: Faces) -> Surface | None:
    """Return a surface with some of its vertices, if it bounds a volume then.

    Where it touches itself along edges, it is taken apart there.
    """
    if is_degenerate(faces).any():
        return None
    mesh, skin = part.mesh, part.skin
    if skin is not None:
        here, there = mesh.faces, kept[faces]
        if not all((each[there] == each[here]).all() for each in (skin.joints, skin.weights)):
            return None  # what lies at one place goes its own ways
    joined = _rearranged(part, kept, faces)
    if bounds_volume(joined.mesh):
        return joined
    apart = apart_at_touching_edges(joined.mesh.vertices, joined.mesh.faces)
    joined = joined if apart is None else _rearranged(joined, *apart)
    return joined if bounds_volume(joined.mesh) else None


def _rearranged(part: Surface, kept: Index, faces: ArrayLike) -> Surface:
    """Return a surface of the same triangles over vertices that are taken from its own.

    Parameters
    ----------
    part : Surface
        Its texture lies by corners of triangles, and stays.
    kept : (k,) int
        The vertex that each of the new ones is a copy of.
    faces : (m, 3) array_like of int
        The triangles, in their order, over these.
    """
    corners = np.asarray(faces, np.int32)
    skin = part.skin
    if skin is not None:
        rest = None if skin.rest is None else _over(skin.rest, kept, corners)
        skin = Skin(skin.rig, skin.joints[kept], skin.weights[kept], rest, skin.clips)
    return replace(part, mesh=_over(part.mesh, kept, corners), skin=skin)


def _over(mesh: Mesh, kept: Index, faces: Faces) -> Mesh:
    """Return a mesh over some of its vertices; normals only where those at one place are one."""
    normals = mesh.normals
    if normals is not None and (normals[kept][faces] != normals[mesh.faces]).any():
        normals = None
    colors = None if mesh.colors is None else mesh.colors[kept]
    return Mesh(mesh.vertices[kept], faces, None if normals is None else normals[kept], colors)


def _chosen(kind: str, path: str | os.PathLike[str]) -> tuple[Format, int]:
    """Return the format of a file to be read, and how large it may be; refuse a folder."""
    if os.path.isdir(path):
        raise UserError(f"“{os.fspath(path)}” is a folder. Choose a file inside it.")
    held: Kind = {"mesh": "mesh", "drawing": "ink"}.get(kind, "image")  # type: ignore[assignment]
    return find(path, readers(held)), MAX_INK_BYTES if held == "ink" else MAX_MESH_BYTES
