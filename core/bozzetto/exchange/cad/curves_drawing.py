"""Curves in space as ink, for modelers that start from ink: seen along their shortest side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.cad.rings import TOGETHER, size_of, with_rings
from bozzetto.exchange.limits import MAX_SAMPLES, at_most
from bozzetto.exchange.page_layout import sheet_drawing
from bozzetto.geometry.basis import span_parameters
from bozzetto.geometry.curve import Curve
from bozzetto.ink.drawing import Drawing

STEPS: Final = 32
"""Steps of a span: a quarter of a circle is 1.5e-4 of its diameter off."""

FLAT: Final = 1e-6
"""Curves that are higher than this share of their size are some in space."""

VIEWS: Final = {
    2: ("above", (0, 1), (1.0, -1.0)),
    1: ("the front", (0, 2), (1.0, -1.0)),
    0: ("the right", (1, 2), (1.0, -1.0)),
}
"""By the axis along which one looks: its name, the axes of the sheet and their signs."""


def drawing_of_curves(curves: Sequence[Curve], name: str) -> Drawing:
    """Return curves as a drawing, a stroke for every curve or closed ring of them.

    They are seen along the axis in which they reach least; of several along z before y before x.

    Parameters
    ----------
    curves : sequence of Curve
        At least one, mm.
    name : str
        Name of the drawing.
    """
    lines = [line_of(curve) for curve in curves]
    at_most(sum(map(len, lines)), MAX_SAMPLES, "points")
    extent = np.ptp(np.concatenate(lines), axis=0)
    axis = max((2, 1, 0), key=lambda k: (bool(extent[k] <= extent.min() * (1.0 + 1e-9)), k))
    said, kept, signs = VIEWS[axis]
    flat = [(line[:, kept] * signs, curve.color) for line, curve in zip(lines, curves, strict=True)]
    flat = [each for each in flat if np.ptp(each[0], axis=0).max() > 0.0]  # seen from its end
    rings = with_rings(flat, TOGETHER * size_of([line for line, _ in flat]))
    drawing = sheet_drawing(
        [line for line, _ in rings], None, name, colors=[color for _, color in rings]
    )
    if extent[axis] <= FLAT * extent.max():
        return drawing
    told = f"These curves lie in space: they are read as seen from {said}."
    return replace(drawing, left_out=(told,))


def are_flat(curves: Sequence[Curve]) -> bool:
    """Whether curves lie in a plane of coordinates, or beside it."""
    extent = np.ptp(np.concatenate([line_of(curve) for curve in curves]), axis=0)
    return bool(extent.min() <= FLAT * extent.max())


def line_of(curve: Curve) -> Array:
    """Return places on a curve that follow one another, (n, 3), mm."""
    if curve.degree == 1 and curve.is_clamped:
        return curve.control_points
    steps = 1 if curve.degree == 1 else STEPS
    return curve.value(span_parameters(curve.degree, curve.knots, steps))
