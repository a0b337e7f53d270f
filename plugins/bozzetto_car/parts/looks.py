"""Parts of a car: what is seen of each and what is handed over, with one name and one look."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Final

from bozzetto.geometry import Brep, Look, Mesh, Placement

MIRRORED: Final = Placement((1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0))


PAINT: Final = Look(None, "gloss", "Paint")
"""Its colour is that of the object."""

GLASS: Final = Look((58, 66, 72), "glass", "Glass")
RUBBER: Final = Look((46, 45, 44), "rubber", "Rubber")
CHROME: Final = Look((198, 196, 192), "metal", "Chrome")
LAMP: Final = Look((222, 226, 228), "gloss", "Lamp glass")
TAIL: Final = Look((150, 32, 30), "gloss", "Tail lamp glass")
DARK: Final = Look((62, 60, 58), "matt", "Black plastic")


@dataclass(frozen=True, eq=False)
class CarPart:
    """A part beside the surfaces of a car, or in them.

    Attributes
    ----------
    name : str
    look : Look
    mesh : callable
        Makes what is seen of it, where only the eye counts.
    exact : callable
        Makes what is handed over, with the name and the look.
    """

    name: str
    look: Look
    mesh: Callable[[], Mesh]
    exact: Callable[[], Brep]


def on_both_sides(
    name: str, look: Look, mesh: Callable[[], Mesh], exact: Callable[[], Brep]
) -> tuple[CarPart, CarPart]:
    """Return a part of the right half and its mirror image; each is made once for both."""
    seen, solid = cache(mesh), cache(exact)
    right, left = f"{name} right", f"{name} left"
    return (
        CarPart(right, look, seen, cache(lambda: looking(solid(), right, look))),
        CarPart(
            left,
            look,
            lambda: seen().placed(MIRRORED),
            cache(lambda: looking(solid().placed(MIRRORED), left, look)),
        ),
    )


def looking(part: Brep, name: str, look: Look) -> Brep:
    """Return a part with a name and a look for all its faces."""
    faces = (replace(face, name=name, **look._asdict()) for face in part.faces)
    return replace(part, name=name, color=look.color, faces=tuple(faces))


def left(part: Brep) -> Brep:
    """Return the mirror image of a part of the right half, with the names of the left one."""
    image = part.placed(MIRRORED)
    faces = tuple(replace(face, name=face.name.replace(".R", ".L")) for face in image.faces)
    return replace(image, faces=faces)
