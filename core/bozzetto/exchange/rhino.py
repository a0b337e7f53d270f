"""3dm (Rhino 7): exact curves, in millimetres.

Written with rhino3dm, the extra ``bozzetto[rhino]``. Every object gets an identity of its own,
so that equal shapes give files that differ there.
"""

from __future__ import annotations

import base64
from typing import Final

import numpy as np

from bozzetto.exchange.curve_pieces import checked_curves
from bozzetto.exchange.extras import library
from bozzetto.geometry.shapes import Shapes

__all__ = ["write_shapes"]

VERSION: Final = 7
"""The version of the file: Rhino 7 and all later ones read it."""

BRACKETS: Final = ("(", "[", "{", ")", "]", "}")
"""With these no name begins: openNURBS would drop it."""


def write_shapes(shapes: Shapes) -> bytes:
    """A 3dm file of the curves, with names and colours.

    Raises
    ------
    UserError
        As `checked_curves`, or if rhino3dm is not installed.
    """
    rhino = library("rhino3dm", "rhino")
    curves = checked_curves(shapes)
    model = rhino.File3dm()
    model.ApplicationName = "Bozzetto"
    model.Settings.ModelUnitSystem = rhino.UnitSystem.Millimeters
    for curve in curves:
        count = len(curve.control_points)
        made = rhino.NurbsCurve(3, curve.weights is not None, curve.degree + 1, count)
        for place, knot in enumerate(curve.knots[1:-1].tolist()):  # openNURBS has no outermost
            made.Knots[place] = knot
        weights = np.ones(count) if curve.weights is None else curve.weights
        lifted = np.column_stack((curve.control_points * weights[:, None], weights))
        for place, point in enumerate(lifted.tolist()):
            made.Points[place] = rhino.Point4d(*point)
        look = rhino.ObjectAttributes()
        look.Name = f"_{curve.name}" if curve.name.startswith(BRACKETS) else curve.name
        if curve.color is not None:
            look.ColorSource = rhino.ObjectColorSource.ColorFromObject
            look.ObjectColor = (*curve.color, 255)
        model.Objects.AddCurve(made, look)
    options = rhino.File3dmWriteOptions()
    options.Version = VERSION
    return base64.b64decode(model.Encode(options))
