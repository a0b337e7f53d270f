"""STEP (ISO 10303-214, "automotive design"): exact curves for CAD, in millimetres.

The file holds one product whose shape is a set of B-spline curves. Every number is written
with all its digits, so a reader gets the very control points, knots and weights.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.exchange.curve_pieces import RESOLUTION, checked_curves
from bozzetto.exchange.part21 import Part21, many, real, string
from bozzetto.geometry.shapes import Color, Curve, Shapes

__all__ = ["write_shapes"]

SCHEMA: Final = "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }"

TITLE: Final = "Curves"

LINE_WIDTH: Final = 0.25
"""Width in which coloured curves are drawn, mm; the style asks for some."""


def write_shapes(shapes: Shapes) -> bytes:
    """A STEP file of the curves, with names and colours.

    Raises
    ------
    UserError
        As `checked_curves`.
    """
    curves = checked_curves(shapes)
    file = Part21()
    product = _product(file, TITLE)
    context = _millimetres(file)
    items = [_curve(file, curve) for curve in curves]
    together = file.add(f"GEOMETRIC_CURVE_SET({string(TITLE)},{many(items)})")
    shape = file.add(
        "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION("
        f"{string(TITLE)},{many([_frame(file), together])},{context})"
    )
    file.add(f"SHAPE_DEFINITION_REPRESENTATION({product},{shape})")
    _paint(file, [(item, c.color) for item, c in zip(items, curves, strict=True)], context)
    return file.encoded(SCHEMA, TITLE)


def _product(file: Part21, name: str) -> str:
    """A product, down to the definition of its shape."""
    label = string(name)
    application = file.add(
        "APPLICATION_CONTEXT('core data for automotive mechanical design processes')"
    )
    file.add(
        "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2000,"
        f"{application})"
    )
    context = file.add(f"PRODUCT_CONTEXT('',{application},'mechanical')")
    product = file.add(f"PRODUCT({label},{label},'',({context}))")
    file.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,({product}))")
    formation = file.add(f"PRODUCT_DEFINITION_FORMATION('','',{product})")
    stage = file.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')")
    definition = file.add(f"PRODUCT_DEFINITION('design','',{formation},{stage})")
    return file.add(f"PRODUCT_DEFINITION_SHAPE('','',{definition})")


def _millimetres(file: Part21) -> str:
    """The context of the geometry: three dimensions, millimetres, radians."""
    length = file.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
    angle = file.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
    solid_angle = file.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
    accuracy = file.add(
        f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({real(RESOLUTION)}),{length},"
        "'distance_accuracy_value','points nearer than this are one')"
    )
    return file.add(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)"
        f"GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({accuracy}))"
        f"GLOBAL_UNIT_ASSIGNED_CONTEXT({many([length, angle, solid_angle])})"
        "REPRESENTATION_CONTEXT('','3D'))"
    )


def _frame(file: Part21) -> str:
    """The axes of the world."""
    origin = file.add("CARTESIAN_POINT('',(0.,0.,0.))")
    up = file.add("DIRECTION('',(0.,0.,1.))")
    right = file.add("DIRECTION('',(1.,0.,0.))")
    return file.add(f"AXIS2_PLACEMENT_3D('',{origin},{up},{right})")


def _curve(file: Part21, curve: Curve) -> str:
    """One curve with its control points (ISO 10303-42, b_spline_curve_with_knots)."""
    points = [
        file.add(f"CARTESIAN_POINT('',{many(map(real, point))})")
        for point in curve.control_points.tolist()
    ]
    name = string(curve.name)
    closed = ".T." if curve.closed else ".F."
    shape = f"{curve.degree},{many(points)},.UNSPECIFIED.,{closed},.U."
    places, times = np.unique(curve.knots, return_counts=True)
    knots = f"{many(map(str, times.tolist()))},{many(map(real, places.tolist()))},.UNSPECIFIED."
    if curve.weights is None:
        return file.add(f"B_SPLINE_CURVE_WITH_KNOTS({name},{shape},{knots})")
    return file.add(
        f"(BOUNDED_CURVE()B_SPLINE_CURVE({shape})B_SPLINE_CURVE_WITH_KNOTS({knots})CURVE()"
        "GEOMETRIC_REPRESENTATION_ITEM()"
        f"RATIONAL_B_SPLINE_CURVE({many(map(real, curve.weights.tolist()))})"
        f"REPRESENTATION_ITEM({name}))"
    )


def _paint(file: Part21, items: list[tuple[str, Color | None]], context: str) -> None:
    """Give items their colours; a colour is written once."""
    styles: dict[Color, str] = {}
    styled: list[str] = []
    for item, color in items:
        if color is None:
            continue
        if color not in styles:
            shade = ",".join(real(value / 255) for value in color)
            tint = file.add(f"COLOUR_RGB('',{shade})")
            font = file.add("DRAUGHTING_PRE_DEFINED_CURVE_FONT('continuous')")
            width = f"POSITIVE_LENGTH_MEASURE({real(LINE_WIDTH)})"
            style = file.add(f"CURVE_STYLE('',{font},{width},{tint})")
            styles[color] = file.add(f"PRESENTATION_STYLE_ASSIGNMENT(({style}))")
        styled.append(file.add(f"STYLED_ITEM('color',({styles[color]}),{item})"))
    if styled:
        file.add(
            f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{many(styled)},{context})"
        )
