"""Names and looks of the parts of a car, and their mirror images."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

from bozzetto.geometry import Brep, Color, Finish, Placement

MIRRORED: Final = Placement((1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Look:
    """Colour, sRGB, and material of a part."""

    color: Color
    finish: Finish


PAINT: Final = Look((201, 188, 172), "gloss")
GLASS: Final = Look((58, 66, 72), "glass")
RUBBER: Final = Look((46, 45, 44), "rubber")
METAL: Final = Look((198, 196, 192), "metal")
LAMP: Final = Look((222, 226, 228), "gloss")
TAIL: Final = Look((150, 32, 30), "gloss")
DARK: Final = Look((62, 60, 58), "matt")


def looking(part: Brep, name: str, look: Look) -> Brep:
    """Return a part with a name and a look for all its faces."""
    faces = (replace(f, name=name, color=look.color, finish=look.finish) for f in part.faces)
    return replace(part, name=name, color=look.color, faces=tuple(faces))


def left(part: Brep) -> Brep:
    """Return the mirror image of a part of the right half, with the names of the left one."""
    image = part.placed(MIRRORED)
    faces = tuple(replace(face, name=face.name.replace(".R", ".L")) for face in image.faces)
    return replace(image, faces=faces)
