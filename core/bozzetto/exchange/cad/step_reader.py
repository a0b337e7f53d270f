"""STEP, read exactly: curves, and bodies of planes and whole B-spline surfaces.

Curves are those that a shape holds beside its faces: B-splines of any kind, polylines, lines,
circles and ellipses, parts of these, and rows of them, each where its product is placed. What has
another kind of face is read by Open CASCADE (`cad_reader`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.cad.curve_pieces import (
    CurveError,
    checked_curve,
    ellipse_arc,
    joined,
    part_of,
    polyline,
    repeated,
)
from bozzetto.exchange.cad.exact_shapes import ExactShapes
from bozzetto.exchange.cad.step_records import Instances, Record
from bozzetto.exchange.limits import MAX_DEPTH, MAX_PARTS, at_most
from bozzetto.geometry.brep.brep import Brep
from bozzetto.geometry.brep.planes import plane_face
from bozzetto.geometry.brep.sewing import same_curve, sewn
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Color, Curve

PREFIXES: Final = {
    "EXA": 1e18, "PETA": 1e15, "TERA": 1e12, "GIGA": 1e9, "MEGA": 1e6, "KILO": 1e3, "HECTO": 1e2,
    "DECA": 1e1, "DECI": 1e-1, "CENTI": 1e-2, "MILLI": 1e-3, "MICRO": 1e-6, "NANO": 1e-9,
    "PICO": 1e-12, "FEMTO": 1e-15, "ATTO": 1e-18,
}  # fmt: skip

SETS: Final = ("GEOMETRIC_CURVE_SET", "GEOMETRIC_SET")
WIRES: Final = (
    "EDGE_BASED_WIREFRAME_MODEL", "SHELL_BASED_WIREFRAME_MODEL", "CONNECTED_EDGE_SET",
    "WIRE_SHELL", "EDGE_LOOP", "PATH",
)  # fmt: skip
"""What holds edges that belong to no face."""

SPLINES: Final = (
    "B_SPLINE_CURVE_WITH_KNOTS", "BEZIER_CURVE", "UNIFORM_CURVE", "QUASI_UNIFORM_CURVE",
)  # fmt: skip

CURVES: Final = (
    *SPLINES, "B_SPLINE_CURVE", "POLYLINE", "LINE", "CIRCLE", "ELLIPSE", "TRIMMED_CURVE",
    "COMPOSITE_CURVE", "EDGE_CURVE", "ORIENTED_EDGE", "SURFACE_CURVE", "SEAM_CURVE",
    "INTERSECTION_CURVE", "PARABOLA", "HYPERBOLA", "OFFSET_CURVE_3D", "CURVE_REPLICA",
    "CLOTHOID", "COMPOSITE_CURVE_ON_SURFACE",
)  # fmt: skip

SHELLS: Final = ("CLOSED_SHELL", "OPEN_SHELL")

NAMED_COLORS: Final[dict[str, Color]] = {
    "red": (255, 0, 0), "green": (0, 255, 0), "blue": (0, 0, 255), "yellow": (255, 255, 0),
    "magenta": (255, 0, 255), "cyan": (0, 255, 255), "black": (0, 0, 0), "white": (255, 255, 255),
}  # fmt: skip

MOST_STYLES: Final = 64
"""Instances that are looked at for the colour of one style."""

LOOSE: Final = re.compile(rb"GEOMETRIC_(?:CURVE_)?SET|WIREFRAME", re.IGNORECASE)
"""What a file with faces must hold to have curves beside them."""

FACES: Final = re.compile(rb"(?:ADVANCED_FACE|FACE_SURFACE|TESSELLATED_\w+|_FACE_SET)\s*\(", re.I)
"""What a file must hold to have faces."""


def read_exactly(data: bytes, *, bodies: bool) -> ExactShapes:
    """Read what can be read exactly of a STEP file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    bodies : bool
        Whether bodies are wanted, too.

    Raises
    ------
    FormatError
        If a curve is damaged, or there is too much.
    """
    found = ExactShapes()
    loose = LOOSE.search(data) is not None or FACES.search(data) is None
    if not loose and not bodies:
        return found
    with np.errstate(all="ignore"):  # what is not finite is refused where it is a curve
        reader = _Step(Instances(data), found)
        if loose:
            reader.read_curves()
        if bodies:
            reader.read_bodies()
    return found


class _Step:
    """One file that is read."""

    def __init__(self, instances: Instances, found: ExactShapes) -> None:
        self._of, self._found = instances, found
        self._millimetres, self._radians = 1.0, 1.0
        self._colors: dict[int, Color] = {}
        for number in instances.of_kind("STYLED_ITEM", "OVER_RIDING_STYLED_ITEM"):
            record = instances.record(number, "STYLED_ITEM", "OVER_RIDING_STYLED_ITEM")
            values = [] if record is None else record.values
            color = self._color(values[1]) if len(values) > 2 else None
            if color is not None and isinstance(values[2], int):
                self._colors[values[2]] = color

    # -- shapes, their units and places --

    def read_curves(self) -> None:
        """Read the curves of all shapes, each wherever its shape is."""
        places = _Places(self._of)
        for number, values in self._representations():
            items = [item for item in values[1] if isinstance(item, int)]
            first = len(self._found.curves)
            self._set_units(values[2] if len(values) > 2 else None)
            for item in items:
                if self._of.record(item, *SETS, *WIRES) or self._of.record(item, *CURVES):
                    self._add(item, "", None)
            made = self._found.curves[first:]
            if not made:
                continue
            del self._found.curves[first:]
            for matrix in places.of(number, self._length_of):
                for curve in made:
                    self._found.add(_moved(curve, matrix))

    def read_bodies(self) -> None:
        """Read shells whose faces are planes or whole surfaces."""
        self._set_units(next(iter(self._of.of_kind("GLOBAL_UNIT_ASSIGNED_CONTEXT")), None))
        named: dict[int, str] = {}
        for number in self._of.of_kind("MANIFOLD_SOLID_BREP", "SHELL_BASED_SURFACE_MODEL"):
            for one in self._of.records(number):
                values = one.values
                if len(values) > 1:
                    shells = values[1] if isinstance(values[1], list) else [values[1]]
                    named |= {s: str(values[0] or "") for s in shells if isinstance(s, int)}
        for number in self._of.of_kind(*SHELLS):
            self._found.count()
            record = self._of.record(number, *SHELLS)
            faces = record.values[1] if record is not None and len(record.values) > 1 else None
            try:
                made = [self._face(face) for face in faces or ()]
                whole = sewn(made, named.get(number) or "") if made else None
            except (UserError, ArithmeticError, IndexError, TypeError, ValueError):
                whole = None
            if whole is None:
                self._found.other_bodies += 1
            else:
                self._found.bodies.append(whole)

    def _representations(self) -> Iterator[tuple[int, list[Any]]]:
        """Yield shapes: name, items and context."""
        for number in self._of.of_kind(*REPRESENTATIONS):
            for record in self._of.records(number):
                if len(record.values) > 1 and isinstance(record.values[1], list):
                    yield number, record.values
                    break

    def _set_units(self, context: Any) -> None:
        self._millimetres, self._radians = 1.0, 1.0
        units = self._of.record(context, "GLOBAL_UNIT_ASSIGNED_CONTEXT")
        for unit in units.values[0] if units is not None and units.values else ():
            kinds = {record.kind for record in self._of.records(unit)}
            if "LENGTH_UNIT" in kinds:
                self._millimetres = 1000.0 * self._size(unit)
            elif "PLANE_ANGLE_UNIT" in kinds:
                self._radians = self._size(unit)

    def _length_of(self, context: Any) -> float:
        """Return the millimetres in a unit of a context."""
        before = self._millimetres, self._radians
        self._set_units(context)
        found, (self._millimetres, self._radians) = self._millimetres, before
        return found

    def _size(self, unit: Any) -> float:
        """Return the size of a unit in metres or radians."""
        size = 1.0
        for _ in range(MAX_DEPTH):
            plain = self._of.record(unit, "SI_UNIT")
            if plain is not None:
                size *= PREFIXES.get(str(plain.values[0]), 1.0) if plain.values else 1.0
                break
            other = self._of.record(unit, "CONVERSION_BASED_UNIT")
            measure = None if other is None or len(other.values) < 2 else other.values[1]
            found = next(iter(self._of.records(measure)), None)
            if found is None or len(found.values) < 2 or not isinstance(found.values[0], Record):
                break
            number = found.values[0].values[:1]
            size *= float(number[0]) if number and isinstance(number[0], float) else 1.0
            unit = found.values[1]
        if not (math.isfinite(size) and size > 0.0):
            raise FormatError("A unit of this file has no size.")
        return size

    def _color(self, styles: Any) -> Color | None:
        """Return the first colour that styles name, or what they name."""
        waiting, seen = [styles], 0
        while waiting and seen < MOST_STYLES:
            one = waiting.pop(0)
            seen += 1
            if isinstance(one, list):
                waiting += one
                continue
            if isinstance(one, Record):
                waiting += one.values
                continue
            if isinstance(one, str) or not isinstance(one, int):
                continue
            for record in self._of.records(one):
                if record.kind == "COLOUR_RGB" and len(record.values) > 3:
                    shades = record.values[1:4]
                    if all(isinstance(shade, float) and shade == shade for shade in shades):
                        r, g, b = (round(255 * min(max(shade, 0.0), 1.0)) for shade in shades)
                        return r, g, b
                name = record.values[0] if record.values else None
                if record.kind == "DRAUGHTING_PRE_DEFINED_COLOUR" and name in NAMED_COLORS:
                    return NAMED_COLORS[name]
                waiting += record.values
        return None

    # -- curves --

    def _add(self, item: int, name: str, color: Color | None) -> None:
        """Add what a set holds, sets in sets taken apart."""
        waiting: list[tuple[Any, str, Color | None]] = [(item, name, color)]
        sets: set[int] = set()
        while waiting:
            number, called, tint = waiting.pop()
            self._found.count()
            tint = self._colors.get(number, tint)
            holder = self._of.record(number, *SETS, *WIRES)
            if holder is not None:
                own = self._name(number) or called
                inside = holder.values[1] if len(holder.values) > 1 else None
                rows = inside if isinstance(inside, list) else [inside]
                if number not in sets:  # one that holds itself holds nothing more
                    sets.add(number)
                    waiting += [(one, own, tint) for one in rows[::-1] if isinstance(one, int)]
                continue
            if not any(record.kind in CURVES for record in self._of.records(number)):
                continue
            try:
                made = self._curves(number, 0)
            except CurveError:
                self._found.other_curves["damaged curve"] += 1
                continue
            title = self._name(number) or called or "Curve"
            for curve in made:
                self._found.add(replace(curve, name=title, color=tint))

    def _name(self, number: Any) -> str:
        records = self._of.records(number)
        named = next((one for one in records if one.kind == "REPRESENTATION_ITEM"), None)
        if named is None and len(records) == 1:
            named = records[0]
        text = named.values[0] if named is not None and named.values else ""
        text = text[:200] if isinstance(text, str) else ""
        return "".join(sign for sign in text if sign.isprintable()).strip()

    def _curves(self, number: Any, depth: int) -> tuple[Curve, ...]:
        """Return a curve; several where its pieces do not meet, none where it is not read."""
        self._found.count()
        at_most(depth, MAX_DEPTH, "levels of curves")
        records = self._of.records(number)
        kinds = {record.kind: record.values for record in records}
        try:
            if "B_SPLINE_CURVE" in kinds or not kinds.keys().isdisjoint(SPLINES):
                return (self._spline(kinds),)
            kind, values = next(((k, v) for k, v in kinds.items() if k in CURVES), ("", []))
            match kind:
                case "POLYLINE":
                    points = [self._point(one) for one in values[1]]
                    return (polyline(points),)
                case "TRIMMED_CURVE":
                    return self._trimmed(values, depth)
                case "COMPOSITE_CURVE" | "COMPOSITE_CURVE_ON_SURFACE":
                    return self._composite(values[1], depth)
                case "CIRCLE" | "ELLIPSE":
                    return (ellipse_arc(*self._conic(kind, values), 0.0, 2.0 * math.pi),)
                case "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE":
                    return self._curves(values[1], depth + 1)
                case "EDGE_CURVE":
                    return self._edge(values, depth)
                case "ORIENTED_EDGE":
                    inside = self._curves(values[3], depth + 1)
                    return inside if values[4] == "T" else _backwards(inside)
        except (ArithmeticError, IndexError, TypeError, ValueError) as problem:
            raise CurveError("A curve of this file is damaged. Save it again.") from problem
        what = "a line without an end" if kind == "LINE" else kind.lower().replace("_", " ")
        self._found.other_curves[what] += 1
        return ()

    def _spline(self, kinds: dict[str, list[Any]]) -> Curve:
        """Return a B-spline of one record or of several."""
        kind = next((k for k in SPLINES if k in kinds), "QUASI_UNIFORM_CURVE")
        if "B_SPLINE_CURVE" in kinds:
            shape, own = kinds["B_SPLINE_CURVE"], kinds.get(kind, [])
        else:
            shape, own = kinds[kind][1:6], kinds[kind][6:]
        degree = int(shape[0])
        points = np.array([self._point(one) for one in shape[1]])
        if not 1 <= degree < len(points):
            raise ValueError("a degree beyond the points")
        knots = _knots(kind, degree, len(points), own)
        weights = kinds.get("RATIONAL_B_SPLINE_CURVE", [None])[0]
        return checked_curve(degree, knots, points, weights, closed=shape[3] == "T")

    def _trimmed(self, values: list[Any], depth: int) -> tuple[Curve, ...]:
        """Return a part of a curve (ISO 10303-42, trimmed_curve)."""
        basis, trims, forward = values[1], values[2:4], values[4] == "T"
        if not forward:
            trims = trims[::-1]
        record = self._of.record(basis, "LINE", "CIRCLE", "ELLIPSE")
        by_place = values[5] == "CARTESIAN"
        if record is None:
            inside = self._curves(basis, depth + 1)
            if len(inside) == 1:
                low, high = inside[0].range
                ends = [_parameter(trim) for trim in trims]
                inside = (
                    part_of(
                        inside[0],
                        low if ends[0] is None else ends[0],
                        high if ends[1] is None else ends[1],
                    ),
                )
        elif record.kind == "LINE":
            start, along = self._line(record)
            cuts = [self._trim(trim, by_place) for trim in trims]
            inside = (polyline([start + c * along if isinstance(c, float) else c for c in cuts]),)
        else:
            center, first, second = self._conic(record.kind, record.values)
            angles = []
            for trim in trims:
                end = self._trim(trim, by_place)
                angles.append(
                    end * self._radians
                    if isinstance(end, float)
                    else _angle(end - center, first, second)
                )
            inside = (ellipse_arc(center, first, second, angles[0], _after(*angles)),)
        return inside if forward else _backwards(inside)

    def _trim(self, trim: Any, by_place: bool) -> float | Array:
        """Return where a curve is cut: a parameter or a place."""
        place = next((one for one in trim if isinstance(one, int)), None)
        number = _parameter(trim)
        if place is not None and (by_place or number is None):
            return self._point(place)
        if number is None:
            raise ValueError("a cut without a place")
        return number

    def _composite(self, segments: Any, depth: int) -> tuple[Curve, ...]:
        pieces: list[Curve] = []
        for one in segments:
            values = self._of.records(one)[0].values
            inside = self._curves(values[2], depth + 1)
            pieces += inside if values[1] == "T" else _backwards(inside)
        return joined(pieces)

    def _edge(self, values: list[Any], depth: int) -> tuple[Curve, ...]:
        """Return the part of a curve between two vertices."""
        start, end = (self._vertex(one) for one in values[1:3])
        basis, forward = values[3], values[4] == "T"
        record = self._of.record(basis, "LINE", "CIRCLE", "ELLIPSE")
        if record is None:
            inside = self._curves(basis, depth + 1)
            if len(inside) == 1 and not values[1] == values[2]:
                inside = (_between(inside[0], *((start, end) if forward else (end, start))),)
            return inside if forward else _backwards(inside)
        if record.kind == "LINE":
            return (polyline((start, end)),)
        if not forward:
            start, end = end, start
        center, first, second = self._conic(record.kind, record.values)
        begin = _angle(start - center, first, second)
        last = _after(begin, _angle(end - center, first, second))
        if values[1] == values[2]:
            last = begin + 2.0 * math.pi
        inside = (ellipse_arc(center, first, second, begin, last),)
        return inside if forward else _backwards(inside)

    # -- places --

    def _point(self, number: Any) -> Array:
        found = self._of.point(number)
        if found is None:
            raise CurveError("A point of this file is not there. Save it again.")
        return self._millimetres * np.array([*found, 0.0, 0.0][:3], float)

    def _vertex(self, number: Any) -> Array:
        record = self._of.record(number, "VERTEX_POINT")
        return self._point(None if record is None else record.values[1])

    def _line(self, record: Record) -> tuple[Array, Array]:
        vector = self._of.record(record.values[2], "VECTOR")
        if vector is None:
            raise CurveError("A line of this file has no direction. Save it again.")
        along = _unit(_direction(self._of, vector.values[1]))
        return self._point(record.values[1]), self._millimetres * vector.values[2] * along

    def _conic(self, kind: str, values: list[Any]) -> tuple[Array, Array, Array]:
        """Return the centre of an ellipse, and its half axes, mm."""
        origin, x, y, _ = _axes(self._of, values[1])
        radii = values[2:4] if kind == "ELLIPSE" else (values[2], values[2])
        mm = self._millimetres
        return mm * origin, mm * radii[0] * x, mm * radii[1] * y

    # -- faces --

    def _face(self, number: Any) -> Brep:
        """Return a face: a plane within curves, or a whole surface.

        Raises
        ------
        FormatError
            If it is another one.
        """
        self._found.count()
        face = self._of.record(number, "ADVANCED_FACE", "FACE_SURFACE")
        if face is None:
            raise CurveError("This kind of face is not read.")
        name, bounds, surface, sense = face.values[:4]
        color = self._colors.get(number) or self._colors.get(surface)
        rings = [self._ring(bound) for bound in bounds]
        plane = self._of.record(surface, "PLANE")
        if plane is not None:
            _, _, _, normal = _axes(self._of, plane.values[1])
            sign = 1.0 if sense == "T" else -1.0
            made = plane_face(rings, normal=sign * normal)
        else:
            made = _whole(self._surface(surface), [edge for ring in rings for edge in ring])
            if sense != "T":
                made = made.turned_over()
        whole = replace(made.faces[0], name=str(name or ""), color=color)
        return replace(made, faces=(whole,))

    def _ring(self, number: Any) -> list[Curve]:
        bound = self._of.record(number, "FACE_OUTER_BOUND", "FACE_BOUND")
        loop = None if bound is None else self._of.record(bound.values[1], "EDGE_LOOP")
        if bound is None or loop is None:
            raise CurveError("This kind of border is not read.")
        edges = [curve for edge in loop.values[1] for curve in self._curves(edge, 0)]
        edges = [_as_straight(edge) for edge in edges]
        return edges if bound.values[2] == "T" else list(_backwards(tuple(edges)))

    def _surface(self, number: Any) -> BSplineSurface:
        kinds = {record.kind: record.values for record in self._of.records(number)}
        shape = kinds.get("B_SPLINE_SURFACE")
        own = kinds.get("B_SPLINE_SURFACE_WITH_KNOTS")
        if own is None:
            raise CurveError("This kind of surface is not read.")
        if shape is None:
            shape, own = own[1:8], own[8:]
        degrees = int(shape[0]), int(shape[1])
        net = np.array([[self._point(one) for one in row] for row in shape[2]])
        counts = [side + degree + 1 for side, degree in zip(net.shape, degrees, strict=False)]
        knots = [repeated(own[k + 2], own[k], counts[k]) for k in (0, 1)]
        weights = kinds.get("RATIONAL_B_SPLINE_SURFACE", [None])[0]
        share = None if weights is None else np.array(weights, float)
        return BSplineSurface(degrees, knots[0], knots[1], net, share)


REPRESENTATIONS: Final = (
    "SHAPE_REPRESENTATION", "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION",
    "EDGE_BASED_WIREFRAME_SHAPE_REPRESENTATION", "SHELL_BASED_WIREFRAME_SHAPE_REPRESENTATION",
    "GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION", "ADVANCED_BREP_SHAPE_REPRESENTATION",
    "MANIFOLD_SURFACE_SHAPE_REPRESENTATION", "CONSTRUCTIVE_GEOMETRY_REPRESENTATION",
    "FACETED_BREP_SHAPE_REPRESENTATION",
)  # fmt: skip
"""What holds the geometry of a product."""


class _Places:
    """Where shapes are, as those that hold them place them."""

    def __init__(self, instances: Instances) -> None:
        self._of = instances
        self._same: dict[int, list[int]] = {}
        self._held: dict[int, list[tuple[int, Any, Any]]] = {}
        for number in instances.of_kind(
            "SHAPE_REPRESENTATION_RELATIONSHIP", "REPRESENTATION_RELATIONSHIP"
        ):
            records = {one.kind: one.values for one in instances.records(number)}
            relation = records.get("REPRESENTATION_RELATIONSHIP") or records.get(
                "SHAPE_REPRESENTATION_RELATIONSHIP", []
            )
            if len(relation) < 4 or not all(isinstance(one, int) for one in relation[2:4]):
                continue
            one, two = relation[2:4]
            turn = records.get("REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION", [None])[:1]
            move = instances.record(turn[0] if turn else None, "ITEM_DEFINED_TRANSFORMATION")
            if move is not None and len(move.values) > 3:
                self._held.setdefault(one, []).append((two, move.values[2], move.values[3]))
            elif not turn or turn[0] is None:
                self._same.setdefault(one, []).append(two)
                self._same.setdefault(two, []).append(one)
        self._map()

    def _map(self) -> None:
        """Note the shapes that are placed as items of others."""
        of = self._of
        maps: dict[int, tuple[int, Any]] = {}
        for number in of.of_kind("REPRESENTATION_MAP"):
            record = of.record(number, "REPRESENTATION_MAP")
            if record is not None and len(record.values) > 1 and isinstance(record.values[1], int):
                maps[number] = record.values[1], record.values[0]
        if not maps:
            return
        for number in of.of_kind(*REPRESENTATIONS):
            for record in of.records(number):
                items = record.values[1] if len(record.values) > 1 else None
                for item in items if isinstance(items, list) else ():
                    mapped = of.record(item, "MAPPED_ITEM")
                    if mapped is not None and mapped.values[1] in maps:
                        inner, origin = maps[mapped.values[1]]
                        self._held.setdefault(inner, []).append((number, origin, mapped.values[2]))

    def of(self, number: int, length: Any) -> list[Array]:
        """Return the matrices, (4, 4), mm, that place a shape; one that moves nothing at least.

        Parameters
        ----------
        number : int
            The instance of the shape.
        length : callable
            Gives the millimetres in a unit of a context.
        """
        found: list[Array] = []
        waiting = [(number, np.eye(4), 0)]
        asked = 0
        while waiting:
            one, matrix, depth = waiting.pop()
            asked += 1
            at_most(asked, MAX_PARTS, "copies")
            at_most(depth, MAX_DEPTH, "levels of assemblies")
            group = self._class_of(one)
            holders = [(member, held) for member in group for held in self._held.get(member, ())]
            if not holders:
                found.append(matrix)
            for member, (holder, origin, target) in holders:
                inner = _frame(self._of, origin, length(self._context(member)))
                outer = _frame(self._of, target, length(self._context(holder)))
                waiting.append((holder, outer @ np.linalg.inv(inner) @ matrix, depth + 1))
        return found

    def _class_of(self, number: int) -> list[int]:
        """Return a shape and those that are the same."""
        group, waiting = {number}, [number]
        while waiting:
            for other in self._same.get(waiting.pop(), ()):
                if other not in group:
                    at_most(len(group), MAX_PARTS, "shapes")
                    group.add(other)
                    waiting.append(other)
        return sorted(group)

    def _context(self, number: int) -> Any:
        values = next((one.values for one in self._of.records(number)), [])
        return values[2] if len(values) > 2 else None


# -- plain helpers --


def _frame(of: Instances, number: Any, mm: float) -> Array:
    """Return the matrix (4, 4) of a placement."""
    origin, x, y, z = _axes(of, number)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack((x, y, z, mm * origin))
    return matrix


def _axes(of: Instances, number: Any) -> tuple[Array, Array, Array, Array]:
    """Return origin and axes of a placement (ISO 10303-42, build_axes)."""
    record = of.record(number, "AXIS2_PLACEMENT_3D", "AXIS2_PLACEMENT_2D", "AXIS1_PLACEMENT")
    if record is None:
        raise CurveError("A place of this file is not there. Save it again.")
    values = [*record.values, None, None]
    point = of.point(values[1]) or []
    origin = np.array([*point, 0.0, 0.0, 0.0][:3], float)
    flat = record.kind == "AXIS2_PLACEMENT_2D"
    z = None if flat or values[2] is None else _direction(of, values[2])
    aside = values[2] if flat else values[3]
    z = np.array([0.0, 0.0, 1.0]) if z is None else _unit(z)
    if aside is None or record.kind == "AXIS1_PLACEMENT":
        x = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 1.0 else np.array([0.0, 0.0, 1.0])
    else:
        x = _direction(of, aside)
    x = _unit(x - (x @ z) * z)
    return origin, x, np.cross(z, x), z


def _direction(of: Instances, number: Any) -> Array:
    record = of.record(number, "DIRECTION")
    if record is None:
        raise CurveError("A direction of this file is not there. Save it again.")
    return np.array([*record.values[1], 0.0][:3], float)


def _unit(vector: Array) -> Array:
    length = float(np.linalg.norm(vector))
    if not (math.isfinite(length) and length > 0.0):
        raise CurveError("A direction of this file has no length. Save it again.")
    return vector if length == 1.0 else vector / length


def _moved(curve: Curve, matrix: Array) -> Curve:
    if (matrix == np.eye(4)).all():
        return curve
    places = curve.control_points @ matrix[:3, :3].T + matrix[:3, 3]
    return replace(curve, control_points=places)


def _backwards(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    return tuple(curve.reversed() for curve in reversed(curves))


def _parameter(trim: Any) -> float | None:
    """Return the parameter at which a curve is cut, where it is told."""
    for one in trim:
        if isinstance(one, Record) and one.values and isinstance(one.values[0], float):
            return one.values[0]
    return None


def _angle(offset: Array, first: Array, second: Array) -> float:
    """Return the parameter of a place on an ellipse round the origin."""
    return math.atan2(
        float(offset @ second) / float(second @ second),
        float(offset @ first) / float(first @ first),
    )


def _after(begin: float, end: float) -> float:
    """Return an angle as it comes after another one, within a turn."""
    turn = (end - begin) % (2.0 * math.pi)
    return begin + (turn if turn > 1e-9 else 2.0 * math.pi)


def _knots(kind: str, degree: int, count: int, own: list[Any]) -> Array:
    """Return the full knot vector of a B-spline of one of the kinds."""
    if kind == "B_SPLINE_CURVE_WITH_KNOTS":
        return repeated(own[1], own[0], count + degree + 1)
    if kind == "UNIFORM_CURVE":
        return np.arange(-degree, count + 1, dtype=float)
    inner = np.arange(1.0, (count - 1) / degree if kind == "BEZIER_CURVE" else count - degree)
    if kind == "BEZIER_CURVE":
        inner = np.repeat(inner, degree)
    last = (count - 1) / degree if kind == "BEZIER_CURVE" else count - degree
    return np.concatenate((np.zeros(degree + 1), inner, np.full(degree + 1, float(last))))


def _between(curve: Curve, start: Array, end: Array) -> Curve:
    """Return a curve between two places on it; all of it where these are its ends."""
    ends = curve.value(curve.range)
    size = max(float(np.ptp(curve.control_points, axis=0).max()), 1e-300)
    near = 1e-6 * size
    if np.abs(ends[0] - start).max() <= near and np.abs(ends[1] - end).max() <= near:
        return curve
    at = [_nearest(curve, place) for place in (start, end)]
    return part_of(curve, min(at), max(at))


def _nearest(curve: Curve, place: Array) -> float:
    """Return the parameter of the place of a curve that is nearest to another one."""
    from bozzetto.geometry.basis import span_parameters

    at = span_parameters(curve.degree, curve.knots, 8)
    distance = np.linalg.norm(curve.value(at) - place, axis=1)
    least = int(distance.argmin())
    low, high = at[max(least - 1, 0)], at[min(least + 1, len(at) - 1)]
    for _ in range(60):  # thirds: the distance has one least value there
        a, b = low + (high - low) / 3.0, high - (high - low) / 3.0
        one, two = np.linalg.norm(curve.value([a, b]) - place, axis=1)
        low, high = (low, b) if one <= two else (a, high)
    return float(0.5 * (low + high))


def _as_straight(edge: Curve) -> Curve:
    """Return a straight edge over the range from 0 to 1, as surfaces have theirs."""
    if edge.degree == 1 and len(edge.control_points) == 2:
        return Curve(1, np.array([0.0, 0.0, 1.0, 1.0]), edge.control_points)
    return edge


def _whole(surface: BSplineSurface, edges: list[Curve]) -> Brep:
    """Return all of a surface as one face.

    Raises
    ------
    FormatError
        If other curves than its borders bound it.
    """
    whole = Brep.of_surface(surface)
    tolerance = whole.tolerance
    left = list(edges)
    for border in whole.edges:
        match = next(
            (
                edge
                for edge in left
                if any(same_curve(border, edge, tolerance, opposite=way) for way in (False, True))
            ),
            None,
        )
        if match is None:
            raise CurveError("A face is cut by other curves than its borders.")
        left = [edge for edge in left if edge is not match]
    if left:
        raise CurveError("A face is cut by other curves than its borders.")
    return whole
