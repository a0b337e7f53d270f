"""Shapes and drawings to files."""

from __future__ import annotations

import os
from typing import Final

from bozzetto.errors import UserError
from bozzetto.exchange.formats import Format, Kind, find, function, writers
from bozzetto.exchange.solid_check import check_solid
from bozzetto.exchange.surface_pieces import with_meshes
from bozzetto.geometry.shapes import Shapes
from bozzetto.ink.drawing import Drawing
from bozzetto.storage import write_bytes
from bozzetto.view.camera import Camera

__all__ = ["encoded", "export", "has_room", "write_drawing"]

WORDS: Final[dict[Kind, str]] = {"mesh": "surfaces", "surfaces": "exact surfaces"}
"""What people call a kind of content, where it is not the kind's own name."""


def export(shapes: Shapes, path: str | os.PathLike[str], *, camera: Camera | None = None) -> None:
    """Write shapes to a file, in the format that its ending names.

    Parameters
    ----------
    shapes : Shapes
        Parts that the format has no place for (curves in STL, say) are left out, as long
        as something remains. Formats that hold meshes get triangles of exact surfaces.
    path : path
        Replaced only once the new file is complete.
    camera : Camera, optional
        The view for flat formats; by default the front view of all there is.

    Raises
    ------
    UserError
        If the ending is unknown, there is nothing that the format holds, a solid is not
        closed (`check_solid`), or the file cannot be written.
    """
    write_bytes(path, encoded(shapes, path, camera=camera))


def encoded(shapes: Shapes, path: str | os.PathLike[str], *, camera: Camera | None = None) -> bytes:
    """What `export` would write, without touching the disk.

    Raises
    ------
    UserError
        As `export`.
    """
    chosen = find(path, writers("mesh", "surfaces", "curves"))
    _check(shapes, chosen)
    if chosen.flat:
        view: bytes = function(chosen, "write_view")(shapes, camera)
        return view
    if "mesh" in chosen.holds:
        shapes = with_meshes(shapes)
    data: bytes = function(chosen, "write_shapes")(shapes)
    return data


def has_room(path: str | os.PathLike[str], shapes: Shapes) -> bool:
    """Whether the format of a file has a place for some of the shapes.

    Raises
    ------
    UserError
        If the ending is unknown.
    """
    chosen = find(path, writers("mesh", "surfaces", "curves"))
    return not _kinds_in(shapes).isdisjoint(chosen.holds)


def _kinds_in(shapes: Shapes) -> set[Kind]:
    """What shapes can be handed over as."""
    has: dict[Kind, bool] = {
        "mesh": bool(shapes.patchworks) or any(len(part.mesh.faces) for part in shapes.meshes()),
        "surfaces": bool(shapes.patchworks),
        "curves": bool(shapes.curves),
    }
    return {kind for kind, there in has.items() if there}


def _check(shapes: Shapes, chosen: Format) -> None:
    if not shapes:
        raise UserError("There is nothing to export yet. Draw something first.")
    kinds = _kinds_in(shapes)
    if kinds.isdisjoint(chosen.holds):
        wanted = " or ".join(WORDS.get(kind, kind) for kind in chosen.holds)
        useful = [f.endings[0] for f in writers(*kinds)] if kinds else []
        advice = f" Use one of {', '.join(useful)}." if useful else " Draw some first."
        raise UserError(f"{chosen.title} holds {wanted}, and there are none.{advice}")
    if "mesh" in chosen.holds:
        for solid in shapes.solids:
            check_solid(solid)


def write_drawing(drawing: Drawing, path: str | os.PathLike[str]) -> None:
    """Write a drawing as ink JSON, InkML or SVG, by the ending of the file.

    Ink JSON and InkML keep every sample, column and camera exactly; SVG keeps the lines.

    Raises
    ------
    UserError
        If the ending is unknown, the drawing is empty, or the file cannot be written.
    """
    chosen = find(path, writers("ink"))
    if not len(drawing.strokes):
        raise UserError("The drawing is empty. Draw something first.")
    write_bytes(path, function(chosen, "write_drawing")(drawing))
