"""Curves of STEP: splines, lines, conics, their parts and rows (ISO 10303-42)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
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
from bozzetto.exchange.cad.step_placements import axes_of, direction_of, unit_vector
from bozzetto.exchange.cad.step_records import Instances, Record
from bozzetto.exchange.cad.step_units import Units
from bozzetto.exchange.limits import MAX_DEPTH, at_most
from bozzetto.geometry.curve import Curve

__all__ = ["CURVES", "CurveReader", "backwards"]

SPLINES: Final = (
    "B_SPLINE_CURVE_WITH_KNOTS", "BEZIER_CURVE", "UNIFORM_CURVE", "QUASI_UNIFORM_CURVE",
)  # fmt: skip

CURVES: Final = (
    *SPLINES, "B_SPLINE_CURVE", "POLYLINE", "LINE", "CIRCLE", "ELLIPSE", "TRIMMED_CURVE",
    "COMPOSITE_CURVE", "EDGE_CURVE", "ORIENTED_EDGE", "SURFACE_CURVE", "SEAM_CURVE",
    "INTERSECTION_CURVE", "PARABOLA", "HYPERBOLA", "OFFSET_CURVE_3D", "CURVE_REPLICA",
    "CLOTHOID", "COMPOSITE_CURVE_ON_SURFACE",
)  # fmt: skip


class CurveReader:
    """Reads the curves of one shape.

    Parameters
    ----------
    instances : Instances
        Of the file.
    found : ExactShapes
        Counts what is read, and notes what is not.
    units : Units
        Of the shape.
    """

    def __init__(self, instances: Instances, found: ExactShapes, units: Units) -> None:
        self._of, self._found, self._units = instances, found, units

    def read(self, number: Any, depth: int) -> tuple[Curve, ...]:
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
                    points = [self.point(one) for one in values[1]]
                    return (polyline(points),)
                case "TRIMMED_CURVE":
                    return self._trimmed(values, depth)
                case "COMPOSITE_CURVE" | "COMPOSITE_CURVE_ON_SURFACE":
                    return self._composite(values[1], depth)
                case "CIRCLE" | "ELLIPSE":
                    return (ellipse_arc(*self._conic(kind, values), 0.0, 2.0 * math.pi),)
                case "SURFACE_CURVE" | "SEAM_CURVE" | "INTERSECTION_CURVE":
                    return self.read(values[1], depth + 1)
                case "EDGE_CURVE":
                    return self._edge(values, depth)
                case "ORIENTED_EDGE":
                    inside = self.read(values[3], depth + 1)
                    return inside if values[4] == "T" else backwards(inside)
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
        points = np.array([self.point(one) for one in shape[1]])
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
            inside = self.read(basis, depth + 1)
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
                    end * self._units.radians
                    if isinstance(end, float)
                    else _angle(end - center, first, second)
                )
            inside = (ellipse_arc(center, first, second, angles[0], _after(*angles)),)
        return inside if forward else backwards(inside)

    def _trim(self, trim: Any, by_place: bool) -> float | Array:
        """Return where a curve is cut: a parameter or a place."""
        place = next((one for one in trim if isinstance(one, int)), None)
        number = _parameter(trim)
        if place is not None and (by_place or number is None):
            return self.point(place)
        if number is None:
            raise ValueError("a cut without a place")
        return number

    def _composite(self, segments: Any, depth: int) -> tuple[Curve, ...]:
        pieces: list[Curve] = []
        for one in segments:
            values = self._of.records(one)[0].values
            inside = self.read(values[2], depth + 1)
            pieces += inside if values[1] == "T" else backwards(inside)
        return joined(pieces)

    def _edge(self, values: list[Any], depth: int) -> tuple[Curve, ...]:
        """Return the part of a curve between two vertices."""
        start, end = (self._vertex(one) for one in values[1:3])
        basis, forward = values[3], values[4] == "T"
        record = self._of.record(basis, "LINE", "CIRCLE", "ELLIPSE")
        if record is None:
            inside = self.read(basis, depth + 1)
            if len(inside) == 1 and not values[1] == values[2]:
                inside = (_between(inside[0], *((start, end) if forward else (end, start))),)
            return inside if forward else backwards(inside)
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
        return inside if forward else backwards(inside)

    # -- places --

    def point(self, number: Any) -> Array:
        """Return a point (3,), mm."""
        found = self._of.point(number)
        if found is None:
            raise CurveError("A point of this file is not there. Save it again.")
        return self._units.millimetres * np.array([*found, 0.0, 0.0][:3], float)

    def _vertex(self, number: Any) -> Array:
        record = self._of.record(number, "VERTEX_POINT")
        return self.point(None if record is None else record.values[1])

    def _line(self, record: Record) -> tuple[Array, Array]:
        vector = self._of.record(record.values[2], "VECTOR")
        if vector is None:
            raise CurveError("A line of this file has no direction. Save it again.")
        along = unit_vector(direction_of(self._of, vector.values[1]))
        return self.point(record.values[1]), self._units.millimetres * vector.values[2] * along

    def _conic(self, kind: str, values: list[Any]) -> tuple[Array, Array, Array]:
        """Return the centre of an ellipse, and its half axes, mm."""
        origin, x, y, _ = axes_of(self._of, values[1])
        radii = values[2:4] if kind == "ELLIPSE" else (values[2], values[2])
        mm = self._units.millimetres
        return mm * origin, mm * radii[0] * x, mm * radii[1] * y


def backwards(curves: Sequence[Curve]) -> tuple[Curve, ...]:
    """Return curves in the opposite direction, the last one first."""
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
