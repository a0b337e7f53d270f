"""Names and looks of the parts of a car, and their mirror images."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from bozzetto.geometry import Brep, Look, Placement

MIRRORED: Final = Placement((1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0))


PAINT: Final = Look((201, 188, 172), "gloss", "Paint")
GLASS: Final = Look((58, 66, 72), "glass", "Glass")
RUBBER: Final = Look((46, 45, 44), "rubber", "Rubber")
CHROME: Final = Look((198, 196, 192), "metal", "Chrome")
LAMP: Final = Look((222, 226, 228), "gloss", "Lamp glass")
TAIL: Final = Look((150, 32, 30), "gloss", "Tail lamp glass")
DARK: Final = Look((62, 60, 58), "matt", "Black plastic")


def looking(part: Brep, name: str, look: Look) -> Brep:
    """Return a part with a name and a look for all its faces."""
    faces = (replace(face, name=name, **look._asdict()) for face in part.faces)
    return replace(part, name=name, color=look.color, faces=tuple(faces))


def left(part: Brep) -> Brep:
    """Return the mirror image of a part of the right half, with the names of the left one."""
    image = part.placed(MIRRORED)
    faces = tuple(replace(face, name=face.name.replace(".R", ".L")) for face in image.faces)
    return replace(image, faces=faces)
