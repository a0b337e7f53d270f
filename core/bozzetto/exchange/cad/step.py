"""STEP (ISO 10303-214, "automotive design"): exact surfaces and curves for CAD, in millimetres.

The file holds one product. Its shape is a set of shells, whose faces are bicubic patches that
share their edges, and a set of B-spline curves, where there are such. Every number is written
with all its digits, so a reader gets the very control points, knots and weights.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.cad.cad_curves import RESOLUTION, checked_curves
from bozzetto.exchange.cad.cad_surfaces import CUBIC_KNOTS, checked_patchworks, names_of_patches
from bozzetto.exchange.cad.step_text import Part21, many, real, string
from bozzetto.geometry.patches.coons import edge_numbers
from bozzetto.geometry.patches.patchwork import Patchwork
from bozzetto.geometry.shapes import Color, Curve, Shapes

SCHEMA: Final = "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }"

LINE_WIDTH: Final = 0.25
"""Width in which coloured curves are drawn, mm; the style asks for some."""


def write_shapes(shapes: Shapes) -> bytes:
    """Write the patchworks and curves as STEP, with names and colours.

    Raises
    ------
    UserError
        As `checked_patchworks` and `checked_curves`.
    """
    patchworks = checked_patchworks(shapes)
    curves = checked_curves(shapes) if shapes.curves or not patchworks else ()
    title = patchworks[0].name if len(patchworks) == 1 else "Surfaces" if patchworks else "Curves"
    file = Part21()
    product = _product(file, title)
    context = _millimetres(file)
    frame = _frame(file)
    painted: list[tuple[str, Color | None, bool]] = []
    if patchworks:
        models = []
        for patchwork in patchworks:
            faces = _faces(file, patchwork)
            models.append(_shells(file, patchwork, faces))
            painted += [(face, patchwork.color, True) for face in faces]
        shape = file.add(
            "MANIFOLD_SURFACE_SHAPE_REPRESENTATION("
            f"{string(title)},{many([frame, *models])},{context})"
        )
        file.add(f"SHAPE_DEFINITION_REPRESENTATION({product},{shape})")
    if curves:
        items = [_curve(file, curve) for curve in curves]
        together = file.add(f"GEOMETRIC_CURVE_SET('Curves',{many(items)})")
        shape = file.add(
            "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION("
            f"'Curves',{many([frame, together])},{context})"
        )
        file.add(f"SHAPE_DEFINITION_REPRESENTATION({product},{shape})")
        painted += [(item, c.color, False) for item, c in zip(items, curves, strict=True)]
    _paint(file, painted, context)
    return file.encoded(SCHEMA, title)


def _product(file: Part21, name: str) -> str:
    """Add a product, down to the definition of its shape."""
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
    """Add the context of the geometry: three dimensions, millimetres, radians."""
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
    """Add the axes of the world."""
    origin = file.add("CARTESIAN_POINT('',(0.,0.,0.))")
    up = file.add("DIRECTION('',(0.,0.,1.))")
    right = file.add("DIRECTION('',(1.,0.,0.))")
    return file.add(f"AXIS2_PLACEMENT_3D('',{origin},{up},{right})")


def _curve(file: Part21, curve: Curve) -> str:
    """Add a curve with its control points (ISO 10303-42, b_spline_curve_with_knots)."""
    points = [_point(file, point) for point in curve.control_points.tolist()]
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


def _faces(file: Part21, patchwork: Patchwork) -> list[str]:
    """Add patches as faces; both at an edge name the same edge curve, in opposite senses."""
    places, ends = patchwork.nodes
    corners = [file.add(f"VERTEX_POINT('',{_point(file, place)})") for place in places.tolist()]
    edges = []
    for points, (start, end) in zip(patchwork.edges, ends.tolist(), strict=True):
        curve = _curve(file, Curve(3, CUBIC_KNOTS, points, name=""))
        edges.append(file.add(f"EDGE_CURVE('',{corners[start]},{corners[end]},{curve},.T.)"))
    names = names_of_patches(patchwork)
    return [
        _face(file, net, edges, sides, string(name))
        for net, sides, name in zip(patchwork.nets, patchwork.sides.tolist(), names, strict=True)
    ]


def _shells(file: Part21, patchwork: Patchwork, faces: list[str]) -> str:
    """Add a surface model with one shell for every piece of a patchwork."""
    shells = []
    for piece in patchwork.pieces:
        is_open = np.isin(edge_numbers(patchwork.sides[piece]), patchwork.rim).any()
        kind = "OPEN_SHELL" if is_open else "CLOSED_SHELL"
        shells.append(file.add(f"{kind}('',{many(faces[patch] for patch in piece)})"))
    return file.add(f"SHELL_BASED_SURFACE_MODEL({string(patchwork.name)},{many(shells)})")


def _face(file: Part21, net: Array, edges: list[str], sides: list[int], name: str) -> str:
    """Add one patch within its edges (ISO 10303-42, b_spline_surface_with_knots)."""
    rows = many(many(_point(file, point) for point in row) for row in net.tolist())
    surface = file.add(
        f"B_SPLINE_SURFACE_WITH_KNOTS({name},3,3,{rows},.UNSPECIFIED.,.F.,.F.,.U.,"
        "(4,4),(4,4),(0.,1.),(0.,1.),.UNSPECIFIED.)"
    )
    run = [(edges[side], ".T.") if side >= 0 else (edges[~side], ".F.") for side in sides]
    ring = many(file.add(f"ORIENTED_EDGE('',*,*,{edge},{sense})") for edge, sense in run)
    loop = file.add(f"EDGE_LOOP('',{ring})")
    bound = file.add(f"FACE_OUTER_BOUND('',{loop},.T.)")
    return file.add(f"ADVANCED_FACE({name},({bound}),{surface},.T.)")


def _point(file: Part21, place: Iterable[float]) -> str:
    return file.add(f"CARTESIAN_POINT('',{many(map(real, place))})")


def _paint(file: Part21, items: list[tuple[str, Color | None, bool]], context: str) -> None:
    """Give items their colours; a style is written once.

    Parameters
    ----------
    file : Part21
        The file to add to.
    items : list of (str, color, bool)
        Each with whether it is a surface.
    context : str
        The context of the geometry.
    """
    styles: dict[tuple[Color, bool], str] = {}
    styled: list[str] = []
    for item, color, is_surface in items:
        if color is None:
            continue
        if (color, is_surface) not in styles:
            shade = ",".join(real(value / 255) for value in color)
            tint = file.add(f"COLOUR_RGB('',{shade})")
            style = (_surface_style if is_surface else _curve_style)(file, tint)
            styles[color, is_surface] = file.add(f"PRESENTATION_STYLE_ASSIGNMENT(({style}))")
        styled.append(file.add(f"STYLED_ITEM('color',({styles[color, is_surface]}),{item})"))
    if styled:
        file.add(
            f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{many(styled)},{context})"
        )


def _curve_style(file: Part21, tint: str) -> str:
    font = file.add("DRAUGHTING_PRE_DEFINED_CURVE_FONT('continuous')")
    return file.add(f"CURVE_STYLE('',{font},POSITIVE_LENGTH_MEASURE({real(LINE_WIDTH)}),{tint})")


def _surface_style(file: Part21, tint: str) -> str:
    filling = file.add(f"FILL_AREA_STYLE_COLOUR('',{tint})")
    area = file.add(f"FILL_AREA_STYLE('',({filling}))")
    fill = file.add(f"SURFACE_STYLE_FILL_AREA({area})")
    side = file.add(f"SURFACE_SIDE_STYLE('',({fill}))")
    return file.add(f"SURFACE_STYLE_USAGE(.BOTH.,{side})")
