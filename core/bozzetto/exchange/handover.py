"""How shapes leave for other programs: unit, axes, size, triangles or quads, lines or surfaces."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Final, Literal, get_args

from bozzetto.errors import UserError
from bozzetto.geometry.placement import Placement

Unit = Literal["mm", "cm", "m", "in"]
Up = Literal["y", "z"]
Lines = Literal["outlines", "blueprint"]

UNITS: Final[tuple[Unit, ...]] = get_args(Unit)
UPS: Final[tuple[Up, ...]] = get_args(Up)
LINES: Final[tuple[Lines, ...]] = get_args(Lines)

MM_PER: Final[dict[Unit, float]] = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4}
"""Millimetres in a unit."""

UNIT_NAMES: Final[dict[Unit, str]] = {
    "mm": "millimetres",
    "cm": "centimetres",
    "m": "metres",
    "in": "inches",
}

Y_UP: Final = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0)
"""Rows of the turn that makes z the second axis: x stays, y of the file is our z."""

LEVELS: Final = (4, 16)
"""How many times fewer triangles the coarser levels of detail have."""

FEWEST_TRIANGLES: Final = 4
"""A tetrahedron has so many."""

FEWEST_QUADS: Final = 6
"""A box has so many."""

SCALES: Final = (1e-4, 1e4)
"""Least and largest scale."""


@dataclass(frozen=True)
class FileFrame:
    """The unit of length of a file, and which of its axes points up.

    Parameters
    ----------
    unit : {"mm", "cm", "m", "in"}
    up : {"y", "z"}
    """

    unit: Unit = "mm"
    up: Up = "z"

    @property
    def placement(self) -> Placement:
        """The change from our frame, millimetres with Z up, to that of the file."""
        return Placement(Y_UP if self.up == "y" else Placement().rotation, 1.0 / MM_PER[self.unit])

    def __str__(self) -> str:
        return f"{UNIT_NAMES[self.unit]}, {self.up.upper()} up"


MILLIMETRES: Final = FileFrame()
"""Our own frame."""

SAID: Final = re.compile(
    rb"\A(?:# |ply\s+format [^\n]*\ncomment )?(?:Bozzetto: |Binary STL, )"
    rb"(millimetres|centimetres|metres|inches), ([YZ]) up"
)
"""How a file of ours begins that says its frame."""


def frame_said(data: bytes) -> FileFrame | None:
    """Return the frame that a file of ours says at its beginning; None of any other file."""
    match = SAID.match(data)
    if match is None:
        return None
    unit = next(unit for unit, name in UNIT_NAMES.items() if name.encode() == match[1])
    return FileFrame(unit, "y" if match[2] == b"Y" else "z")


@dataclass(frozen=True)
class Handover:
    """Choices for a file that goes to another program; each None is the format's own way.

    Parameters
    ----------
    unit : {"mm", "cm", "m", "in"}, optional
        In which the numbers of the file are; the size of the things stays.
    up : {"y", "z"}, optional
        The axis of the file that points up.
    scale : float
        Makes the things themselves larger or smaller.
    triangles : int, optional
        The most triangles of all meshes together.
    quads : int, optional
        About so many faces of all meshes together, most of them quads that follow the shape. Not
        together with a number of triangles.
    lay_flat : bool
        Lay everything on its steadiest face, at z = 0, as printers like it.
    lines : {"outlines", "blueprint"}, optional
        For drawings: edges and outlines as a view shows them, or a sheet with four views and
        dimensions, in the place of the curves.
    hidden : bool
        Whether such drawings show hidden lines, dashed.
    levels : bool
        Whether two coarser levels of detail lie in the same file, for what is seen from afar
        (LODs), where its format has a place for them.
    uvs : bool
        Whether parts without a picture are laid out flat for one, where the format has a place
        for that.
    separate_parts : bool
        Whether each named group of a mesh is an object of its own, where the format has objects
        in objects.
    curves_alone : bool
        Whether exact surfaces stay out of formats that hold curves as well.

    Raises
    ------
    UserError
        If a value is out of its range.
    """

    unit: Unit | None = None
    up: Up | None = None
    scale: float = 1.0
    triangles: int | None = None
    quads: int | None = None
    lay_flat: bool = False
    lines: Lines | None = None
    hidden: bool = False
    levels: bool = False
    uvs: bool = False
    separate_parts: bool = False
    curves_alone: bool = False

    def __post_init__(self) -> None:
        for value, known, word in (
            (self.unit, UNITS, "unit"), (self.up, UPS, "axis"), (self.lines, LINES, "drawing"),
        ):  # fmt: skip
            if value is not None and value not in known:
                raise UserError(f"There is no {word} {value!r}. Use one of {', '.join(known)}.")
        if not (math.isfinite(self.scale) and SCALES[0] <= self.scale <= SCALES[1]):
            raise UserError(f"A scale is a number from {SCALES[0]:g} to {SCALES[1]:g}.")
        if self.triangles is not None and self.triangles < FEWEST_TRIANGLES:
            raise UserError(f"A mesh needs at least {FEWEST_TRIANGLES} triangles. Allow more.")
        if self.quads is not None and self.quads < FEWEST_QUADS:
            raise UserError(f"A mesh needs at least {FEWEST_QUADS} quads. Ask for more.")
        if self.quads is not None and self.triangles is not None:
            raise UserError("A mesh is of triangles or of quads. Choose a number of one of them.")


AS_USUAL: Final = Handover()
"""As every format has it."""
