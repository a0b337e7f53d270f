"""The recipe of what is turned: the ink, and how it is read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from bozzetto.plugin import Ink, Parameter


@dataclass(frozen=True)
class LatheState:
    """A profile, the strokes that were drawn over it, and the axis.

    Parameters
    ----------
    profile : tuple of Ink
        One stroke each: the profile, then what changes it, in the order drawn.
    axis : Ink, optional
        A stroke along the axis; without it the axis is upright through the origin.
    """

    profile: tuple[Ink, ...] = ()
    axis: Ink | None = None
    detail: Annotated[
        int,
        Parameter("Detail", 4, 80, help="Control points of the profile: more follow the ink."),
    ] = 24
    ends: Annotated[
        Literal["closed", "open"],
        Parameter("Ends", help="Closed ends are flat discs, and make a solid."),
    ] = "closed"
