"""Parts of shapes as they are shown: with their pictures and colours."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from bozzetto.scene.display_list import Shaded

if TYPE_CHECKING:
    from bozzetto.geometry import Look, Mesh, Solid, Surface
    from bozzetto.geometry.look import Finish as Material
    from bozzetto.scene.display_list import Finish

SHOWN_FINISHES: Final[dict[Material, tuple[Finish, float]]] = {
    "matt": ("clay", 1.0),
    "gloss": ("gloss", 1.0),
    "rubber": ("rubber", 1.0),
    "metal": ("metal", 1.0),
    "glass": ("gloss", 0.45),
}
"""How a surface is shown by what it is made of, and its opacity."""


def in_look(mesh: Mesh, look: Look) -> Shaded:
    """Return a mesh as it is shown in a look; without a colour it has that of its object."""
    finish, opacity = SHOWN_FINISHES[look.finish]
    return Shaded(mesh, "clay" if look.color is None else look.color, opacity, finish=finish)


def shaded_part(part: Solid | Surface) -> tuple[Shaded, ...]:
    """Return what is shown of a part.

    Its picture or the colours of its vertices come before the colours of its groups, and these
    before its own.
    """
    mesh, texture, bare = part.mesh, part.texture, "clay" if part.color is None else part.color
    if texture is not None:
        return (Shaded(replace(mesh, colors=None, cover=None), bare, texture=texture),)
    if mesh.colors is not None or not any(group.color for group in part.groups):
        return (Shaded(mesh, bare),)
    found, begin = [], 0
    for group in part.groups:
        own = replace(mesh, faces=mesh.faces[begin : begin + group.count])
        found.append(Shaded(own, group.color or bare))
        begin += group.count
    return tuple(found)
