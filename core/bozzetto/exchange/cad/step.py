"""STEP (ISO 10303-214, "automotive design"): exact surfaces and curves for CAD, in millimetres.

The file holds one product. Its shape is a set of solids and open shells, whose faces share their
edges, and a set of B-spline curves, where there are such. Surfaces are rational B-splines, planes
and straight edges are written as such. Every number is written with all its digits, so a reader
gets the very control points, knots and weights.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.exchange.cad.bodies import bodies_of
from bozzetto.exchange.cad.cad_curves import RESOLUTION, checked_curves
from bozzetto.exchange.cad.cad_surfaces import checked_breps, is_line
from bozzetto.exchange.cad.step_text import Part21, many, real, string
from bozzetto.geometry.brep.brep import Brep, Face
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.shapes import Color, Curve, Shapes

SCHEMA: Final = "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }"

LINE_WIDTH: Final = 0.25
"""Width in which coloured curves are drawn, mm; the style asks for some."""


def write_shapes(shapes: Shapes) -> bytes:
    """Write the exact surfaces and curves as STEP, with names and colours.

    Raises
    ------
    UserError
        As `checked_breps` and `checked_curves`.
    """
    breps = checked_breps(shapes)
    curves = checked_curves(shapes) if shapes.curves or not breps else ()
    title = breps[0].name if len(breps) == 1 else "Surfaces" if breps else "Curves"
    file = Part21()
    product = _product(file, title)
    context = _millimetres(file)
    frame = _frame(file)
    painted: list[tuple[str, Color | None, bool]] = []
    bodies: list[str] = []
    sheets: list[str] = []
    for brep in breps:
        faces = _faces(file, brep)
        solids, models = _shells(file, brep, faces)
        bodies += solids
        sheets += models
        painted += [
            (face, made.color or brep.color, True)
            for face, made in zip(faces, brep.faces, strict=True)
        ]
    for kind, items in (("ADVANCED_BREP", bodies), ("MANIFOLD_SURFACE", sheets)):
        if items:
            shape = file.add(
                f"{kind}_SHAPE_REPRESENTATION({string(title)},{many([frame, *items])},{context})"
            )
            file.add(f"SHAPE_DEFINITION_REPRESENTATION({product},{shape})")
    if curves:
        lines = [_curve(file, curve) for curve in curves]
        together = file.add(f"GEOMETRIC_CURVE_SET('Curves',{many(lines)})")
        shape = file.add(
            "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION("
            f"'Curves',{many([frame, together])},{context})"
        )
        file.add(f"SHAPE_DEFINITION_REPRESENTATION({product},{shape})")
        painted += [(line, c.color, False) for line, c in zip(lines, curves, strict=True)]
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


def _faces(file: Part21, brep: Brep) -> list[str]:
    """Add faces; both at an edge name the same edge curve, in opposite senses."""
    places, ends, _ = brep.vertices
    corners = [file.add(f"VERTEX_POINT('',{_point(file, place)})") for place in places.tolist()]
    edges = []
    for edge, (start, end) in zip(brep.edges, ends.tolist(), strict=True):
        curve = _line(file, edge) if is_line(edge) else _curve(file, replace(edge, name=""))
        edges.append(file.add(f"EDGE_CURVE('',{corners[start]},{corners[end]},{curve},.T.)"))
    return [_face(file, face, edges, string(face.name or brep.name)) for face in brep.faces]


def _shells(file: Part21, brep: Brep, faces: list[str]) -> tuple[list[str], list[str]]:
    """Add a shell for every piece of a brep; return the solids, and the models of open shells."""
    name = string(brep.name)

    def shell(kind: str, piece: Index) -> str:
        return file.add(f"{kind}('',{many(faces[number] for number in piece)})")

    bodies = bodies_of(brep)
    solids = []
    for outer, hollows in bodies.solids:
        whole = shell("CLOSED_SHELL", outer)
        inner = [
            file.add(f"ORIENTED_CLOSED_SHELL('',*,{shell('CLOSED_SHELL', hollow)},.T.)")
            for hollow in hollows
        ]
        solids.append(
            file.add(
                f"BREP_WITH_VOIDS({name},{whole},{many(inner)})"
                if inner
                else f"MANIFOLD_SOLID_BREP({name},{whole})"
            )
        )
    sheets = [shell("OPEN_SHELL", piece) for piece in bodies.sheets]
    models = [file.add(f"SHELL_BASED_SURFACE_MODEL({name},{many(sheets)})")] if sheets else []
    return solids, models


def _face(file: Part21, face: Face, edges: list[str], name: str) -> str:
    """Add a surface within its edges; a pole is where its neighbours in the loop meet."""
    bounds = []
    for number, loop in enumerate(face.loops):
        run = [(edges[t.edge], ".T." if t.forward else ".F.") for t in loop if t.edge is not None]
        ring = many(file.add(f"ORIENTED_EDGE('',*,*,{edge},{sense})") for edge, sense in run)
        kind = "FACE_BOUND" if number else "FACE_OUTER_BOUND"
        rim = file.add(f"EDGE_LOOP('',{ring})")
        bounds.append(file.add(f"{kind}('',{rim},.T.)"))
    surface = (_plane if face.surface.is_plane else _surface)(file, face.surface, name)
    return file.add(f"ADVANCED_FACE({name},{many(bounds)},{surface},.T.)")


def _surface(file: Part21, surface: BSplineSurface, name: str) -> str:
    """Add a surface (ISO 10303-42, b_spline_surface_with_knots)."""
    net = surface.control_points.tolist()
    rows = many(many(_point(file, point) for point in row) for row in net)
    knots, times = zip(*(np.unique(k, return_counts=True) for k in surface.knots), strict=True)
    shape = f"{surface.degrees[0]},{surface.degrees[1]},{rows},.UNSPECIFIED.,.F.,.F.,.U."
    counts = ",".join(many(map(str, row.tolist())) for row in times)
    places = ",".join(many(map(real, row.tolist())) for row in knots)
    if surface.weights is None:
        return file.add(
            f"B_SPLINE_SURFACE_WITH_KNOTS({name},{shape},{counts},{places},.UNSPECIFIED.)"
        )
    weights = many(many(map(real, row)) for row in surface.weights.tolist())
    return file.add(
        f"(BOUNDED_SURFACE()B_SPLINE_SURFACE({shape})"
        f"B_SPLINE_SURFACE_WITH_KNOTS({counts},{places},.UNSPECIFIED.)"
        f"GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE({weights})"
        f"REPRESENTATION_ITEM({name})SURFACE())"
    )


def _plane(file: Part21, surface: BSplineSurface, name: str) -> str:
    """Add the plane of a parallelogram; its normal is that of the surface."""
    corner, along_v, along_u = surface.control_points[[0, 0, 1], [0, 1, 0]]
    normal = np.cross(along_u - corner, along_v - corner)
    up, right = (_direction(file, vector) for vector in (normal, along_u - corner))
    place = file.add(f"AXIS2_PLACEMENT_3D('',{_point(file, corner.tolist())},{up},{right})")
    return file.add(f"PLANE({name},{place})")


def _line(file: Part21, edge: Curve) -> str:
    """Add the line of a straight edge, from its start and as long as it is."""
    start, end = edge.control_points
    along = _direction(file, end - start)
    vector = file.add(f"VECTOR('',{along},{real(float(np.linalg.norm(end - start)))})")
    return file.add(f"LINE('',{_point(file, start.tolist())},{vector})")


def _direction(file: Part21, vector: Array) -> str:
    unit = vector / np.linalg.norm(vector)
    return file.add(f"DIRECTION('',{many(map(real, unit.tolist()))})")


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
