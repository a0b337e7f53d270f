"""Pictures on the card: uploaded once, however often the layers around them are rebuilt."""

from __future__ import annotations

import weakref
from collections import OrderedDict
from typing import Final

import numpy as np
from numpy.typing import NDArray
from OpenGL import GL

from bozzetto.scene.renderer.mipmaps import level
from bozzetto.scene.renderer.textures import smallest_level

__all__ = ["Textures"]

MOST: Final = 32
"""Pictures that stay on the card; the one that was shown least lately goes first."""


class Textures:
    """The pictures of one context, by the arrays that hold their pixels.

    While a mark is dragged over a sketch, a preview comes thirty times a second, each with a
    layer of its own for the same picture.
    """

    def __init__(self) -> None:
        self._held: OrderedDict[int, tuple[weakref.ref[NDArray[np.uint8]], int]] = OrderedDict()

    def bind(self, pixels: NDArray[np.uint8]) -> None:
        """Make a picture, (h, w, 4) RGBA, the current texture, multiplied by its opacity.

        What lies under clear texels is nobody's colour: it must not be mixed with its neighbours'.
        """
        known = self._held.get(id(pixels))
        if known is not None and known[0]() is pixels:
            self._held.move_to_end(id(pixels))
            GL.glBindTexture(GL.GL_TEXTURE_2D, known[1])
            return
        self._make_room()
        texture = int(GL.glGenTextures(1))
        self._held[id(pixels)] = weakref.ref(pixels), texture
        GL.glBindTexture(GL.GL_TEXTURE_2D, texture)
        GL.glTexParameteri(GL.GL_TEXTURE_2D, GL.GL_TEXTURE_MAG_FILTER, GL.GL_LINEAR)
        for name in (GL.GL_TEXTURE_WRAP_S, GL.GL_TEXTURE_WRAP_T):
            GL.glTexParameteri(GL.GL_TEXTURE_2D, name, GL.GL_CLAMP_TO_EDGE)
        height, width = pixels.shape[:2]
        GL.glPixelStorei(GL.GL_UNPACK_ALIGNMENT, 1)
        GL.glTexImage2D(
            GL.GL_TEXTURE_2D, 0, GL.GL_RGBA, width, height, 0, GL.GL_RGBA, GL.GL_UNSIGNED_BYTE,
            level(pixels, 1, 1),
        )  # fmt: skip
        smaller = GL.GL_LINEAR
        if GL.glGenerateMipmap:  # not before OpenGL 3
            last = smallest_level(pixels)
            GL.glTexParameteri(GL.GL_TEXTURE_2D, GL.GL_TEXTURE_MAX_LEVEL, last)
            GL.glGenerateMipmap(GL.GL_TEXTURE_2D)
            smaller = GL.GL_LINEAR_MIPMAP_LINEAR
        GL.glTexParameteri(GL.GL_TEXTURE_2D, GL.GL_TEXTURE_MIN_FILTER, smaller)

    def free(self) -> None:
        """Give all pictures back; the context must be current."""
        for _, texture in self._held.values():
            GL.glDeleteTextures([texture])
        self._held.clear()

    def _make_room(self) -> None:
        """Give back what nobody holds any more, and the oldest of too many."""
        gone = [key for key, (pixels, _) in self._held.items() if pixels() is None]
        kept = [key for key in self._held if key not in gone]
        gone += kept[: max(0, len(kept) + 1 - MOST)]
        for key in gone:
            GL.glDeleteTextures([self._held.pop(key)[1]])
