"""Export of shapes and drawings to files."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from bozzetto.atomic_files import write_bytes
from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import readable
from bozzetto.exchange.formats import Format, Kind, find, function, writers
from bozzetto.exchange.handover import AS_USUAL, MILLIMETRES, Handover
from bozzetto.exchange.left_out import LeftOut, parts_left_out, pictures_left_out, with_place
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.exchange.mesh.one_picture import in_one_picture
from bozzetto.exchange.ready_shapes import Ready
from bozzetto.exchange.separate_parts import separate_parts
from bozzetto.exchange.unmet_wishes import pictures_apart, unmet_wishes
from bozzetto.geometry.shapes import Shapes
from bozzetto.ink.drawing import Drawing
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.exchange.line_drawing.page import Page

WRITERS: Final = writers("mesh", "surfaces", "curves")
"""Formats of shapes."""

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
    beside : tuple of (str, bytes)
        Files that it names, in the same folder, each with its name.
    notes : tuple of str
        Wishes that could not be fulfilled, a sentence each.
    page : Page, optional
        The drawing, where the file is one of edges and outlines, or a blueprint.
    """

    format: Format
    data: bytes
    parts: Shapes
    left_out: tuple[LeftOut, ...]
    beside: tuple[tuple[str, bytes], ...] = ()
    notes: tuple[str, ...] = ()
    page: Page | None = None

    def warnings(self) -> tuple[str, ...]:
        """Warnings for the person, a sentence each."""
        file = f"{self.format.short} file"
        lost = tuple(part.sentence(file) for part in self.left_out if part.is_content)
        return (*lost, *self.notes)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the file, and those that it names into its folder.

        Those replace others with the file itself only: nobody was asked about a file beside. Where
        the file cannot be written, none is left of those that are new.

        Raises
        ------
        UserError
            If one cannot be written, or would replace another file than that of the path.
        """
        self._check_beside(Path(path))
        begun: list[Path] = []
        try:
            for name, data in self.beside:
                there = Path(path).with_name(name)
                begun += [] if os.path.lexists(there) else [there]
                write_bytes(there, data)
            write_bytes(path, self.data)
        except UserError:
            for there in begun:
                with contextlib.suppress(OSError):
                    there.unlink(missing_ok=True)
            raise

    def _check_beside(self, path: Path) -> None:
        if os.path.lexists(path):
            return
        for name, data in self.beside:
            there = path.with_name(name)
            if os.path.lexists(there) and not _holds(there, data):
                raise UserError(
                    f"There is a file “{name}” already, which is not that of a “{path.name}”. "
                    "Move it away, or export under another name."
                )

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
            "beside": [name for name, _ in self.beside],
            "notes": list(self.notes),
        }


def _holds(path: Path, data: bytes) -> bool:
    """Whether a file holds these bytes."""
    try:
        return path.stat().st_size == len(data) and path.read_bytes() == data
    except OSError:
        return False


def export(
    shapes: Shapes,
    path: str | os.PathLike[str],
    *,
    camera: Camera | None = None,
    handover: Handover = AS_USUAL,
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
    handover : Handover
        Unit, axes, size, number of triangles or quads.

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
    made = prepare_export(shapes, path, camera=camera, handover=handover)
    made.write(path)
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
    shapes: Shapes,
    path: str | os.PathLike[str],
    *,
    camera: Camera | None = None,
    handover: Handover = AS_USUAL,
) -> Exported:
    """Return what `export` would write, without touching the disk.

    Raises
    ------
    UserError
        As `export`.
    """
    return prepare_file(Ready(shapes, handover), path, camera)


def prepare_file(
    ready: Ready,
    path: str | os.PathLike[str],
    camera: Camera | None,
    others: Sequence[Format] = (),
) -> Exported:
    """Return the file of shapes that are ready.

    Parameters
    ----------
    ready : Ready
        The shapes and the wishes.
    path : path
        Its ending names the format. Nothing is written there.
    camera : Camera, optional
        The view, for flat formats.
    others : sequence of Format
        Those of files that are written with it.

    Raises
    ------
    UserError
        As `export`.
    """
    chosen, wanted, shapes = find(path, WRITERS), ready.handover, ready.placed
    if wanted.lines is not None and chosen.draws:
        return _drawing(ready, chosen, Path(path).stem, camera)
    if wanted.curves_alone and "curves_alone" in chosen.heeds:
        shapes = Shapes(curves=shapes.curves)
    _check(shapes, chosen)
    parts, left_out = _readably_named(with_place(shapes, chosen)), parts_left_out(shapes, chosen)
    notes = unmet_wishes(chosen, ready, camera, others)
    if chosen.flat:
        data: bytes = function(chosen, "write_view")(parts, camera)
        return Exported(chosen, data, parts, left_out, notes=notes)
    written = parts
    if "mesh" in chosen.holds:
        written = _readably_named(with_place(ready.triangles, chosen))
        for solid in written.solids:
            check_solid(solid)
        left_out += pictures_left_out(tuple(parts.meshes()), tuple(written.meshes()))
    written, given, more = _with_features(written, ready, chosen)
    if chosen.choices:
        given["frame"] = chosen.frame_for(wanted)
        written = written.placed(given["frame"].placement)
    beside: tuple[tuple[str, bytes], ...] = ()
    if chosen.beside:
        given["beside"] = Path(path).stem
        beside = function(chosen, "files_beside")(written, Path(path).stem)
    data = function(chosen, "write_shapes")(written, **given)
    return Exported(chosen, data, parts, left_out, beside, notes + more)


def _with_features(
    written: Shapes, ready: Ready, chosen: Format
) -> tuple[Shapes, dict[str, Any], tuple[str, ...]]:
    """Add what a format keeps of meshes and a person wants: levels, parts, a picture, motions.

    Returns
    -------
    written : Shapes
        In the parts of the file.
    given : dict of str to object
        What the format's writer takes besides them.
    notes : tuple of str
        Sentences about what could not be done with these shapes.
    """
    wanted, keeps = ready.handover, chosen.keeps
    given: dict[str, Any] = {}
    coarser: list[Shapes] = []
    notes: tuple[str, ...] = ()
    if "levels" in keeps:
        coarser = [_readably_named(with_place(one, chosen)) for one in ready.coarser]
    if wanted.separate_parts and "parts" in keeps:
        written, *coarser = separate_parts([written, *coarser])
    if "uvs" in keeps:
        given |= {"uvs": wanted.uvs, "checkpoint": ready.checkpoint}
        if wanted.uvs:
            written, *coarser = in_one_picture([written, *coarser])
            notes += pictures_apart(written)
    if "levels" in keeps:
        given["coarser"] = coarser
    if "motions" in keeps:
        moved = ready.motions_of(written)
        given |= moved
        if ready.recording is not None and not moved and not wanted.levels:
            notes += ("What was recorded is not in files whose parts are separate objects.",)
    return written, given, notes


def _drawing(ready: Ready, chosen: Format, title: str, camera: Camera | None) -> Exported:
    """Return a drawing of shapes: outlines in a view, or a blueprint."""
    from bozzetto.exchange.line_drawing.blueprint import blueprint_page
    from bozzetto.exchange.line_drawing.page import outlines_page
    from bozzetto.exchange.line_drawing.page_files import page_dxf, page_svg

    wanted = ready.handover
    shapes = ready.triangles
    if wanted.lines == "blueprint":
        page = blueprint_page(shapes, title, wanted.unit or "mm", hidden=wanted.hidden)
    else:
        page = outlines_page(shapes, camera, hidden=wanted.hidden)
    unit = chosen.frame_for(wanted).unit if wanted.lines == "outlines" else MILLIMETRES.unit
    data = page_svg(page) if chosen.id == "svg" else page_dxf(page, unit)
    notes = unmet_wishes(chosen, ready, camera)
    return Exported(chosen, data, _readably_named(ready.placed), (), notes=notes, page=page)


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
    chosen = find(path, WRITERS)
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
        wanted = " or ".join(WORDS.get(kind, kind) for kind in chosen.holds if kind != "ink")
        useful = [f.endings[0] for f in writers(*kinds)] if kinds else []
        advice = f" Use one of {', '.join(useful)}." if useful else " Draw some first."
        if chosen.draws and useful:
            advice += " Or write a drawing of its outlines, as the view shows them."
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
