"""3dm (Rhino 7): exact surfaces and curves, in millimetres.

Patches are surfaces of their own, those of one patchwork a group: rhino3dm cannot join them, but
Rhino's own Join can, for their edges agree. Written with rhino3dm, the extra ``bozzetto[rhino]``.
Every object gets an identity of its own, so that equal shapes give files that differ there.
"""

from __future__ import annotations

import base64
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.cad.cad_curves import checked_curves
from bozzetto.exchange.cad.cad_surfaces import CUBIC_KNOTS, checked_patchworks, names_of_patches
from bozzetto.exchange.optional_libraries import library
from bozzetto.geometry.shapes import Color, Curve, Shapes

VERSION: Final = 7
"""The version of the file: Rhino 7 and all later ones read it."""

BRACKETS: Final = ("(", "[", "{", ")", "]", "}")
"""With these no name begins: openNURBS would drop it."""


def write_shapes(shapes: Shapes) -> bytes:
    """Write the patchworks and curves as 3dm, with names and colours.

    Raises
    ------
    UserError
        As `checked_patchworks` and `checked_curves`, or if rhino3dm is not installed.
    """
    rhino = library("rhino3dm", "rhino")
    patchworks = checked_patchworks(shapes)
    curves = checked_curves(shapes) if shapes.curves or not patchworks else ()
    model = rhino.File3dm()
    model.ApplicationName = "Bozzetto"
    model.Settings.ModelUnitSystem = rhino.UnitSystem.Millimeters
    for number, patchwork in enumerate(patchworks):
        group = rhino.Group()
        group.Name = _name(patchwork.name)
        model.Groups.Add(group)
        for net, name in zip(patchwork.nets, names_of_patches(patchwork), strict=True):
            look = _look(rhino, name, patchwork.color)
            look.AddToGroup(number)
            model.Objects.AddSurface(_surface(rhino, net), look)
    for curve in curves:
        model.Objects.AddCurve(_curve(rhino, curve), _look(rhino, curve.name, curve.color))
    options = rhino.File3dmWriteOptions()
    options.Version = VERSION
    return base64.b64decode(model.Encode(options))


def _curve(rhino: Any, curve: Curve) -> Any:
    count = len(curve.control_points)
    made = rhino.NurbsCurve(3, curve.weights is not None, curve.degree + 1, count)
    for place, knot in enumerate(curve.knots[1:-1].tolist()):  # openNURBS has no outermost
        made.Knots[place] = knot
    weights = np.ones(count) if curve.weights is None else curve.weights
    lifted = np.column_stack((curve.control_points * weights[:, None], weights))
    for place, point in enumerate(lifted.tolist()):
        made.Points[place] = rhino.Point4d(*point)
    return made


def _surface(rhino: Any, net: NDArray[np.float64]) -> Any:
    made = rhino.NurbsSurface.Create(3, False, 4, 4, 4, 4)
    for place, knot in enumerate(CUBIC_KNOTS[1:-1].tolist()):
        made.KnotsU[place] = made.KnotsV[place] = knot
    for (i, j), point in zip(np.ndindex(4, 4), net.reshape(-1, 3).tolist(), strict=True):
        made.Points[i, j] = rhino.Point4d(*point, 1.0)
    return made


def _look(rhino: Any, name: str, color: Color | None) -> Any:
    look = rhino.ObjectAttributes()
    look.Name = _name(name)
    if color is not None:
        look.ColorSource = rhino.ObjectColorSource.ColorFromObject
        look.ObjectColor = (*color, 255)
    return look


def _name(name: str) -> str:
    return f"_{name}" if name.startswith(BRACKETS) else name
