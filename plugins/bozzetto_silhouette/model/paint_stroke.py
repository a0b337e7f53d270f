"""A stroke of paint on the surface of a part: places on it with radii, not pixels."""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import frozen
from bozzetto.plugin import cached_property, override

Color = tuple[int, int, int]


class BrushLook(NamedTuple):
    """What a stroke of paint looks like, and where it is in the order of all; see `PaintStroke`."""

    number: int
    color: Color | None
    opacity: float
    softness: float


@dataclass(frozen=True, eq=False)
class PaintStroke:
    """What one stroke of the brush left on one part.

    Everything is kept in the part's object frame with the heights that the part would have at
    inflation 1, so it goes where the part goes: moved, mirrored, copied, blown up.

    Parameters
    ----------
    number : int
        Its place in the order of all strokes of paint of the object. Pieces on several parts, and
        mirror images, have one number and are one stroke: where they overlap they cover once.
    points : (n, 3) float32
        Places on the surface, mm.
    normals : (n, 3) float32
        Of the surface there, outwards.
    radii : (n,) float32
        Half the width of the stroke there, mm.
    starts : (k,) int32
        First places of the runs that hang together; ascending from 0.
    color : (r, g, b), optional
        sRGB; None takes paint away.
    opacity : float
        0 to 1.
    softness : float
        Share of the radius over which the edge fades, 0 to 1.

    Raises
    ------
    ValueError
        If the columns do not fit.
    """

    number: int
    points: NDArray[np.float32]
    normals: NDArray[np.float32]
    radii: NDArray[np.float32]
    starts: NDArray[np.int32]
    color: Color | None = None
    opacity: float = 1.0
    softness: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", frozen(self.points, np.float32, 3))
        object.__setattr__(self, "normals", frozen(self.normals, np.float32, 3))
        object.__setattr__(self, "radii", frozen(self.radii, np.float32))
        object.__setattr__(self, "starts", frozen(self.starts, np.int32))
        count, starts = len(self.points), self.starts
        if not count or self.normals.shape != (count, 3) or self.radii.shape != (count,):
            raise ValueError("a stroke of paint needs a normal and a radius for every place")
        if starts.ndim != 1 or not len(starts) or starts[0] != 0 or starts[-1] >= count:
            raise ValueError("the runs of a stroke of paint begin at its first place")
        if (np.diff(starts) <= 0).any() or (self.radii < 0.0).any():
            raise ValueError("runs of a stroke of paint ascend, and radii are not negative")
        if not (0.0 <= self.opacity <= 1.0 and 0.0 <= self.softness <= 1.0):
            raise ValueError("opacity and softness go from 0 to 1")

    @property
    def look(self) -> BrushLook:
        """Its number, colour, opacity and softness."""
        return BrushLook(self.number, self.color, self.opacity, self.softness)

    @cached_property
    def digest(self) -> bytes:
        """Bytes that name its content."""
        state = blake2b(repr(tuple(self.look)).encode(), digest_size=16)
        for column in (self.points, self.normals, self.radii, self.starts):
            state.update(column.tobytes())
        return state.digest()

    @override
    def __eq__(self, other: object) -> bool:
        if not isinstance(other, PaintStroke):
            return NotImplemented
        return self is other or self.digest == other.digest

    @override
    def __hash__(self) -> int:
        return hash(self.digest)
