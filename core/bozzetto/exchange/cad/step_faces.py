"""Faces of STEP: planes within curves, and whole B-spline surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from bozzetto.exchange.cad.curve_pieces import CurveError, repeated
from bozzetto.exchange.cad.exact_shapes import ExactShapes
from bozzetto.exchange.cad.step_curves import CurveReader, backwards
from bozzetto.exchange.cad.step_placements import axes_of
from bozzetto.exchange.cad.step_records import Instances
from bozzetto.exchange.cad.step_units import Units
from bozzetto.geometry.brep.brep import Brep
from bozzetto.geometry.brep.planes import plane_face
from bozzetto.geometry.brep.sewing import same_curve
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Color, Curve

__all__ = ["FaceReader"]


class FaceReader:
    """Reads the faces of a file.

    Parameters
    ----------
    instances : Instances
        Of the file.
    found : ExactShapes
        Counts what is read.
    units : Units
        Of the file.
    colors : mapping
        Colours of instances.
    """

    def __init__(
        self,
        instances: Instances,
        found: ExactShapes,
        units: Units,
        colors: Mapping[int, Color],
    ) -> None:
        self._of, self._found, self._colors = instances, found, colors
        self._curves = CurveReader(instances, found, units)

    def read(self, number: Any) -> Brep:
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
            _, _, _, normal = axes_of(self._of, plane.values[1])
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
        edges = [curve for edge in loop.values[1] for curve in self._curves.read(edge, 0)]
        edges = [_as_straight(edge) for edge in edges]
        return edges if bound.values[2] == "T" else list(backwards(tuple(edges)))

    def _surface(self, number: Any) -> BSplineSurface:
        kinds = {record.kind: record.values for record in self._of.records(number)}
        shape = kinds.get("B_SPLINE_SURFACE")
        own = kinds.get("B_SPLINE_SURFACE_WITH_KNOTS")
        if own is None:
            raise CurveError("This kind of surface is not read.")
        if shape is None:
            shape, own = own[1:8], own[8:]
        degrees = int(shape[0]), int(shape[1])
        net = np.array([[self._curves.point(one) for one in row] for row in shape[2]])
        counts = [side + degree + 1 for side, degree in zip(net.shape, degrees, strict=False)]
        knots = [repeated(own[k + 2], own[k], counts[k]) for k in (0, 1)]
        weights = kinds.get("RATIONAL_B_SPLINE_SURFACE", [None])[0]
        share = None if weights is None else np.array(weights, float)
        return BSplineSurface(degrees, knots[0], knots[1], net, share)


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
