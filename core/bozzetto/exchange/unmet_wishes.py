"""Sentences about what a person wished of a file and its format does not fulfil."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from bozzetto.exchange.formats import Format
from bozzetto.exchange.handover import UNIT_NAMES, Handover
from bozzetto.exchange.mesh.one_picture import MOST
from bozzetto.exchange.ready_shapes import Ready
from bozzetto.exchange.triangle_budget import triangle_count
from bozzetto.geometry.shapes import Shapes
from bozzetto.view.camera import Camera

if TYPE_CHECKING:
    from bozzetto.exchange.quad_budget import Quadrangulated

FAR: Final = 0.01
"""Distance of quads from the shape that is told, as a share of its diagonal."""

MISSED: Final = 0.1
"""Share by which the number of quads may miss before it is told."""


def _frame_notes(chosen: Format, wanted: Handover, camera: Camera | None) -> tuple[str, ...]:
    """Return a sentence about a unit and about an axis that a file has not got as they are wanted.

    Blueprints are on paper of a size in millimetres; their dimensions are in the unit.
    """
    frame, found = chosen.frame_for(wanted), []
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


def unmet_wishes(
    chosen: Format, ready: Ready, camera: Camera | None, others: Sequence[Format] = ()
) -> tuple[str, ...]:
    """Return a sentence about each wish that a format does not fulfil.

    Parameters
    ----------
    chosen : Format
        Of the file.
    ready : Ready
        The shapes and the wishes.
    camera : Camera, optional
        The view, for flat formats.
    others : sequence of Format
        Those of the other files: who chose one that holds a drawing knows that this one does not.
    """
    wanted = ready.handover
    found = list(_frame_notes(chosen, wanted, camera))
    drawn = wanted.lines is not None and chosen.draws
    if wanted.levels and "levels" not in chosen.heeds:
        found.append(f"{chosen.short} files hold one level of detail: the finest. GLB holds all.")
    if wanted.levels and ready.recording is not None and "motions" in chosen.keeps:
        found.append("What was recorded is not in files with several levels of detail.")
    is_drawn = any("lines" in one.heeds for one in (chosen, *others))
    if wanted.lines is not None and not is_drawn:
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


def pictures_apart(shapes: Shapes) -> tuple[str, ...]:
    """Return a sentence about pictures that could not be put into one."""
    if len({id(part.texture.pixels) for part in shapes.meshes() if part.texture is not None}) < 2:
        return ()
    return (
        "Its pictures stay apart: some repeat, or together they are longer than "
        f"{MOST:,} pixels. Use smaller ones.",
    )
