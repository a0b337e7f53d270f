"""The unit and the upward axis of a mesh file that does not say them.

Comments at its beginning often do. Else a thing tells by its shape: most stand on something flat,
and sizes in metres are small numbers. What is left is what the format's writers do.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.exchange.handover import UNIT_NAMES, FileFrame, Unit, Up
from bozzetto.geometry.shapes import Shapes

HEAD: Final = 4096
"""Bytes at the beginning of a file in which comments are looked for."""

UNIT_SAID: Final = re.compile(
    rb"\bunits?\b\s*(?:scale|name)?\s*[:=\s]\s*\"?(?:1\s*)?"
    rb"(mm|millimet(?:er|re)s?|cm|centimet(?:er|re)s?|m|met(?:er|re)s?|in|inch(?:es)?)\b",
    re.IGNORECASE,
)
"""As SketchUp, Rhino, 3ds Max and Magics have it, such as ``# File units = meters``."""

UP_SAID: Final = re.compile(
    rb"\b([yz])[ _-]*(?:axis[ _-]*)?(?:is[ _-]*)?up\b|\bup[ _-]*(?:axis)?\s*[:=]?\s*\+?([yz])\b",
    re.IGNORECASE,
)

PRINTED: Final = re.compile(rb"blender|freecad|openscad|slic3r|prusaslicer", re.IGNORECASE)
"""Programs that name themselves in STL files and have Z up in them: a thing of which the lowest
place is round and one side flat stands on that side else."""

BY_FIRST: Final[dict[bytes, Unit]] = {b"mm": "mm", b"mi": "mm", b"c": "cm", b"m": "m", b"i": "in"}
"""Units by how their names begin; the longest beginning that fits."""

SMALL: Final = 10.0
"""A thing whose longest side is a smaller number is told in metres: ten millimetres is less than
anything that people model, ten metres more than most."""

SMALL_PRINT: Final = 1.0
"""The same for STL, where small parts in millimetres are usual."""

FOOT: Final = 0.04
"""Share of the whole area that faces down at the lowest place of a thing that stands on it."""

LEVEL: Final = 0.01
"""How far above the lowest place that is, as a share of the height."""

STEEP: Final = 0.98
"""Least cosine between the way down and that in which a triangle of a foot faces."""

MAX_LOOKED_AT: Final = 400_000
"""Triangles that are looked at; of more every so-and-so-manyth."""


@dataclass(frozen=True)
class FrameGuess:
    """A frame, and why.

    Parameters
    ----------
    unit : {"mm", "cm", "m", "in"}
    up : {"y", "z"}
    unit_reason, up_reason : str
        Such as "its comments say so".
    """

    unit: Unit = "mm"
    up: Up = "z"
    unit_reason: str = ""
    up_reason: str = ""

    @property
    def frame(self) -> FileFrame:
        """The unit and the axis."""
        return FileFrame(self.unit, self.up)

    def sentence(self) -> str:
        """Return what a person is told."""
        return (
            f"Read as {UNIT_NAMES[self.unit]} ({self.unit_reason}), {self.up.upper()} up "
            f"({self.up_reason}). Parameters can change both."
        )


def guessed_frame(data: bytes, form: str, shapes: Shapes) -> FrameGuess:
    """Guess the frame of a file.

    Parameters
    ----------
    data : bytes
        The file.
    form : str
        Id of its format.
    shapes : Shapes
        What was read of it, in its own frame.
    """
    head = data[:HEAD] if form != "ply" else data[: max(data.find(b"end_header", 0, HEAD), 0)]
    comments = b"\n".join(_comments(head, form))
    unit, unit_reason = _unit(comments, form, shapes)
    up, up_reason = _up(comments, form, shapes)
    return FrameGuess(unit, up, unit_reason, up_reason)


def _comments(head: bytes, form: str) -> list[bytes]:
    """Return the lines at the beginning of a file that are for people."""
    if form == "stl":
        return [head[:80].partition(b"\n")[0]]
    marks = (b"#",) if form in ("obj", "off") else (b"comment", b"obj_info")
    lines = (line.strip() for line in head.splitlines())
    return [line for line in lines if line.startswith(marks)]


def _unit(comments: bytes, form: str, shapes: Shapes) -> tuple[Unit, str]:
    said = UNIT_SAID.search(comments)
    if said is not None:
        word = said[1].lower()
        first = next(k for k in sorted(BY_FIRST, key=len, reverse=True) if word.startswith(k))
        return BY_FIRST[first], "its comments say so"
    boxes = np.array([part.mesh.bounds for part in shapes.meshes()], float)
    longest = float((boxes[:, 1].max(axis=0) - boxes[:, 0].min(axis=0)).max())
    if longest < (SMALL_PRINT if form == "stl" else SMALL):
        return "m", f"its longest side is {longest:.3g}"
    return "mm", "it does not say"


def _up(comments: bytes, form: str, shapes: Shapes) -> tuple[Up, str]:
    said = UP_SAID.search(comments)
    if said is not None:
        return ("y" if (said[1] or said[2]).lower() == b"y" else "z"), "its comments say so"
    if form == "stl" and PRINTED.search(comments):
        return "z", "as the program that wrote it"
    upright, lying = (_foot(shapes, axis) for axis in (1, 2))
    if max(upright, lying) >= FOOT and max(upright, lying) > 2.0 * min(upright, lying):
        return ("y" if upright > lying else "z"), "it stands so"
    return ("y", "as most OBJ files") if form == "obj" else ("z", "it does not say")


def _foot(shapes: Shapes, axis: int) -> float:
    """Return the share of the area that faces down along an axis at the lowest place."""
    parts = list(shapes.meshes())
    low = min(float(part.mesh.vertices[:, axis].min()) for part in parts)
    high = max(float(part.mesh.vertices[:, axis].max()) for part in parts)
    whole = foot = 0.0
    for part in parts:
        step = 1 + len(part.mesh.faces) // MAX_LOOKED_AT
        corners = part.mesh.vertices[part.mesh.faces[::step]].astype(np.float64)
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        areas = np.linalg.norm(cross, axis=1)
        level = corners[:, :, axis].max(axis=1) <= low + LEVEL * (high - low)
        foot += step * float(areas[level & (-cross[:, axis] >= STEEP * areas)].sum())
        whole += step * float(areas.sum())
    return foot / whole if whole > 0.0 else 0.0
