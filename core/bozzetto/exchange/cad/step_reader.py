"""STEP, read exactly: curves, and bodies of planes and whole B-spline surfaces.

Curves are those that a shape holds beside its faces: B-splines of any kind, polylines, lines,
circles and ellipses, parts of these, and rows of them, each where its product is placed. What has
another kind of face is read by Open CASCADE (`cad_reader`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.exchange.cad.curve_pieces import CurveError
from bozzetto.exchange.cad.exact_shapes import ExactShapes
from bozzetto.exchange.cad.step_curves import CURVES, CurveReader
from bozzetto.exchange.cad.step_faces import FaceReader
from bozzetto.exchange.cad.step_placements import REPRESENTATIONS, Placements
from bozzetto.exchange.cad.step_records import Instances, Record
from bozzetto.exchange.cad.step_units import units_of
from bozzetto.geometry.brep.sewing import sewn
from bozzetto.geometry.curve import Color, Curve

SETS: Final = ("GEOMETRIC_CURVE_SET", "GEOMETRIC_SET")
WIRES: Final = (
    "EDGE_BASED_WIREFRAME_MODEL", "SHELL_BASED_WIREFRAME_MODEL", "CONNECTED_EDGE_SET",
    "WIRE_SHELL", "EDGE_LOOP", "PATH",
)  # fmt: skip
"""What holds edges that belong to no face."""

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
        placements = Placements(self._of)
        for number, values in self._representations():
            items = [item for item in values[1] if isinstance(item, int)]
            first = len(self._found.curves)
            units = units_of(self._of, values[2] if len(values) > 2 else None)
            curves = CurveReader(self._of, self._found, units)
            for item in items:
                if self._of.record(item, *SETS, *WIRES) or self._of.record(item, *CURVES):
                    self._add(item, curves)
            made = self._found.curves[first:]
            if not made:
                continue
            del self._found.curves[first:]
            for matrix in placements.of(number):
                for curve in made:
                    self._found.add(_moved(curve, matrix))

    def read_bodies(self) -> None:
        """Read shells whose faces are planes or whole surfaces."""
        context = next(iter(self._of.of_kind("GLOBAL_UNIT_ASSIGNED_CONTEXT")), None)
        units = units_of(self._of, context)
        reader = FaceReader(self._of, self._found, units, self._colors)
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
                made = [reader.read(face) for face in faces or ()]
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

    def _add(self, item: int, curves: CurveReader) -> None:
        """Add what a set holds, sets in sets taken apart."""
        waiting: list[tuple[Any, str, Color | None]] = [(item, "", None)]
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
                made = curves.read(number, 0)
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


def _moved(curve: Curve, matrix: Array) -> Curve:
    if (matrix == np.eye(4)).all():
        return curve
    places = curve.control_points @ matrix[:3, :3].T + matrix[:3, 3]
    return replace(curve, control_points=places)
