"""DXF (AutoCAD 2010): exact curves as SPLINE entities.

Written with ezdxf, the extra ``bozzetto[dxf]``. The file carries its date and an identity of
its own, so that equal shapes give files that differ there.
"""

from __future__ import annotations

import io
import re
from typing import Final

from bozzetto.exchange.cad.cad_curves import checked_curves
from bozzetto.exchange.handover import MILLIMETRES, FileFrame, Unit
from bozzetto.exchange.optional_libraries import library
from bozzetto.geometry.shapes import Shapes

VERSION: Final = "R2010"
"""Names in Unicode begin with R2007; all programs tried read R2010."""

UNIT_NUMBERS: Final[dict[Unit, int]] = {"mm": 4, "cm": 5, "m": 6, "in": 1}
"""The value of $INSUNITS."""

CLOSED: Final = 1
RATIONAL: Final = 4
"""Flags of a SPLINE (group 70)."""

UNFIT: Final = re.compile(r"[<>/\\\":;?*|=`']")
"""Characters that the names of layers must not have."""

LONGEST_NAME: Final = 255
DEFAULT_LAYER: Final = "0"


def write_shapes(shapes: Shapes, frame: FileFrame = MILLIMETRES) -> bytes:
    """Write the curves as DXF; DXF knows no names of curves, so each names its layer.

    Raises
    ------
    UserError
        As `checked_curves`, or if ezdxf is not installed.
    """
    ezdxf = library("ezdxf", "dxf")
    curves = checked_curves(shapes)
    document = ezdxf.new(VERSION, units=UNIT_NUMBERS[frame.unit])
    space = document.modelspace()
    for curve in curves:
        layer = UNFIT.sub("_", curve.name).strip()[:LONGEST_NAME] or DEFAULT_LAYER
        if layer not in document.layers:
            document.layers.add(layer)
        flags = CLOSED * curve.closed + RATIONAL * (curve.weights is not None)
        spline = space.add_spline(degree=curve.degree, dxfattribs={"layer": layer, "flags": flags})
        spline.control_points = curve.control_points.tolist()
        spline.knots = curve.knots.tolist()
        if curve.weights is not None:
            spline.weights = curve.weights.tolist()
        if curve.color is not None:
            spline.rgb = curve.color
    text = io.StringIO()
    document.write(text)
    encoded: bytes = document.encode(text.getvalue())
    return encoded
