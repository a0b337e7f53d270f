"""Texts and outlines that are laid on surfaces, as details."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.plugin import Parameter, Part
from bozzetto_product.lettering.text_outlines import text_outlines
from bozzetto_product.model.details import Detail

FARTHEST = 1e9
"""Largest coordinate of an outline: squares of it are still numbers."""

LONGEST_TEXT = 60
"""Letters of a text at most: each is carved by itself."""


@dataclass(frozen=True, eq=False)
class FlatOutlines:
    """Outlines in a plane, as they are laid on a surface.

    Parameters
    ----------
    points : (n, 2) float64
        Of all outlines, y up, in heights of capitals, or of the whole.
    corners : (n,) uint8
        1 where the outline has a corner, else 0.
    starts : (k,) int32
        First point of each outline; all are closed.
    text : str
        The text that they are the outlines of; "" where they are drawn.
    missing : str
        Letters of it of which there is no outline.
    """

    points: NDArray[np.float64]
    corners: NDArray[np.uint8]
    starts: NDArray[np.int32]
    text: str = ""
    missing: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points, np.float64, 2))
        object.__setattr__(self, "corners", frozen(self.corners, np.uint8))
        object.__setattr__(self, "starts", frozen(self.starts, np.int32))
        if len(self.points) != len(self.corners):
            raise ValueError("every point needs whether it is a corner")
        if not np.isfinite(self.points).all() or np.abs(self.points).max(initial=0.0) > FARTHEST:
            raise ValueError("an outline is farther away than anything can be drawn")
        ends = np.append(self.starts, len(self.points))
        if len(self.starts) and (ends[0] != 0 or (np.diff(ends) < 3).any()):
            raise ValueError("an outline needs three points at least")

    @property
    def rows(self) -> list[NDArray[np.float64]]:
        """The points of each outline, (n, 2)."""
        return np.split(self.points, self.starts[1:]) if len(self.starts) else []

    @classmethod
    def of_text(cls, text: str) -> FlatOutlines:
        """Return the outlines of a text."""
        found = text_outlines(text[:LONGEST_TEXT])
        if not found.rows:
            nothing = np.empty(0, np.uint8), np.empty(0, np.int32)
            return cls(np.empty((0, 2)), *nothing, text, found.missing)
        starts = np.cumsum([0, *(len(row) for row in found.rows[:-1])])
        corners = np.concatenate(found.corners).astype(np.uint8)
        return cls(
            np.concatenate(found.rows), corners, starts.astype(np.int32), text, found.missing
        )


@dataclass(frozen=True)
class Lettering(Part):
    """Fields of an emblem besides those of a detail; it stands before it in forms.

    Parameters
    ----------
    flat : FlatOutlines, optional
        What is laid on the surface. That of a text is kept, so that it stays what it was whatever
        letters a later program has.
    """

    text: Annotated[str, Parameter("Text", help="One line.")] = ""
    height: Annotated[
        float, Parameter("Height", 1e-2, 1e4, unit="mm", help="Of capitals, or of the outlines.")
    ] = 10.0
    turn: Annotated[
        float, Parameter("Turn", -180.0, 180.0, 1.0, unit="°", help="On the surface.")
    ] = 0.0
    flat: FlatOutlines | None = None

    def __post_init__(self) -> None:
        if self.text and (self.flat is None or self.flat.text != self.text):
            object.__setattr__(self, "flat", FlatOutlines.of_text(self.text))
        elif not self.text and self.flat is not None and self.flat.text:
            object.__setattr__(self, "flat", None)


@dataclass(frozen=True)
class Emblem(Detail, Lettering):
    """A text, or outlines drawn elsewhere, laid on a surface.

    `places` are two places on surfaces: its middle, and one above it. Both go along with the
    surfaces.
    """
