"""Clips and masks of SVG: which lines they hide altogether, and whether they may cut others."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.safe_xml import Element
from bozzetto.exchange.svg.path_data import Subpath
from bozzetto.exchange.svg.shapes import LONGEST_LENGTH, outline

REFERENCE: Final = re.compile(r"\s*+url\(\s*+[\"']?#([^\"')\s]+)")

MAX_SHAPES: Final = 100
"""Shapes of one clip that are looked at."""

ROUNDED: Final = 1e-6
"""Distance of a corner from the box around a clip, as a share of it, that comes from rounding."""

Box = tuple[float, float, float, float]
"""Least x and y, largest x and y."""


def named_clip(text: str) -> str:
    """Return the id that the value of a ``clip-path`` or ``mask`` names, or ""."""
    found = REFERENCE.match(text) if len(text) <= LONGEST_LENGTH else None
    return found[1] if found else ""


def box_of(path: Subpath) -> Box | None:
    """Return a box around the control points of a path; None if it has none."""
    points = path.cubics.reshape(-1, 2)
    if not len(points):
        return None
    (left, top), (right, bottom) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return left, top, right, bottom


@dataclass(frozen=True, eq=False)
class Clip:
    """What is known of a clip: measured once, however many parts of a drawing it cuts.

    Parameters
    ----------
    corners : (4, 2) float or None
        Of a box around it, in the user units of what is clipped, one after another; None where it
        is not known what it lets through, as that of a mask.
    is_rectangle : bool
        Whether it lets through all of that box.
    """

    corners: Array | None
    is_rectangle: bool = False

    @classmethod
    def of(
        cls,
        target: Element,
        matrix_of: Callable[[Element], Array | None],
        page: tuple[float, float] | None,
    ) -> Clip:
        """Measure a ``clipPath`` or ``mask``.

        Parameters
        ----------
        target : Element
            It.
        matrix_of : callable
            Gives the transform (3, 3) of an element, or None.
        page : (width, height), optional
            What percentages are of, user units.
        """
        shapes = [child for child in target.children if child.tag != "title"]
        plain = target.attributes.get("clipPathUnits", "userSpaceOnUse") == "userSpaceOnUse"
        if (
            target.tag == "mask"
            or not plain
            or len(shapes) > MAX_SHAPES
            or any(child.tag == "use" for child in shapes)
        ):
            return cls(None)
        places = []
        for child in shapes:
            turn = np.eye(3)
            for matrix in (matrix_of(target), matrix_of(child)):
                turn = turn if matrix is None else turn @ matrix
            places += [
                path.cubics.reshape(-1, 2) @ turn[:2, :2].T + turn[:2, 2]
                for path in outline(child, page)
            ]
        if not sum(map(len, places)):
            return cls(None)
        low, high = (end(np.concatenate(places), axis=0) for end in (np.min, np.max))
        corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        alone = len(places) == 1 and shapes[0].tag == "rect"
        return cls(corners, alone and _on_sides(places[0], low, high))

    def look(self, matrix: Array) -> tuple[Box, bool] | None:
        """Return the box around it under a transform (3, 3), and whether that is all of it."""
        if self.corners is None:
            return None
        places = self.corners @ matrix[:2, :2].T + matrix[:2, 2]
        low, high = places.min(axis=0), places.max(axis=0)
        (left, top), (right, bottom) = low.tolist(), high.tolist()
        exact = self.is_rectangle and _on_sides(places, low, high)
        return (left, top, right, bottom), exact


def lies_apart(one: Box, other: Box) -> bool:
    """Whether two boxes have nothing in common."""
    return one[0] > other[2] or one[2] < other[0] or one[1] > other[3] or one[3] < other[1]


def lies_within(one: Box, other: Box) -> bool:
    """Whether a box lies in another one, but for rounding."""
    slack = ROUNDED * max(other[2] - other[0], other[3] - other[1])
    starts = one[0] >= other[0] - slack and one[1] >= other[1] - slack
    return starts and one[2] <= other[2] + slack and one[3] <= other[3] + slack


def _on_sides(places: Array, low: Array, high: Array) -> bool:
    """Whether places lie on the sides of the box around them, as the corners of it do."""
    off = np.minimum(np.abs(places - low), np.abs(places - high))
    return bool((off.min(axis=1) <= ROUNDED * float(np.max(high - low))).all())
