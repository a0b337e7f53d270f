"""Pictures of foreign meshes, read: all that one object shows becomes one picture around it.

An object of a 3MF or OBJ file may show several pictures, and plain colours besides. Cut up by them
it would be closed no longer, so its pictures are put above each other, with a patch for each
colour below.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array, Bytes, Index, frozen
from bozzetto.errors import UserError
from bozzetto.exchange.image import read_pixels
from bozzetto.exchange.limits import MAX_PIXELS, at_most
from bozzetto.exchange.reading import Reading
from bozzetto.geometry.texture import Texture

ROUNDING: Final = 1e-4
"""Share of a picture by which a place may lie outside of it: at its border."""

PATCH: Final = 4
"""Texels along a patch of one colour; its middle is shown."""

REPEATED: Final = "that pictures repeat within a triangle (bake them in the program that made it)"


@dataclass
class Pictures:
    """The pictures of a file, those that were asked for so far.

    Parameters
    ----------
    kind : str
        Of the file, for messages.
    reading : Reading
        Where it is told what is left out.
    """

    kind: str
    reading: Reading
    _known: dict[str, Bytes | None] = field(default_factory=dict)
    _size: int = 0
    _together: dict[tuple[tuple[str, ...], bytes], Bytes] = field(default_factory=dict)

    def add(self, path: str, load: Callable[[], bytes]) -> None:
        """Unpack a picture; what it takes is told if it cannot be had."""
        if path in self._known:
            return
        self._known[path] = None
        try:
            pixels = read_pixels(load())
            self._count(pixels.shape[0] * pixels.shape[1])
        except UserError as error:
            self._leave_out(f"a picture. {error.message}")
            return
        self._known[path] = pixels

    def _count(self, pixels: int) -> None:
        at_most(self._size + pixels, MAX_PIXELS, "pixels in pictures")
        self._size += pixels

    def texture(
        self, shown: Index, paths: list[str], places: Array, colors: NDArray[np.uint8]
    ) -> Texture | None:
        """Return what the triangles of an object show, as one picture; None if none can be read.

        Parameters
        ----------
        shown : (f,) int array
            The picture of each triangle; -1 where it has none.
        paths : list of str
            Where these pictures are.
        places : (f, 3, 2) float array
            In them, v upwards.
        colors : (f, 4) uint8 array
            Of triangles without a picture.
        """
        corners = np.zeros((len(shown), 3, 2))
        shown = shown.copy()
        sheets: list[Bytes] = []
        names: list[str] = []
        for number in np.unique(shown[shown >= 0]).tolist():
            own = shown == number
            pixels = self._known[paths[number]]
            if pixels is None:
                shown[own] = -1
                continue
            corners[own] = self._within(places[own]) * pixels.shape[1::-1]
            corners[own, :, 1] += sum(len(sheet) for sheet in sheets)
            sheets.append(pixels)
            names.append(paths[number])
        if not sheets:
            return None
        bare = shown < 0
        kinds, kind = np.unique(colors[bare], axis=0, return_inverse=True)
        if len(kinds):
            columns = max(1, max(sheet.shape[1] for sheet in sheets) // PATCH)
            row, column = np.divmod(kind.ravel(), columns)
            above = sum(len(sheet) for sheet in sheets)
            middle = np.stack([column, row], axis=1) * PATCH + 0.5 * PATCH + (0, above)
            corners[bare] = middle[:, None]
            sheets.append(_patches(kinds, columns))
        key = tuple(names), kinds.tobytes()
        if key not in self._together:
            self._together[key] = frozen(self._above_each_other(sheets), np.uint8)
        pixels = self._together[key]
        return Texture(pixels, (corners / pixels.shape[1::-1]).astype(np.float32))

    def _above_each_other(self, sheets: list[Bytes]) -> Bytes:
        if len(sheets) == 1:
            return sheets[0]
        wide = max(sheet.shape[1] for sheet in sheets)
        self._count(wide * sum(len(sheet) for sheet in sheets))
        whole = [np.pad(one, ((0, 0), (0, wide - one.shape[1]), (0, 0)), "edge") for one in sheets]
        return np.concatenate(whole)

    def _within(self, places: Array) -> Array:
        """Return places (f, 3, 2) in the picture itself, v downwards."""
        inner = places - np.floor(places.min(axis=1, keepdims=True) + ROUNDING)
        if inner.max(initial=0.0) > 1.0 + ROUNDING:
            self._leave_out(REPEATED)
        lies = ((places >= -ROUNDING) & (places <= 1.0 + ROUNDING)).all(axis=(1, 2), keepdims=True)
        found = np.clip(np.where(lies, places, inner), 0.0, 1.0)
        found[..., 1] = 1.0 - found[..., 1]
        return found

    def _leave_out(self, what: str) -> None:
        self.reading.tell(f"Left out of the {self.kind} file: {what}")


def _patches(colors: NDArray[np.uint8], columns: int) -> Bytes:
    rows = -(-len(colors) // columns)
    table = np.zeros((rows * columns, 4), np.uint8)
    table[: len(colors)] = colors
    squares = table.reshape(rows, columns, 4)
    return squares.repeat(PATCH, axis=0).repeat(PATCH, axis=1)
