"""Export of shapes and drawings to files."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import Any, Final

from bozzetto.atomic_files import write_bytes
from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import readable
from bozzetto.exchange.formats import Format, Kind, find, function, writers
from bozzetto.exchange.left_out import LeftOut, parts_left_out, with_place
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry.meshed_shapes import meshed
from bozzetto.geometry.shapes import Shapes
from bozzetto.ink.drawing import Drawing
from bozzetto.view.camera import Camera

WORDS: Final[dict[Kind, str]] = {"mesh": "surfaces", "surfaces": "exact surfaces"}
"""Words for a kind of content, where it is not the kind's own name."""


@dataclass(frozen=True)
class Exported:
    """A file of another program's format, and what became of the shapes.

    Attributes
    ----------
    format : Format
    data : bytes
        The whole file.
    parts : Shapes
        What is in it; exact surfaces may have become triangles there.
    left_out : tuple of LeftOut
    """

    format: Format
    data: bytes
    parts: Shapes
    left_out: tuple[LeftOut, ...]

    def warnings(self) -> tuple[str, ...]:
        """Warnings for the person, a sentence each."""
        file = f"{self.format.short} file"
        return tuple(part.sentence(file) for part in self.left_out if part.is_content)

    def as_values(self) -> dict[str, Any]:
        """Return plain JSON values for a report."""
        named: dict[str, tuple[Any, ...]] = {
            "solids": self.parts.solids,
            "surfaces": self.parts.surfaces,
            "exact_surfaces": (*self.parts.patchworks, *self.parts.breps),
            "curves": self.parts.curves,
        }
        return {
            "format": self.format.id,
            "bytes": len(self.data),
            **{kind: [part.name for part in parts] for kind, parts in named.items()},
            "left_out": [part.as_values() for part in self.left_out],
        }


def export(
    shapes: Shapes, path: str | os.PathLike[str], *, camera: Camera | None = None
) -> Exported:
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

    Returns
    -------
    Exported
        Names all that was left out.

    Raises
    ------
    UserError
        If the ending is unknown, there is nothing that the format holds, a solid is not
        closed (`check_solid`), or the file cannot be written.
    """
    made = prepare_export(shapes, path, camera=camera)
    write_bytes(path, made.data)
    return made


def encode_shapes(
    shapes: Shapes, path: str | os.PathLike[str], *, camera: Camera | None = None
) -> bytes:
    """Return the bytes that `export` would write.

    Raises
    ------
    UserError
        As `export`.
    """
    return prepare_export(shapes, path, camera=camera).data


def prepare_export(
    shapes: Shapes, path: str | os.PathLike[str], *, camera: Camera | None = None
) -> Exported:
    """Return what `export` would write, without touching the disk.

    Raises
    ------
    UserError
        As `export`.
    """
    chosen = find(path, writers("mesh", "surfaces", "curves"))
    _check(shapes, chosen)
    parts, left_out = _readably_named(with_place(shapes, chosen)), parts_left_out(shapes, chosen)
    if chosen.flat:
        data: bytes = function(chosen, "write_view")(parts, camera)
    else:
        written = meshed(parts) if "mesh" in chosen.holds else parts
        for solid in written.solids:
            check_solid(solid)
        data = function(chosen, "write_shapes")(written)
    return Exported(chosen, data, parts, left_out)


def _readably_named(shapes: Shapes) -> Shapes:
    """Return shapes with names that every reader accepts, whatever the format."""
    return replace(
        shapes,
        solids=tuple(replace(part, name=readable(part.name)) for part in shapes.solids),
        surfaces=tuple(replace(part, name=readable(part.name)) for part in shapes.surfaces),
        breps=tuple(replace(part, name=readable(part.name)) for part in shapes.breps),
    )


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
    """Return the kinds of content that shapes hold."""
    exact = bool(shapes.patchworks or shapes.breps)
    exact = exact or any(part.exact is not None for part in shapes.meshes())
    has: dict[Kind, bool] = {
        "mesh": exact or any(len(part.mesh.faces) for part in shapes.meshes()),
        "surfaces": exact,
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
