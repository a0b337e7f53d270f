"""IGES 5.3: exact surfaces and curves for older CAD programs, in millimetres.

Faces are rational B-spline surfaces (entity 128), each whole within its natural border, or
trimmed (144) by curves on it (142). Those of one object are a group (402, form 7); IGES programs
sew them by their places. Curves are rational B-splines (126), names are name properties (406,
form 15) and colours colour definitions (314). Lines have 80 columns: 72 of content (64 for
parameters, which name their entry behind), a letter for the section, and the number in it.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from bozzetto.exchange.cad.cad_curves import RESOLUTION, checked_curves
from bozzetto.exchange.cad.cad_surfaces import checked_breps
from bozzetto.exchange.cad.step_text import real
from bozzetto.geometry.brep.brep import Brep, Face, Loop
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.shapes import Color, Curve, Shapes

CURVE: Final = 126
SURFACE: Final = 128
COMPOSITE: Final = 102
ON_SURFACE: Final = 142
TRIMMED: Final = 144
GROUP: Final = 402
GROUP_FORM: Final = 7
COLOR: Final = 314
PROPERTY: Final = 406
NAME_FORM: Final = 15

DEPENDENT: Final = "00010000"
"""Status of a property, or a curve or surface that is a part: it depends on another entity."""

PARAMETRIC: Final = "00010500"
"""Status of a curve in the parameters of a surface."""

BOTH_PREFERRED: Final = "3"
"""A curve in parameters and the curve in space are as good as one another."""

DEFINITION: Final = "00000200"
"""Status of a colour: a definition that others use."""

EPOCH: Final = "19800101.000000"
"""Time stamp of every file, so that equal shapes give equal files."""

PARAMETERS: Final = 64
"""Columns for parameters on a line."""

COLUMNS: Final = 72
"""Columns for all other content."""


def write_shapes(shapes: Shapes) -> bytes:
    """Write the exact surfaces and curves as IGES, with names and colours.

    Names are in ASCII there: accents are taken off, other characters become ``?``.

    Raises
    ------
    UserError
        As `checked_breps` and `checked_curves`.
    """
    breps = checked_breps(shapes)
    # Readers cut curves at their corners, and complain.
    wanted = shapes.curves or not breps
    curves = checked_curves(shapes, corners=False) if wanted else ()
    file = _File("Surfaces" if breps else "Curves")
    for brep in breps:
        members = [_add_face(file, face, brep) for face in brep.faces]
        listed = (str(len(members)), *map(str, members))
        file.add_named(GROUP, listed, brep.name, None, form=GROUP_FORM)
    for curve in curves:
        file.add_named(CURVE, _parameters(curve), curve.name, curve.color)
    places = [f.surface.control_points for b in breps for f in b.faces]
    places += [c.control_points for c in curves]
    return file.encoded(max(float(np.abs(points).max()) for points in places))


def _add_face(file: _File, face: Face, brep: Brep) -> int:
    """Add a face: its surface alone, or trimmed by curves in its parameters and in space."""
    name, color = face.name or brep.name, face.color or brep.color
    if face.is_whole:
        return file.add_named(SURFACE, _surface_parameters(face.surface), name, color)
    surface = file.add(SURFACE, list(_surface_parameters(face.surface)), status=DEPENDENT)
    bounds = [_add_bound(file, loop, brep, surface) for loop in face.loops]
    values = (str(surface), "1", str(len(bounds) - 1), *map(str, bounds))
    return file.add_named(TRIMMED, values, name, color)


def _add_bound(file: _File, loop: Loop, brep: Brep, surface: int) -> int:
    """Add the curves of a loop on a surface (4.34), both in the sense of the loop."""
    flat, space = [], []
    for trim in loop:
        path = Curve(trim.curve.degree, trim.curve.knots, trim.curve.in_space, trim.curve.weights)
        flat.append(path if trim.forward else path.reversed())
        if trim.edge is not None:
            edge = brep.edges[trim.edge]
            space.append(edge if trim.forward else edge.reversed())
    ends = [
        _add_chain(file, curves, status)
        for curves, status in ((flat, PARAMETRIC), (space, DEPENDENT))
    ]
    values = ["0", str(surface), *map(str, ends), BOTH_PREFERRED]
    return file.add(ON_SURFACE, values, status=DEPENDENT)


def _add_chain(file: _File, curves: list[Curve], status: str) -> int:
    """Add curves that follow one another, as one."""
    numbers = [file.add(CURVE, list(_parameters(curve)), status=status) for curve in curves]
    if len(numbers) == 1:
        return numbers[0]
    return file.add(COMPOSITE, [str(len(numbers)), *map(str, numbers)], status=status)


class _File:
    """An IGES file in the making: its directory and its parameters."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._colors: dict[Color, int] = {}
        self._directory: list[str] = []
        self._parameters: list[str] = []

    def add(
        self,
        kind: int,
        values: Sequence[str],
        *,
        form: int = 0,
        color: int = 0,
        status: str = "00000000",
    ) -> int:
        """Add an entity; what comes back is the number of its directory entry."""
        entry = len(self._directory) + 1
        first = len(self._parameters) + 1
        rows = list(_rows([str(kind), *values], PARAMETERS))
        self._parameters += [f"{row:<{PARAMETERS}}{entry:>8}" for row in rows]
        self._directory.append(_fields(kind, first, 0, 0, 0, 0, 0, 0, status))
        self._directory.append(_fields(kind, 0, color, len(rows), form, "", "", "", 0))
        return entry

    def add_named(
        self, kind: int, values: Iterable[str], name: str, color: Color | None, *, form: int = 0
    ) -> int:
        """Add an entity with a name and a colour; a colour is written once."""
        tint = 0
        if color is not None:
            if color not in self._colors:
                shades = [_real(value / 255 * 100) for value in color]
                self._colors[color] = self.add(COLOR, shades, status=DEFINITION)
            tint = -self._colors[color]
        label = self.add(PROPERTY, ["1", _text(name)], form=NAME_FORM, status=DEPENDENT)
        return self.add(kind, [*values, "0", "1", str(label)], form=form, color=tint)

    def encoded(self, reach: float) -> bytes:
        """Return the whole file.

        Parameters
        ----------
        reach : float
            Largest coordinate, mm.
        """
        sections = {
            "S": [f"{self._title} from Bozzetto"],
            "G": list(_rows(_settings(self._title, reach), COLUMNS)),
            "D": self._directory,
            "P": self._parameters,
        }
        last = "".join(f"{letter}{len(rows):>7}" for letter, rows in sections.items())
        sections["T"] = [last]
        lines = (
            f"{row:<{COLUMNS}}{letter}{number:>7}\n"
            for letter, rows in sections.items()
            for number, row in enumerate(rows, 1)
        )
        return "".join(lines).encode("ascii")


def _fields(*values: object) -> str:
    """Return the fields of a directory entry, eight columns each."""
    return "".join(f"{value:>8}" for value in values)


def _settings(title: str, reach: float) -> list[str]:
    """Return the fields of the global section (2.2.4.3)."""
    program = _text("Bozzetto")
    return [
        _text(","), _text(";"), program, _text(f"{title.lower()}.igs"), program, program,
        "32", "38", "7", "308", "17",  # bits of an integer; powers and digits of reals
        program, "1.", "2", _text("MM"), "1", "0.25", _text(EPOCH),
        _real(RESOLUTION), _real(reach), _text(""), _text(""),
        "11", "0", _text(EPOCH),  # 11: version 5.3
    ]  # fmt: skip


def _parameters(curve: Curve) -> Iterator[str]:
    """Yield the parameters of a rational B-spline curve (4.23)."""
    count = len(curve.control_points)
    normal = _normal(curve.control_points)
    weights = np.ones(count) if curve.weights is None else curve.weights
    flags = (normal is not None, curve.closed, curve.weights is None, False)
    yield from (str(count - 1), str(curve.degree), *(str(int(flag)) for flag in flags))
    for values in (curve.knots, weights, curve.control_points, curve.knots[[0, -1]]):
        yield from map(_real, values.ravel().tolist())
    yield from map(_real, (0.0, 0.0, 0.0) if normal is None else normal.tolist())


def _surface_parameters(surface: BSplineSurface) -> Iterator[str]:
    """Yield the parameters of a rational B-spline surface (4.24)."""
    net, weights = surface.control_points, surface.weights
    counts, degrees = net.shape[:2], surface.degrees
    yield from (str(count - 1) for count in counts)
    yield from map(str, degrees)
    yield from ("0", "0", str(int(weights is None)), "0", "0")  # open, polynomial, not periodic
    if weights is None:
        weights = np.ones(counts)
    along_u = net.transpose(1, 0, 2)  # the first index runs first
    for values in (*surface.knots, weights.T, along_u, surface.ranges):
        yield from map(_real, np.ravel(values).tolist())


def _normal(points: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Return the unit normal of the plane that holds the points; None where no plane does.

    Of a straight line any normal will do.
    """
    centered = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(centered.T @ centered)
    normal = np.asarray(axes[2])
    return normal if np.abs(centered @ normal).max() <= RESOLUTION else None


def _real(value: float) -> str:
    """Write a number with all its digits; the exponent's letter says double precision."""
    return real(value).replace("E", "D")


def _text(text: str) -> str:
    """Write a string with its length before it (2.2.2.4); nothing for an empty one."""
    plain = unicodedata.normalize("NFKD", text)
    plain = "".join(letter for letter in plain if not unicodedata.combining(letter))
    plain = re.sub(r"[^\x20-\x7e]", "?", plain)
    return f"{len(plain)}H{plain}" if plain else ""


def _rows(values: Iterable[str], width: int) -> Iterator[str]:
    """Break values with their delimiters into lines; only what is longer than one is split."""
    values = list(values)
    row = ""
    for number, value in enumerate(values, 1):
        word = value + ("," if number < len(values) else ";")
        if len(row) + len(word) > width:
            if row:
                yield row
            while len(word) > width:
                yield word[:width]
                word = word[width:]
            row = ""
        row += word
    yield row
