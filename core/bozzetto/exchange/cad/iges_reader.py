"""IGES 5.3, read exactly: curves, and bodies of whole or trimmed B-spline surfaces.

Curves are those that belong to no face: rational B-splines (126), arcs (100), conics (104),
lines (110), polylines (106), cubics in pieces (112) and rows of these (102), each moved as its
matrices (124) say. What has another kind of face is read by Open CASCADE (`cad_reader`).
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.cached_properties import cached_property
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.cad.curve_pieces import (
    CurveError,
    checked_curve,
    ellipse_arc,
    joined,
    part_of,
    polyline,
)
from bozzetto.exchange.cad.exact_shapes import ExactShapes
from bozzetto.exchange.cad.iges import (
    COLOR,
    COMPOSITE,
    CURVE,
    GROUP,
    NAME_FORM,
    ON_SURFACE,
    PROPERTY,
    SURFACE,
    TRIMMED,
)
from bozzetto.exchange.limits import MAX_DEPTH, MAX_ELEMENTS, at_most
from bozzetto.geometry.brep.brep import Brep, Face, ParameterCurve, Trim
from bozzetto.geometry.brep.sewing import sewn
from bozzetto.geometry.brep.surface import BSplineSurface
from bozzetto.geometry.curve import Color, Curve

ARC, CONIC, LINES, LINE, CUBICS, MATRIX = 100, 104, 106, 110, 112, 124
OFFSET, SUBFIGURE, ANY_SURFACE = 130, 308, frozenset((114, 118, 120, 122, 140, 143, 190, 192))
CURVES: Final = {
    ARC: "arc", COMPOSITE: "row of curves", CONIC: "conic", LINES: "polyline", LINE: "line",
    CUBICS: "spline", CURVE: "B-spline", OFFSET: "offset curve",
}  # fmt: skip

MM_PER: Final = {
    1: 25.4, 2: 1.0, 4: 304.8, 5: 1_609_344.0, 6: 1000.0, 7: 1e6, 8: 0.0254, 9: 1e-3, 10: 10.0,
    11: 2.54e-5,
}  # fmt: skip
"""Millimetres in a unit by its flag (2.2.4.3.14)."""

COLORS: Final[dict[int, Color]] = {
    1: (0, 0, 0), 2: (255, 0, 0), 3: (0, 255, 0), 4: (0, 0, 255), 5: (255, 255, 0),
    6: (255, 0, 255), 7: (0, 255, 255), 8: (255, 255, 255),
}  # fmt: skip
"""Colours by their numbers (2.2.4.4.13)."""

COUNTED: Final = re.compile(r"\s*(\d{1,6})H")


@dataclass
class _Entry:
    """An entity: the fields of its directory entry that matter, and its parameters.

    These are taken apart when they are asked for: most files hold more surfaces than curves.
    """

    kind: int
    form: int
    matrix: int
    color: int
    status: str
    label: str
    lines: list[bytes]
    ends: tuple[str, str]

    @cached_property
    def values(self) -> tuple[str, ...]:
        """Its parameters, without the number of its kind."""
        text = "".join(line.decode("latin-1") for line in self.lines)
        return tuple(_words(text, *self.ends)[1:])

    @property
    def is_seen(self) -> bool:
        return self.status[:2] != "01"

    @property
    def is_free(self) -> bool:
        """Whether it is no part of another entity, and not in the parameters of a surface."""
        return self.status[2:4] in ("00", "02") and self.status[4:6] in ("00", "06")


def read_exactly(data: bytes, *, bodies: bool) -> ExactShapes:
    """Read what can be read exactly of an IGES file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    bodies : bool
        Whether bodies are wanted, too.

    Raises
    ------
    FormatError
        If the file is damaged, or there is too much.
    """
    found = ExactShapes()
    with np.errstate(all="ignore"):  # what is not finite is refused where it is a curve
        reader = _Iges(data, found)
        reader.read_curves()
        if bodies:
            reader.read_bodies()
    return found


def has_faces(data: bytes) -> bool:
    """Whether an IGES file holds surfaces or solids."""
    return any(
        entry.kind in ANY_SURFACE or entry.kind in (SURFACE, TRIMMED) or 150 <= entry.kind < 190
        for entry in _entries(data)[0].values()
    )


def _entries(data: bytes) -> tuple[dict[int, _Entry], list[str]]:
    """Return the entities of a file by the numbers of their directory entries, and its settings."""
    sections: dict[bytes, list[bytes]] = {b"G": [], b"D": [], b"P": []}
    for count, line in enumerate(data.splitlines()):
        at_most(count, 4 * MAX_ELEMENTS, "lines")
        rows = sections.get(line[72:73])
        if rows is not None:
            rows.append(line)
    settings = "".join(line[:72].decode("latin-1") for line in sections[b"G"])
    ends = _delimiters(settings)
    fields = _words(settings, *ends)
    directory = [line[:72].decode("latin-1") for line in sections[b"D"]]
    parameters = sections[b"P"]
    found: dict[int, _Entry] = {}
    total = 0
    for at in range(0, len(directory) - 1, 2):
        one, two = ([row[k : k + 8] for k in range(0, 72, 8)] for row in directory[at : at + 2])
        kind, first, count = _whole(one[0]), _whole(one[1]), _whole(two[3])
        begin = max(first - 1, 0)
        own = [line[:64] for line in parameters[begin : begin + max(count, 1)]]
        total += len(own)
        at_most(total, 4 * MAX_ELEMENTS, "lines of parameters")
        found[at + 1] = _Entry(
            kind, _whole(two[4]), _whole(one[6]), _whole(two[2]), one[8].strip().rjust(8, "0"),
            two[7].strip(), own, ends,
        )  # fmt: skip
    return found, fields


def _delimiters(settings: str) -> tuple[str, str]:
    """Return what parts values, and what ends them (2.2.3)."""
    between, end = ",", ";"
    if settings[:2] == "1H":
        between = settings[2]
        rest = settings[4:]
    else:
        rest = settings[1:]
    if rest[:2] == "1H":
        end = rest[2]
    return between, end


def _words(text: str, between: str, end: str) -> list[str]:
    """Return values; strings without the count before them."""
    stop = re.compile(f"[^{re.escape(between + end)}]*+")
    found: list[str] = []
    at = 0
    while at < len(text):
        counted = COUNTED.match(text, at)
        begin = at if counted is None else counted.end()
        last = begin if counted is None else min(begin + int(counted[1]), len(text))
        plain = stop.match(text, last)
        at = last if plain is None else plain.end()
        found.append(text[begin:at].strip() if counted is None else text[begin:last])
        if at == len(text) or text[at] == end:
            break
        at += 1
    return found


def _whole(text: str) -> int:
    text = text.strip()
    return int(text) if re.fullmatch(r"[-+]?\d{1,9}", text) else 0


class _Iges:
    """One file that is read."""

    def __init__(self, data: bytes, found: ExactShapes) -> None:
        self._entries, fields = _entries(data)
        self._found = found
        scale = _number(fields[12], 1.0) if len(fields) > 12 else 1.0
        unit = MM_PER.get(_whole(fields[13]) if len(fields) > 13 else 2, 1.0)
        self._mm = unit / (scale if scale > 0.0 else 1.0)
        self._matrices: dict[int, Array] = {}

    # -- what is there --

    def read_curves(self) -> None:
        """Read the curves that are no part of anything else."""
        for number, entry in self._entries.items():
            if entry.kind not in CURVES or not (entry.is_seen and entry.is_free):
                continue
            if entry.kind == LINES and entry.form not in (1, 2, 3, 11, 12, 13, 63):
                continue  # points, hatchings, leaders of dimensions
            try:
                made = self._curves(number, 0)
            except CurveError:
                self._found.other_curves["damaged curve"] += 1
                continue
            if not made:
                self._found.other_curves[CURVES[entry.kind]] += 1
            for curve in made:
                name = self._name(entry) or "Curve"
                self._found.add(replace(curve, name=name, color=self._color(entry)))

    def read_bodies(self) -> None:
        """Read surfaces, those of a group as one body, sewn where their borders are the same."""
        groups: dict[int, int] = {}
        for number, entry in self._entries.items():
            if entry.kind == GROUP and entry.form in (1, 7, 14, 15):
                for member in map(_whole, entry.values[1:]):
                    groups.setdefault(member, number)
        bodies: dict[int, list[int]] = {}
        for number, entry in self._entries.items():
            surface = entry.kind in (SURFACE, TRIMMED) or entry.kind in ANY_SURFACE
            if entry.is_seen and ((surface and entry.is_free) or 150 <= entry.kind < 190):
                bodies.setdefault(groups.get(number, 0), []).append(number)
        for group, members in bodies.items():
            try:
                made = [self._face(number) for number in members]
                name = self._name(self._entries[group]) if group else ""
                self._found.bodies.append(sewn(made, name or made[0].name))
            except (UserError, ArithmeticError, IndexError, KeyError, TypeError, ValueError):
                self._found.other_bodies += 1

    def _name(self, entry: _Entry) -> str:
        """Return the name that a property gives an entity, or its label."""
        for value in entry.values[::-1][:MAX_DEPTH]:
            other = self._entries.get(_whole(value))
            if other is None:
                break
            if other.kind == PROPERTY and other.form == NAME_FORM and len(other.values) > 1:
                return other.values[1].strip()[:200]
        return entry.label if entry.label.isprintable() else ""

    def _color(self, entry: _Entry) -> Color | None:
        if entry.color >= 0:
            return COLORS.get(entry.color)
        tint = self._entries.get(-entry.color)
        if tint is None or tint.kind != COLOR or len(tint.values) < 3:
            return None
        shades = [_number(value, 0.0) for value in tint.values[:3]]
        r, g, b = (round(2.55 * min(max(shade, 0.0), 100.0)) for shade in shades)
        return r, g, b

    def _matrix(self, number: int) -> Array:
        """Return the matrix (4, 4) of an entity, with those that it is moved by in turn."""
        found = self._matrices.get(number)
        if found is not None:
            return found
        whole, one = np.eye(4), number
        for _ in range(MAX_DEPTH):
            entry = self._entries.get(one)
            if entry is None or entry.kind != MATRIX or len(entry.values) < 12:
                break
            own = np.eye(4)
            own[:3] = np.array([_number(v) for v in entry.values[:12]]).reshape(3, 4)
            whole, one = own @ whole, entry.matrix
        else:
            raise FormatError("Its matrices move one another. Save it again.")
        self._matrices[number] = whole
        return whole

    def _turned(self, curve: Curve, entry: _Entry) -> Curve:
        """Return a curve in mm moved as the matrix of an entry says."""
        if not entry.matrix:
            return curve
        matrix = self._matrix(entry.matrix)
        places = curve.control_points @ matrix[:3, :3].T + self._mm * matrix[:3, 3]
        return replace(curve, control_points=places)

    # -- curves --

    def _curves(self, number: int, depth: int, *, flat: bool = False) -> tuple[Curve, ...]:
        """Return a curve in space, mm; in the parameters of a surface as it stands there."""
        self._found.count()
        at_most(depth, MAX_DEPTH, "levels of curves")
        entry = self._entries.get(number)
        if entry is None:
            raise CurveError("A curve of this file is not there. Save it again.")
        try:
            if entry.kind == COMPOSITE:
                members = [_whole(v) for v in entry.values[1 : 1 + _whole(entry.values[0])]]
                pieces = [p for one in members for p in self._curves(one, depth + 1, flat=flat)]
                row = tuple(pieces) if flat else joined(pieces)
                return tuple(self._turned(curve, entry) for curve in row)
            made = self._plain(entry)
        except (ArithmeticError, IndexError, TypeError, ValueError) as problem:
            raise CurveError("A curve of this file is damaged. Save it again.") from problem
        if flat:
            return made
        if self._mm != 1.0:
            made = tuple(replace(c, control_points=self._mm * c.control_points) for c in made)
        return tuple(self._turned(curve, entry) for curve in made)

    def _plain(self, entry: _Entry) -> tuple[Curve, ...]:
        """Return a curve in its own frame and unit."""
        match entry.kind:
            case kind if kind == CURVE:
                return (self._spline(entry.values),)
            case kind if kind == LINE:
                return (polyline([_number(v) for v in entry.values[:6]]),)
            case kind if kind == LINES:
                return self._polyline(entry)
            case kind if kind == ARC:
                z, x, y, *ends = (_number(v) for v in entry.values[:7])
                start, end = np.array(ends[:2]) - (x, y), np.array(ends[2:]) - (x, y)
                radius = math.hypot(*start)
                begin, last = math.atan2(start[1], start[0]), math.atan2(end[1], end[0])
                axes = (radius, 0.0, 0.0), (0.0, radius, 0.0)
                return (ellipse_arc((x, y, z), *axes, begin, _after(begin, last)),)
            case kind if kind == CONIC:
                return self._conic(entry)
            case kind if kind == CUBICS:
                return (_cubics(entry.values),)
        return ()

    def _spline(self, values: tuple[str, ...]) -> Curve:
        last, degree = _whole(values[0]), _whole(values[1])
        count = last + 1
        if not 1 <= degree <= last:
            raise ValueError("a degree beyond the points")
        closed = values[3].strip() == "1"
        numbers = [_number(v) for v in values[6 : 6 + 5 * count + degree + 3]]
        knots, rest = numbers[: count + degree + 1], numbers[count + degree + 1 :]
        weights, points = rest[:count], rest[count : 4 * count]
        curve = checked_curve(degree, knots, points, weights, closed=closed)
        begin, end = rest[4 * count : 4 * count + 2]
        low, high = curve.range
        if (begin == low and end == high) or not end > begin:
            return curve
        return part_of(curve, begin, end)

    def _polyline(self, entry: _Entry) -> tuple[Curve, ...]:
        way, count = _whole(entry.values[0]), _whole(entry.values[1])
        if way == 1:
            depth = _number(entry.values[2])
            flat = [_number(v) for v in entry.values[3 : 3 + 2 * count]]
            points = np.column_stack((np.reshape(flat, (-1, 2)), np.full(len(flat) // 2, depth)))
        else:
            width = 3 if way == 2 else 6
            row = [_number(v) for v in entry.values[2 : 2 + width * count]]
            points = np.reshape(row, (-1, width))[:, :3]
        if entry.form in (1, 2, 3) or len(points) < 2:
            return ()  # points alone
        if entry.form == 63 and (points[0] != points[-1]).any():
            points = np.vstack((points, points[:1]))
        return (polyline(points),)

    def _conic(self, entry: _Entry) -> tuple[Curve, ...]:
        """Return an arc of an ellipse in a plane: ax² + bxy + cy² + dx + ey + f = 0 (4.5)."""
        a, b, c, d, e, f, z, *ends = (_number(v) for v in entry.values[:11])
        start, last = np.array(ends[:2]), np.array(ends[2:])
        form = np.array([[a, b / 2], [b / 2, c]])
        if np.linalg.det(form) <= 0.0:
            return ()  # a parabola or hyperbola
        center = np.linalg.solve(2.0 * form, [-d, -e])
        level = -(f + 0.5 * (d * center[0] + e * center[1]))
        squares, axes = np.linalg.eigh(form / level)
        if (squares <= 0.0).any():
            return ()
        if np.linalg.det(axes) < 0.0:
            axes[:, 1] *= -1.0
        halves = axes / np.sqrt(squares)
        angles = []
        for place in (start, last):
            x, y = np.linalg.solve(halves, place - center)
            angles.append(math.atan2(y, x))
        first, second = ((*halves[:, k], 0.0) for k in (0, 1))
        return (ellipse_arc((*center, z), first, second, angles[0], _after(*angles)),)

    # -- faces --

    def _face(self, number: int) -> Brep:
        """Return a face: a whole B-spline surface, or one within curves on it.

        Raises
        ------
        CurveError
            If it is another one.
        """
        entry = self._entries[number]
        name, color = self._name(entry), self._color(entry)
        if entry.kind == SURFACE:
            made = Brep.of_surface(self._surface(number))
        elif entry.kind == TRIMMED:
            surface = self._surface(_whole(entry.values[0]))
            inner = _whole(entry.values[2])
            bounds = [_whole(v) for v in entry.values[3 : 4 + inner]]
            if entry.values[1].strip() == "0":  # the outer bound is the border
                made = Brep.of_surface(surface)
                if inner:
                    raise CurveError("A border with holes is not read.")
            else:
                made = self._trimmed(surface, bounds)
        else:
            raise CurveError("This kind of surface is not read.")
        face = replace(made.faces[0], name=name, color=color)
        return replace(made, faces=(face,), name=name or "surface")

    def _trimmed(self, surface: BSplineSurface, bounds: list[int]) -> Brep:
        """Return a face within curves that are told in its parameters and in space, alike."""
        edges: list[Curve] = []
        loops = []
        for bound in bounds:
            entry = self._entries[bound]
            if entry.kind != ON_SURFACE:
                raise CurveError("This kind of border is not read.")
            flat = self._curves(_whole(entry.values[2]), 0, flat=True)
            space = list(self._members(_whole(entry.values[3])))
            loop = []
            for path in flat:
                line = ParameterCurve(
                    path.degree, path.knots, path.control_points[:, :2], path.weights
                )
                ends = surface.value(*path.control_points[[0, -1], :2].T)
                middle = surface.value(*line.value([0.5 * sum(path.range)]).T)
                places = np.vstack((ends, middle))
                if np.ptp(places, axis=0).max() <= 1e-9 * surface.size:
                    loop.append(Trim(None, True, line))
                    continue
                edge = space.pop(0)
                if edge.degree == path.degree == 1:
                    edge = Curve(1, path.knots, edge.control_points)
                loop.append(Trim(len(edges), True, line))
                edges.append(edge)
            loops.append(tuple(loop))
        return Brep(tuple(edges), (Face(surface, tuple(loops)),))

    def _members(self, number: int) -> tuple[Curve, ...]:
        """Return the curves of a row, each by itself."""
        entry = self._entries[number]
        if entry.kind != COMPOSITE:
            return self._curves(number, 0)
        return tuple(p for v in entry.values[1:] for p in self._curves(_whole(v), 0))

    def _surface(self, number: int) -> BSplineSurface:
        entry = self._entries[number]
        if entry.kind != SURFACE:
            raise CurveError("This kind of surface is not read.")
        values = entry.values
        m, n, p, q = (_whole(v) for v in values[:4])
        if not (0 < p <= m and 0 < q <= n and (m + 1) * (n + 1) <= len(values)):
            raise ValueError("a degree beyond the points")
        numbers = [_number(v) for v in values[9:]]
        ends = np.cumsum([m + p + 2, n + q + 2, (m + 1) * (n + 1), 3 * (m + 1) * (n + 1)])
        u, v, weights, net = np.split(np.array(numbers[: ends[-1]]), ends[:-1])
        places = net.reshape(n + 1, m + 1, 3).transpose(1, 0, 2)
        matrix = self._matrix(entry.matrix) if entry.matrix else np.eye(4)
        if entry.matrix:
            places = places @ matrix[:3, :3].T + matrix[:3, 3]
        share = weights.reshape(n + 1, m + 1).T
        plain = bool((share == share[0, 0]).all())
        places = places if self._mm == 1.0 else self._mm * places
        return BSplineSurface((p, q), u, v, places, None if plain else share)


def _cubics(values: tuple[str, ...]) -> Curve:
    """Return a row of cubics (4.14, parametric spline curve) as one B-spline."""
    count = _whole(values[3])
    breaks = np.array([_number(v) for v in values[4 : 5 + count]])
    rows = np.array([_number(v) for v in values[5 + count : 5 + 13 * count]])
    steps = np.diff(breaks)[:, None, None]
    powers = rows.reshape(count, 3, 4) * steps ** np.arange(4)
    to_bezier = np.array([[1, 0, 0, 0], [1, 1 / 3, 0, 0], [1, 2 / 3, 1 / 3, 0], [1, 1, 1, 1]])
    nets = np.einsum("ij,kdj->kid", to_bezier, powers)
    points = np.concatenate((nets[:, :3].reshape(-1, 3), nets[-1:, 3]))
    knots = np.concatenate((breaks[:1], np.repeat(breaks, 3), breaks[-1:]))
    return checked_curve(3, knots, points)


def _after(begin: float, end: float) -> float:
    turn = (end - begin) % (2.0 * math.pi)
    return begin + (turn if turn > 1e-9 else 2.0 * math.pi)


def _number(text: str, usual: float | None = 0.0) -> float:
    """Return a number; an empty one has its usual value.

    Raises
    ------
    ValueError
        If it is no number.
    """
    text = text.strip().upper().replace("D", "E")
    if not text:
        return 0.0 if usual is None else usual
    return float(text)
