"""Placements of STEP: axes, and where assemblies place their shapes."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.cad.curve_pieces import CurveError
from bozzetto.exchange.cad.step_records import Instances
from bozzetto.exchange.cad.step_units import units_of
from bozzetto.exchange.limits import MAX_DEPTH, MAX_PARTS, at_most

__all__ = ["REPRESENTATIONS", "Placements", "axes_of", "direction_of", "unit_vector"]

REPRESENTATIONS: Final = (
    "SHAPE_REPRESENTATION", "GEOMETRICALLY_BOUNDED_WIREFRAME_SHAPE_REPRESENTATION",
    "EDGE_BASED_WIREFRAME_SHAPE_REPRESENTATION", "SHELL_BASED_WIREFRAME_SHAPE_REPRESENTATION",
    "GEOMETRICALLY_BOUNDED_SURFACE_SHAPE_REPRESENTATION", "ADVANCED_BREP_SHAPE_REPRESENTATION",
    "MANIFOLD_SURFACE_SHAPE_REPRESENTATION", "CONSTRUCTIVE_GEOMETRY_REPRESENTATION",
    "FACETED_BREP_SHAPE_REPRESENTATION",
)  # fmt: skip
"""What holds the geometry of a product."""


class Placements:
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

    def of(self, number: int) -> list[Array]:
        """Return the matrices, (4, 4), mm, that place a shape; one that moves nothing at least.

        Parameters
        ----------
        number : int
            The instance of the shape.
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
                inner = _frame(self._of, origin, self._millimetres(member))
                outer = _frame(self._of, target, self._millimetres(holder))
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

    def _millimetres(self, number: int) -> float:
        """Return the millimetres in a unit of a shape."""
        values = next((one.values for one in self._of.records(number)), [])
        return units_of(self._of, values[2] if len(values) > 2 else None).millimetres


def _frame(of: Instances, number: Any, mm: float) -> Array:
    """Return the matrix (4, 4) of a placement."""
    origin, x, y, z = axes_of(of, number)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack((x, y, z, mm * origin))
    return matrix


def axes_of(of: Instances, number: Any) -> tuple[Array, Array, Array, Array]:
    """Return origin and axes of a placement (ISO 10303-42, build_axes)."""
    record = of.record(number, "AXIS2_PLACEMENT_3D", "AXIS2_PLACEMENT_2D", "AXIS1_PLACEMENT")
    if record is None:
        raise CurveError("A place of this file is not there. Save it again.")
    values = [*record.values, None, None]
    point = of.point(values[1]) or []
    origin = np.array([*point, 0.0, 0.0, 0.0][:3], float)
    flat = record.kind == "AXIS2_PLACEMENT_2D"
    z = None if flat or values[2] is None else direction_of(of, values[2])
    aside = values[2] if flat else values[3]
    z = np.array([0.0, 0.0, 1.0]) if z is None else unit_vector(z)
    if aside is None or record.kind == "AXIS1_PLACEMENT":
        x = np.array([1.0, 0.0, 0.0]) if abs(z[0]) < 1.0 else np.array([0.0, 0.0, 1.0])
    else:
        x = direction_of(of, aside)
    x = unit_vector(x - (x @ z) * z)
    return origin, x, np.cross(z, x), z


def direction_of(of: Instances, number: Any) -> Array:
    """Return a direction (3,) as it is written."""
    record = of.record(number, "DIRECTION")
    if record is None:
        raise CurveError("A direction of this file is not there. Save it again.")
    return np.array([*record.values[1], 0.0][:3], float)


def unit_vector(vector: Array) -> Array:
    """Return a direction (3,) at length one."""
    length = float(np.linalg.norm(vector))
    if not (math.isfinite(length) and length > 0.0):
        raise CurveError("A direction of this file has no length. Save it again.")
    return vector if length == 1.0 else vector / length
