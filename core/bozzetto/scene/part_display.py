"""Parts of shapes as they are shown: with their pictures and colours."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from bozzetto.scene.display_list import Shaded

if TYPE_CHECKING:
    from bozzetto.geometry import Solid, Surface


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
