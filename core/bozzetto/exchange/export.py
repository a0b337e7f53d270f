"""Export of shapes and drawings to files."""

from __future__ import annotations

import contextlib
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.atomic_files import write_bytes
from bozzetto.cached_properties import cached_property
from bozzetto.errors import UserError
from bozzetto.exchange.cad.cad_curves import points_on, readable
from bozzetto.exchange.formats import Format, Kind, find, function, writers
from bozzetto.exchange.handover import (
    AS_USUAL,
    LEVELS,
    MILLIMETRES,
    UNIT_NAMES,
    FileFrame,
    Handover,
)
from bozzetto.exchange.left_out import LeftOut, parts_left_out, pictures_left_out, with_place
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.exchange.mesh.one_picture import MOST, in_one_picture
from bozzetto.exchange.mesh.picture_places import Checkpoint, no_checkpoint
from bozzetto.exchange.mesh.polygons import without_degenerate
from bozzetto.exchange.separate_parts import separate_parts
from bozzetto.exchange.triangle_budget import triangle_count, within_budget
from bozzetto.geometry.meshed_shapes import meshed
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.resting_place import lying_flat
from bozzetto.geometry.shapes import Shapes
from bozzetto.ink.drawing import Drawing
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.exchange.line_drawing.page import Page
    from bozzetto.exchange.quad_budget import Quadrangulated

WRITERS: Final = writers("mesh", "surfaces", "curves")
"""Formats of shapes."""

FAR: Final = 0.01
"""Distance of quads from the shape that is told, as a share of its diagonal."""

MISSED: Final = 0.1
"""Share by which the number of quads may miss before it is told."""

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


@dataclass(frozen=True, eq=False)
class Recording:
    """How parts moved before they were where they are now.

    Parameters
    ----------
    motions : sequence of sequence of Placement
        For each mesh of the shapes as triangles (`meshed`) where it was at each time, as seen from
        where it is now.
    seconds : sequence of float
        These times, growing.
    """

    motions: Sequence[Sequence[Placement]]
    seconds: Sequence[float]


@dataclass(frozen=True, eq=False)
class Ready:
    """Shapes as a person wants to hand them over, for files of any format.

    What all files have in common is made once: the same triangles are in each.

    Parameters
    ----------
    shapes : Shapes
        As they are in the world, mm.
    handover : Handover
        What the person wants.
    checkpoint : callable
        Called with the fraction done (0 … 1) and the step's name where a file takes long; may raise
        to stop it.
    recording : Recording, optional
        How the shapes moved, for formats that hold motions.
    """

    shapes: Shapes
    handover: Handover = AS_USUAL
    checkpoint: Checkpoint = no_checkpoint
    recording: Recording | None = None

    @cached_property
    def _placed(self) -> tuple[Shapes, Placement]:
        """The shapes in the size that is wanted, lying flat if they should, and what did that."""
        shapes, wanted, change = self.shapes, self.handover, Placement()
        if wanted.scale != 1.0:
            change = Placement(scale=wanted.scale)
            shapes = shapes.placed(change)
        if wanted.lay_flat:
            lying = lying_flat(_points(shapes))
            shapes, change = shapes.placed(lying), lying.after(change)
        return shapes, change

    @property
    def placed(self) -> Shapes:
        """The shapes in the size that is wanted, lying flat if they should."""
        return self._placed[0]

    def motions_of(self, written: Shapes) -> dict[str, Any]:
        """Return where the drawn meshes of a file were at each time; nothing if not recorded.

        With coarser levels of detail there are none: these are parts of their own in a file.
        """
        if self.recording is None or self.handover.levels:
            return {}
        if len(list(written.meshes())) != len(self.recording.motions):
            return {}  # parts that were taken apart for the file
        change = self._placed[1]
        back = change.inverse()
        rows = zip(written.meshes(), self.recording.motions, strict=True)
        motions = [
            [change.after(pose).after(back) for pose in motion]
            for part, motion in rows
            if len(without_degenerate(part.mesh.faces))
        ]
        return {"motions": motions, "seconds": self.recording.seconds}

    @cached_property
    def points(self) -> Array:
        """Points that tell how far it reaches, (n, 3), mm."""
        return _points(self.placed)

    @property
    def size(self) -> tuple[float, float, float]:
        """Width, depth and height of the box around it, mm; zeros if there is nothing."""
        points = self.points
        x, y, z = np.ptp(points, axis=0).tolist() if len(points) else (0.0, 0.0, 0.0)
        return x, y, z

    @cached_property
    def triangles(self) -> Shapes:
        """Shapes of triangles, no more than are wanted; two for each quad that is wanted."""
        if self.quads is not None:
            return self.quads.shapes
        shapes = meshed(self.placed)
        most = self.handover.triangles
        return shapes if most is None else within_budget(shapes, most)

    @cached_property
    def quads(self) -> Quadrangulated | None:
        """Shapes of quads, about as many as are wanted; None where none are."""
        count = self.handover.quads
        if count is None:
            return None
        from bozzetto.exchange.quad_budget import within_quads

        return within_quads(meshed(self.placed), count, self.checkpoint)

    @cached_property
    def coarser(self) -> tuple[Shapes, ...]:
        """Shapes with fewer and fewer triangles, as many levels as are wanted besides."""
        if not self.handover.levels:
            return ()
        count = triangle_count(self.triangles)
        return tuple(within_budget(self.triangles, count // fewer) for fewer in LEVELS)


def prepare_file(ready: Ready, path: str | os.PathLike[str], camera: Camera | None) -> Exported:
    """Return the file of shapes that are ready.

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
    if chosen.flat:
        data: bytes = function(chosen, "write_view")(parts, camera)
        return Exported(chosen, data, parts, left_out, notes=_notes(chosen, ready, camera))
    written = parts
    if "mesh" in chosen.holds:
        written = _readably_named(with_place(ready.triangles, chosen))
        for solid in written.solids:
            check_solid(solid)
        left_out += pictures_left_out(tuple(parts.meshes()), tuple(written.meshes()))
    given: dict[str, Any] = {}
    coarser: list[Shapes] = []
    notes = _notes(chosen, ready, camera)
    if "levels" in chosen.keeps:
        coarser = [_readably_named(with_place(one, chosen)) for one in ready.coarser]
    if wanted.separate_parts and "parts" in chosen.keeps:
        written, *coarser = separate_parts([written, *coarser])
    if "uvs" in chosen.keeps:
        given |= {"uvs": wanted.uvs, "checkpoint": ready.checkpoint}
        if wanted.uvs:
            written, *coarser = in_one_picture([written, *coarser])
            notes += _pictures_apart(written)
    if "levels" in chosen.keeps:
        given["coarser"] = coarser
    if "motions" in chosen.keeps:
        moved = ready.motions_of(written)
        given |= moved
        if ready.recording is not None and not moved and not wanted.levels:
            notes += ("What was recorded is not in files whose parts are separate objects.",)
    if chosen.choices:
        given["frame"] = frame_of(chosen, wanted)
        written = written.placed(given["frame"].placement)
    beside: tuple[tuple[str, bytes], ...] = ()
    if chosen.beside:
        given["beside"] = Path(path).stem
        beside = function(chosen, "files_beside")(written, Path(path).stem)
    data = function(chosen, "write_shapes")(written, **given)
    return Exported(chosen, data, parts, left_out, beside, notes)


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
    unit = frame_of(chosen, wanted).unit if wanted.lines == "outlines" else MILLIMETRES.unit
    data = page_svg(page) if chosen.id == "svg" else page_dxf(page, unit)
    notes = _notes(chosen, ready, camera)
    return Exported(chosen, data, _readably_named(ready.placed), (), notes=notes, page=page)


def frame_of(chosen: Format, wanted: Handover) -> FileFrame:
    """Return the frame of a file: as wanted, as far as its format leaves the choice."""
    unit = wanted.unit if "unit" in chosen.choices else None
    up = wanted.up if "up" in chosen.choices else None
    return FileFrame(unit or chosen.frame.unit, up or chosen.frame.up)


def _points(shapes: Shapes) -> Array:
    """Return points that tell how far shapes reach, (n, 3), mm."""
    found = [part.mesh.vertices.astype(np.float64) for part in meshed(shapes).meshes()]
    found += [points_on(curve) for curve in shapes.curves]
    return np.concatenate(found) if found else np.zeros((0, 3))


def _frame_notes(chosen: Format, wanted: Handover, camera: Camera | None) -> tuple[str, ...]:
    """Return a sentence about a unit and about an axis that a file has not got as they are wanted.

    Blueprints are on paper of a size in millimetres; their dimensions are in the unit.
    """
    frame, found = frame_of(chosen, wanted), []
    lines = wanted.lines if chosen.draws else None
    flat = chosen.flat or lines is not None
    pixels = flat and camera is not None and camera.kind == "perspective"
    if wanted.unit is not None and lines != "blueprint":
        if pixels:
            found.append(
                "A view in perspective is in pixels. For sizes in a unit turn perspective off."
            )
        elif wanted.unit != frame.unit:
            found.append(
                f"{chosen.short} files are always in {UNIT_NAMES[frame.unit]}; every program that "
                "reads them knows that, and the size is right."
            )
    if flat and wanted.up is not None:
        found.append(f"A drawing in {chosen.short} is flat: up is where the view has it.")
    elif wanted.up not in (None, frame.up):
        found.append(f"{chosen.short} files always have {frame.up.upper()} up.")
    return tuple(found)


def _notes(chosen: Format, ready: Ready, camera: Camera | None) -> tuple[str, ...]:
    """Return a sentence about each wish that a format does not fulfil."""
    wanted = ready.handover
    found = list(_frame_notes(chosen, wanted, camera))
    drawn = wanted.lines is not None and chosen.draws
    if wanted.levels and "levels" not in chosen.heeds:
        found.append(f"{chosen.short} files hold one level of detail: the finest. GLB holds all.")
    if wanted.levels and ready.recording is not None and "motions" in chosen.keeps:
        found.append("What was recorded is not in files with several levels of detail.")
    if wanted.lines is not None and "lines" not in chosen.heeds:
        kind = "a blueprint" if wanted.lines == "blueprint" else "outlines"
        found.append(f"{chosen.short} files hold the shapes themselves. SVG and DXF hold {kind}.")
    if wanted.hidden and wanted.lines is None:
        found.append("Hidden lines are dashed in outlines and blueprints only.")
    if wanted.triangles is not None and "triangles" not in chosen.heeds and not drawn:
        found.append(f"{chosen.short} files hold no triangles, so that none were taken away.")
    if wanted.quads is not None and "quads" not in chosen.heeds and not drawn:
        found.append(f"{chosen.short} files hold no quads. OBJ, PLY and USD do.")
    if wanted.uvs and "uvs" not in chosen.heeds:
        found.append(f"{chosen.short} files get no places for a picture (UVs). GLB, USD, OBJ do.")
    if wanted.separate_parts and "separate_parts" not in chosen.heeds:
        found.append(f"{chosen.short} files hold objects whole. GLB, USD, OBJ and 3MF part them.")
    if wanted.curves_alone and "curves" not in chosen.holds:
        found.append(f"{chosen.short} files hold no curves, so that the surfaces are in it.")
    if "bones" in chosen.keeps and "motions" not in chosen.keeps:
        skins = [part.skin for part in ready.placed.meshes() if part.skin is not None]
        if any(len(skin.clips) > 1 for skin in skins):
            found.append(
                f"{chosen.short} files play one motion: the first. The others lie beside it."
            )
    if "mesh" in chosen.holds and ready.quads is not None:
        found += _quad_notes(chosen, ready.quads, wanted.quads or 0, math.hypot(*ready.size))
    if "mesh" in chosen.holds and wanted.triangles is not None:
        count = triangle_count(ready.triangles)
        if count > wanted.triangles:
            found.append(
                f"It has {count:,} triangles, not {wanted.triangles:,}: with fewer its parts would "
                "not hold together."
            )
    return tuple(found)


def _quad_notes(chosen: Format, made: Quadrangulated, wanted: int, size: float) -> list[str]:
    """Return sentences about quads that are not as they are wanted, on shapes of a size, mm."""
    found = []
    if "quads" not in chosen.keeps:
        found.append(
            f"{chosen.short} files hold triangles: each quad is two of them. OBJ, PLY and USD hold "
            "quads."
        )
    count = made.quads + made.triangles
    if not 1.0 - MISSED <= count / wanted <= 1.0 + MISSED:
        found.append(
            f"It has {count:,} faces, not {wanted:,}: its edges and holes leave no other number. "
            "Ask for more, or for fewer parts."
        )
    if made.deviation > FAR * size:
        found.append(
            f"Its quads lie up to {made.deviation:.3g} mm from the shape, at its thinnest places. "
            "Ask for more quads."
        )
    if made.joined:
        names = ", ".join(f"“{name}”" for name in made.joined[:3])
        more = " and others" if len(made.joined) > 3 else ""
        found.append(
            f"The quads of {names}{more} are pairs of triangles, which do not follow the shape: "
            "it has details finer than such quads. Ask for more quads."
        )
    return found


def _pictures_apart(shapes: Shapes) -> tuple[str, ...]:
    """Return a sentence about pictures that could not be put into one."""
    if len({id(part.texture.pixels) for part in shapes.meshes() if part.texture is not None}) < 2:
        return ()
    return (
        "Its pictures stay apart: some repeat, or together they are longer than "
        f"{MOST:,} pixels. Use smaller ones.",
    )


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
