"""The table of formats.

A format's module is imported when its functions are first asked for. What the module
must define follows from what the format holds:

========  ============================================  ====================================
holds     to write                                      to read
========  ============================================  ====================================
mesh      ``write_shapes(shapes) -> bytes``             ``read_shapes(data) -> Shapes``
surfaces  ``write_shapes(shapes) -> bytes``             –
curves    ``write_shapes(shapes) -> bytes``, or         –
          ``write_view(shapes, camera) -> bytes``
          where the format is flat
ink       ``write_drawing(drawing) -> bytes``           ``read_drawing(data, name) -> Drawing``
image     –                                             ``read_pixels(data) -> array``
========  ============================================  ====================================

Where a person may choose the unit or the axis that points up, ``write_shapes`` takes the
``frame`` of the file too, and gets shapes that are in it already. Coarser levels and places for a
picture to come are asked for by ``coarser`` and ``uvs``, where the format keeps them; with ``uvs``
comes a ``checkpoint`` that may stop it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import PurePath
from typing import Any, Final, Literal

from bozzetto.errors import UserError
from bozzetto.exchange.handover import MILLIMETRES, FileFrame, Handover

Kind = Literal["mesh", "surfaces", "curves", "ink", "image"]
Feature = Literal["colors", "bones", "motions", "levels", "uvs", "trims", "parts", "quads"]
Choice = Literal["unit", "up"]


@dataclass(frozen=True)
class Format:
    """One format of files.

    Parameters
    ----------
    id : str
        Short name, for command lines and settings.
    title : str
        For menus.
    endings : tuple of str
        In lower case, with the dot; the first is the usual one.
    holds : tuple of {"mesh", "surfaces", "curves", "ink", "image"}
        What such a file is good for. Surfaces are exact ones: patchworks and breps.
    writes, reads : bool
        Which ways we go.
    module : str
        The module of the functions, in this package.
    keeps : tuple of {"colors", "bones", "motions", "levels", "uvs", "trims", "parts", "quads"}
        What is written of a mesh besides its shape: painted colours, the bones that it follows,
        all motions of these side by side, coarser levels of detail, places for a picture to come,
        faces of four corners; whether faces of exact surfaces may be trimmed, and objects in
        objects.
    flat : bool
        Shapes are written as seen through a camera.
    frame : FileFrame
        The unit and the axis that points up, where nobody chooses others.
    choices : tuple of {"unit", "up"}
        Which of these a person may choose; others are laid down by the format.
    beside : bool
        Whether the file names others beside it, which ``files_beside(shapes, name)`` gives.
    draws : bool
        Whether it may be a drawing of edges and outlines, or a blueprint.
    links : bool
        Whether what is read may name other files, or hold more than is read: ``read_shapes`` takes
        a `Reading` too.
    """

    id: str
    title: str
    endings: tuple[str, ...]
    holds: tuple[Kind, ...]
    writes: bool
    reads: bool
    module: str
    keeps: tuple[Feature, ...] = ()
    flat: bool = False
    frame: FileFrame = MILLIMETRES
    choices: tuple[Choice, ...] = ()
    beside: bool = False
    draws: bool = False
    links: bool = False

    @property
    def heeds(self) -> frozenset[str]:
        """Names of what a `Handover` may wish that changes such a file."""
        of_meshes = ("triangles", "quads") if "mesh" in self.holds else ()
        of_drawings = ("lines", "hidden") if self.draws else ()
        kept = {"levels", "uvs"}.intersection(self.keeps)
        parts = ("separate_parts",) if "parts" in self.keeps else ()
        curves = ("curves_alone",) if {"surfaces", "curves"} <= set(self.holds) else ()
        always = ("scale", "lay_flat", *curves)
        return frozenset((*always, *self.choices, *of_meshes, *of_drawings, *kept, *parts))

    @property
    def short(self) -> str:
        """Short name for people, such as "STEP"."""
        return self.endings[0].removeprefix(".").upper()

    def frame_for(self, wanted: Handover) -> FileFrame:
        """Return the frame of a file: as wanted, as far as the format leaves the choice."""
        unit = wanted.unit if "unit" in self.choices else None
        up = wanted.up if "up" in self.choices else None
        return FileFrame(unit or self.frame.unit, up or self.frame.up)


EXACT: Final[tuple[Kind, ...]] = ("surfaces", "curves")
"""Kinds of content that CAD programs take as they are."""

PAINTED: Final[tuple[Feature, ...]] = ("colors",)

POSABLE: Final[tuple[Feature, ...]] = ("colors", "bones", "uvs", "parts", "quads")

TRIMMED: Final[tuple[Feature, ...]] = ("trims",)

UNIT: Final[tuple[Choice, ...]] = ("unit",)

ANY: Final[tuple[Choice, ...]] = ("unit", "up")

METRES: Final = FileFrame("m", "y")

UPRIGHT: Final = FileFrame("mm", "y")
"""Programs that read OBJ take its second axis for the one that points up."""

PICTURES: Final = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".bmp")

FORMATS: Final = (
    Format("stl", "STL mesh", (".stl",), ("mesh",), True, True, "mesh.stl", choices=ANY),
    Format(
        "3mf",
        "3MF for printing",
        (".3mf",),
        ("mesh",),
        True,
        False,
        "mesh.threemf",
        (*PAINTED, "parts"),
        choices=UNIT,
    ),
    Format(
        "3mf-mesh",
        "3MF mesh",
        (".3mf",),
        ("mesh",),
        False,
        True,
        "mesh.threemf_reader",
        links=True,
    ),
    Format(
        "glb",
        "glTF binary",
        (".glb",),
        ("mesh",),
        True,
        True,
        "mesh.glb",
        ("colors", "bones", "motions", "levels", "uvs", "parts"),
        frame=METRES,
        links=True,
    ),
    Format(
        "gltf",
        "glTF with its buffers beside",
        (".gltf",),
        ("mesh",),
        False,
        True,
        "mesh.gltf_reader",
        frame=METRES,
        links=True,
    ),
    Format(
        "obj",
        "Wavefront OBJ",
        (".obj",),
        ("mesh",),
        True,
        True,
        "mesh.obj",
        ("colors", "uvs", "parts", "quads"),
        frame=UPRIGHT,
        choices=ANY,
        beside=True,
        links=True,
    ),
    Format(
        "usda",
        "USD scene",
        (".usda", ".usd"),
        ("mesh",),
        True,
        False,
        "usd.usda",
        POSABLE,
        frame=METRES,
        choices=ANY,
        beside=True,
    ),
    Format(
        "usdz",
        "USD package for phones",
        (".usdz",),
        ("mesh",),
        True,
        False,
        "usd.usdz",
        POSABLE,
        frame=METRES,
        choices=UNIT,
    ),
    Format(
        "usd-mesh",
        "USD mesh",
        (".usda", ".usdz", ".usd", ".usdc"),
        ("mesh",),
        False,
        True,
        "usd.reader",
        links=True,
    ),
    Format(
        "off", "OFF mesh", (".off",), ("mesh",), False, True, "mesh.off", choices=ANY, links=True
    ),
    Format(
        "ply",
        "PLY mesh",
        (".ply",),
        ("mesh",),
        True,
        True,
        "mesh.ply",
        ("colors", "quads"),
        choices=ANY,
        links=True,
    ),
    Format(
        "svg",
        "SVG drawing",
        (".svg",),
        ("curves", "ink"),
        True,
        True,
        "svg.reader",
        flat=True,
        draws=True,
    ),
    Format("svgz", "SVG drawing, compressed", (".svgz",), ("ink",), False, True, "svg.reader"),
    Format("step", "STEP for CAD", (".step", ".stp"), EXACT, True, False, "cad.step", TRIMMED),
    Format("iges", "IGES for CAD", (".iges", ".igs"), EXACT, True, False, "cad.iges", TRIMMED),
    Format(
        "cad",
        "STEP and IGES bodies and curves",
        (".step", ".stp", ".iges", ".igs"),
        ("mesh",),
        False,
        True,
        "cad.cad_reader",
        links=True,
    ),
    Format(
        "dxf",
        "DXF curves",
        (".dxf",),
        ("curves",),
        True,
        False,
        "cad.dxf",
        choices=UNIT,
        draws=True,
    ),
    Format(
        "dxf-mesh", "DXF mesh", (".dxf",), ("mesh",), False, True, "cad.dxf_mesh_reader", links=True
    ),
    Format("dxf-drawing", "DXF drawing", (".dxf",), ("ink",), False, True, "cad.dxf_reader"),
    Format("rhino", "Rhino", (".3dm",), EXACT, True, False, "cad.rhino", choices=UNIT),
    Format("ink", "Bozzetto ink", (".json",), ("ink",), True, True, "ink.ink_json"),
    Format("inkml", "InkML", (".inkml",), ("ink",), True, True, "ink.inkml"),
    Format("image", "Picture", PICTURES, ("image",), False, True, "image"),
)


def writers(*kinds: Kind) -> tuple[Format, ...]:
    """Return formats that can be written; only those that hold one of the kinds, where given."""
    return tuple(f for f in FORMATS if f.writes and (not kinds or set(kinds) & set(f.holds)))


def readers(*kinds: Kind) -> tuple[Format, ...]:
    """Return formats that can be read; only those that hold one of the kinds, where given."""
    return tuple(f for f in FORMATS if f.reads and (not kinds or set(kinds) & set(f.holds)))


def find(
    path: str | os.PathLike[str], among: Iterable[Format], others: Iterable[str] = ()
) -> Format:
    """Find the format that a file's ending names.

    Parameters
    ----------
    path : path
        Of the file.
    among : iterable of Format
        Those that can be used.
    others : iterable of str
        Further endings that the message lists: whoever asks knows them already.

    Raises
    ------
    UserError
        If the ending is missing or not among them; the message lists those that are.
    """
    formats = tuple(among)
    ending = PurePath(path).suffix.lower()
    for one in formats:
        if ending in one.endings:
            return one
    endings = (ending for one in formats for ending in one.endings)
    known = ", ".join(dict.fromkeys((*others, *endings)))
    said = f"“{ending}” cannot be used here" if ending else "The file name has no ending"
    raise UserError(f"{said}. Use one of {known}.")


def function(format: Format, name: str) -> Any:
    """Import a function of a format's module."""
    return getattr(import_module(f"bozzetto.exchange.{format.module}"), name)
