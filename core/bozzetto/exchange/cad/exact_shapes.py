"""What our own readers of STEP and IGES take exactly from a file, and what they leave."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Final

from bozzetto.exchange.limits import MAX_CONTROL_POINTS, MAX_PARTS, at_most
from bozzetto.geometry.brep.brep import Brep
from bozzetto.geometry.curve import Curve

MOST_CURVES: Final = 5 * MAX_PARTS
"""Curves that are looked at: half of ten seconds, as long as a file may take."""


@dataclass
class ExactShapes:
    """Curves and bodies of a file, mm.

    Attributes
    ----------
    curves : list of Curve
        Those that belong to no face.
    bodies : list of Brep
        Whose faces are all planes or whole B-spline surfaces.
    other_bodies : int
        Bodies with faces of other kinds.
    other_curves : Counter of str
        Curves that are not read, by what they are.
    """

    curves: list[Curve] = field(default_factory=list)
    bodies: list[Brep] = field(default_factory=list)
    other_bodies: int = 0
    other_curves: Counter[str] = field(default_factory=Counter)
    _points: int = 0
    _asked: int = 0

    def add(self, curve: Curve) -> None:
        """Add a curve.

        Raises
        ------
        FormatError
            If the curves have too many control points together, as in `count`.
        """
        self._points += len(curve.control_points)
        at_most(self._points, MAX_CONTROL_POINTS, "control points")
        self.curves.append(curve)

    def count(self) -> None:
        """Count a curve that is looked at: parts of others are, as often as they are parts.

        Raises
        ------
        FormatError
            If there are too many.
        """
        self._asked += 1
        at_most(self._asked, MOST_CURVES, "curves")
