"""Arcs in corners, with what was there before, so that another radius can be typed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from bozzetto.geometry import Spline
from bozzetto.plugin import Parameter
from bozzetto_product.model.curves import Curve, LaidPlaces, Stretch
from bozzetto_product.model.joints import Boundary, Joint


@dataclass(frozen=True, eq=False)
class Course:
    """How a curve ran before a corner was rounded.

    Parameters
    ----------
    curve : str
        Its id.
    spline : Spline
    laid : LaidPlaces, optional
    stretches : tuple of Stretch
        As of the curve.
    """

    curve: str
    spline: Spline
    laid: LaidPlaces | None
    stretches: tuple[Stretch, ...]


@dataclass(frozen=True, eq=False)
class Rounded:
    """A corner that was rounded, and what was there before.

    Parameters
    ----------
    joint, first, second : str
        Ids of the corner and its curves.
    ways : (int, int)
        As of `fillet`.
    courses : tuple of Course
        Of the curves that were changed.
    joints : tuple of Joint
        Those that were changed, or went.
    added : tuple of str
        Ids of joints that came.
    boundaries : tuple of (str, Boundary)
        Those that were changed, by the ids of their patches.
    rejected : tuple of Boundary
        Loops that were switched off.
    digest : str
        Of all that is told here as it was after; while it is so the corner can be rounded anew.
    """

    joint: str
    first: str
    second: str
    ways: tuple[int, int]
    courses: tuple[Course, ...]
    joints: tuple[Joint, ...]
    added: tuple[str, ...]
    boundaries: tuple[tuple[str, Boundary], ...]
    rejected: tuple[Boundary, ...]
    digest: str


@dataclass(frozen=True)
class Arc(Curve):
    """A curve that rounds a corner.

    Parameters
    ----------
    rounded : Rounded, optional
        The corner. None only of the kind of part, before one is rounded.
    """

    rounded: Rounded | None = None
    radius: Annotated[
        float,
        Parameter("Radius", 1e-3, 1e5, unit="mm", help="The corner is rounded anew by it."),
    ] = 5.0
