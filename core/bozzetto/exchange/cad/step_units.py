"""Units of STEP: millimetres and radians in those of a context."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

from bozzetto.errors import FormatError
from bozzetto.exchange.cad.step_records import Instances, Record
from bozzetto.exchange.limits import MAX_DEPTH

__all__ = ["Units", "units_of"]

PREFIXES: Final = {
    "EXA": 1e18, "PETA": 1e15, "TERA": 1e12, "GIGA": 1e9, "MEGA": 1e6, "KILO": 1e3, "HECTO": 1e2,
    "DECA": 1e1, "DECI": 1e-1, "CENTI": 1e-2, "MILLI": 1e-3, "MICRO": 1e-6, "NANO": 1e-9,
    "PICO": 1e-12, "FEMTO": 1e-15, "ATTO": 1e-18,
}  # fmt: skip


class Units(NamedTuple):
    """Units that a shape's numbers have.

    Attributes
    ----------
    millimetres : float
        In a unit of length.
    radians : float
        In a unit of angle.
    """

    millimetres: float = 1.0
    radians: float = 1.0


def units_of(instances: Instances, context: Any) -> Units:
    """Return the units of a context; millimetres and radians where it has none.

    Raises
    ------
    FormatError
        If one of them has no size.
    """
    found = Units()
    units = instances.record(context, "GLOBAL_UNIT_ASSIGNED_CONTEXT")
    for unit in units.values[0] if units is not None and units.values else ():
        kinds = {record.kind for record in instances.records(unit)}
        if "LENGTH_UNIT" in kinds:
            found = found._replace(millimetres=1000.0 * _size(instances, unit))
        elif "PLANE_ANGLE_UNIT" in kinds:
            found = found._replace(radians=_size(instances, unit))
    return found


def _size(instances: Instances, unit: Any) -> float:
    """Return the size of a unit in metres or radians."""
    size = 1.0
    for _ in range(MAX_DEPTH):
        plain = instances.record(unit, "SI_UNIT")
        if plain is not None:
            size *= PREFIXES.get(str(plain.values[0]), 1.0) if plain.values else 1.0
            break
        other = instances.record(unit, "CONVERSION_BASED_UNIT")
        measure = None if other is None or len(other.values) < 2 else other.values[1]
        found = next(iter(instances.records(measure)), None)
        if found is None or len(found.values) < 2 or not isinstance(found.values[0], Record):
            break
        number = found.values[0].values[:1]
        size *= float(number[0]) if number and isinstance(number[0], float) else 1.0
        unit = found.values[1]
    if not (math.isfinite(size) and size > 0.0):
        raise FormatError("A unit of this file has no size.")
    return size
