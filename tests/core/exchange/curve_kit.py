"""Curves of every kind, their values by SciPy, and readers of STEP and IGES text of our own."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline

from bozzetto.geometry import Curve

HALF = 2**-0.5
RNG = np.random.default_rng(20)


def points(count, size=100.0):
    return RNG.normal(size=(count, 3)) * size


def ring(count, degree):
    """A closed curve that begins between its control points."""
    p = points(count)
    knots = np.arange(count + 2 * degree + 1.0)
    return Curve(degree, knots, np.vstack((p, p[:degree])), closed=True, name="ring")


CIRCLE = Curve(
    2,
    [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4],
    [[10, 5, 0], [10, 5, 10], [0, 5, 10], [-10, 5, 10], [-10, 5, 0],
     [-10, 5, -10], [0, 5, -10], [10, 5, -10], [10, 5, 0]],
    [1, HALF, 1, HALF, 1, HALF, 1, HALF, 1],
    closed=True,
    name="circle",
)  # fmt: skip

CURVES = (
    Curve(
        3, [0, 0, 0, 0, 0.25, 0.5, 0.75, 1, 1, 1, 1], points(7), name="roof", color=(212, 80, 47)
    ),
    CIRCLE,
    ring(7, 3),
    ring(4, 2),
    Curve(3, np.cumsum(RNG.random(13)), points(9), RNG.uniform(0.3, 3, 9), name="floating"),
    Curve(3, [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2], points(7), name="corner", color=(1, 2, 3)),
    Curve(1, [0, 0, 1, 2, 3, 3], points(4), name="polyline"),
    Curve(5, [0] * 6 + [0.3] + [1] * 6, points(7, 1e-3), name="five"),
    Curve(3, [-2e8] * 4 + [3e8] * 4, points(4), name="long"),
    Curve(2, [0, 0, 0, 1e-9, 1e-9, 1e-9], points(3), [1e-8, 2e-8, 3e-8], name="short"),
)
"""Every one of a kind that needs care; each is one curve in the files."""

CORNER = CURVES[5]
"""The one that is two in IGES, for readers would cut it."""

WITHOUT_CORNER = tuple(curve for curve in CURVES if curve is not CORNER)

BROKEN = Curve(
    3,
    [0] * 5 + [1] * 4 + [1.5] + [2] * 5 + [4] * 4,
    points(15),
    RNG.uniform(1, 2, 15),
    name="broken",
)
"""Three curves in one, with control points that carry nothing between them and at the start."""

NAMES = ("it's; a 'name' \\ \\X2\\",
         "Ärmel, 漢字 😀 🚗 é", "line\nfeed\0nul\x7f\x85", "", "#1=X('')", "('a', 'b' )'' ,'",
         "half \ud83d surrogate", "n" * 700, "漢" * 300)  # fmt: skip
"""Names that a careless writer breaks on."""


def domain(curve):
    return float(curve.knots[curve.degree]), float(curve.knots[len(curve.control_points)])


def values(curve, u):
    """Points of a curve by SciPy, shape (n, 3)."""
    weights = np.ones(len(curve.control_points)) if curve.weights is None else curve.weights
    lifted = np.column_stack((curve.control_points * weights[:, None], weights))
    got = BSpline(curve.knots, lifted, curve.degree)(u)
    return got[:, :3] / got[:, 3:]


def same_places(curve, other, count=301):
    """Largest distance of two curves at equal shares of their parameters, mm."""
    share = np.linspace(0, 1, count)[1:-1]
    one, two = (values(c, a + (b - a) * share) for c in (curve, other) for a, b in [domain(c)])
    return float(np.abs(one - two).max())


# -- STEP --------------------------------------------------------------------------------------

TOKEN = re.compile(
    r"\s*('(?:[^']|'')*'|#\d+|\.[A-Z_]+\.|[A-Z][A-Z0-9_]*|[-+]?\d+\.?\d*(?:E[-+]?\d+)?|[()=;,$*])"
)


def _text(literal):
    """A string literal decoded (ISO 10303-21, 6.4.3.3)."""

    def plain(match):
        if match[0] == "\\\\":
            return "\\"
        return bytes.fromhex(match[2]).decode("utf-16-be" if match[1] == "2" else "utf-32-be")

    body = literal[1:-1].replace("''", "'")
    return re.sub(r"\\X([24])\\((?:[0-9A-F]{4})+)\\X0\\|\\\\", plain, body)


class Step:
    """A Part 21 file: instances as lists of (entity name, arguments)."""

    def __init__(self, data):
        text = data.decode("ascii")
        assert text.startswith("ISO-10303-21;\nHEADER;\n")
        assert text.endswith("ENDSEC;\nEND-ISO-10303-21;\n")
        self.tokens = TOKEN.findall(text[text.index("DATA;") + 5 :])
        self.at = 0
        self.instances = {}
        while self.tokens[self.at].startswith("#"):
            number = self.take()
            assert self.take() == "="
            together = self.tokens[self.at] == "("
            if together:
                self.take()
            records = [self.record()]
            while together and self.tokens[self.at] != ")":
                records.append(self.record())
            if together:
                self.take()
            assert self.take() == ";"
            assert number not in self.instances
            self.instances[number] = dict(records)
        assert self.take() == "ENDSEC"

    def take(self):
        self.at += 1
        return self.tokens[self.at - 1]

    def record(self):
        name = self.take()
        assert name.isidentifier()
        assert name.isupper()
        return name, self.value()

    def value(self):
        token = self.take()
        if token == "(":
            items = []
            while self.tokens[self.at] != ")":
                items.append(self.value())
                if self.tokens[self.at] == ",":
                    self.take()
            self.take()
            return items
        if token.startswith("'"):
            return _text(token)
        if token[0] in "#.$*":
            return token
        if token[0].isalpha():  # a typed value
            return self.value()[0]
        return float(token) if "." in token else int(token)

    def of(self, kind):
        return [(n, r[kind]) for n, r in self.instances.items() if kind in r]

    def curves(self):
        """The curves of the set, in its order; every reference is followed."""
        ((_, (_, members)),) = self.of("GEOMETRIC_CURVE_SET")
        return [self.curve(member) for member in members]

    def curve(self, number):
        one = self.instances[number]
        spline = one["B_SPLINE_CURVE_WITH_KNOTS"]
        weights = None
        if "RATIONAL_B_SPLINE_CURVE" in one:
            spline = [*one["REPRESENTATION_ITEM"], *one["B_SPLINE_CURVE"], *spline]
            (weights,) = one["RATIONAL_B_SPLINE_CURVE"]
        name, degree, members, _, closed, _, times, places, _ = spline
        assert len(times) == len(places)
        assert all(a < b for a, b in pairwise(places))
        assert times[0] == times[-1] == degree + 1
        assert max(times[1:-1], default=1) <= degree
        corners = [self.instances[m]["CARTESIAN_POINT"][1] for m in members]
        return Curve(degree, np.repeat(places, times), corners, weights, closed == ".T.", name)

    def color(self, number):
        """The colour of an item in 8 bits, None without one."""
        for _, (_, (style,), item) in self.of("STYLED_ITEM"):
            if item == number:
                (line,) = self.instances[style]["PRESENTATION_STYLE_ASSIGNMENT"][0]
                look = self.instances[line]
                if "CURVE_STYLE" in look:
                    tint = look["CURVE_STYLE"][3]
                else:
                    for step in ("SURFACE_STYLE_USAGE", "SURFACE_SIDE_STYLE"):
                        following = look[step][1]
                        number = following[0] if isinstance(following, list) else following
                        look = self.instances[number]
                    area = self.instances[look["SURFACE_STYLE_FILL_AREA"][0]]
                    ((filling,),) = (area["FILL_AREA_STYLE"][1],)
                    tint = self.instances[filling]["FILL_AREA_STYLE_COLOUR"][1]
                return tuple(round(255 * v) for v in self.instances[tint]["COLOUR_RGB"][1:])
        return None


# -- IGES --------------------------------------------------------------------------------------


class Iges:
    """An IGES file: its global section, and (form, colour, parameters) by entry and type."""

    def __init__(self, data):
        lines = data.decode("ascii").splitlines()
        assert {len(line) for line in lines} == {80}
        rows = {letter: [x[:72] for x in lines if x[72] == letter] for letter in "SGDPT"}
        assert [x[72] for x in lines] == [c for c in "SGDPT" for _ in rows[c]]
        for letter in "SGDPT":
            numbers = [int(x[73:]) for x in lines if x[72] == letter]
            assert numbers == list(range(1, len(numbers) + 1))
        counts = re.findall(r"([SGDP]) *(\d+)", rows["T"][0])
        assert [(c, int(n)) for c, n in counts] == [(c, len(rows[c])) for c in "SGDP"]
        self.settings = self.words("".join(rows["G"]))
        self.entities = {}
        for at in range(0, len(rows["D"]), 2):
            one, two = ([r[k : k + 8] for k in range(0, 72, 8)] for r in rows["D"][at : at + 2])
            start, count = int(one[1]) - 1, int(two[3])
            own = rows["P"][start : start + count]
            assert {int(row[64:]) for row in own} == {at + 1}
            kind, *values = self.words("".join(row[:64] for row in own))
            assert int(kind) == int(one[0]) == int(two[0])
            self.entities[at + 1] = (int(kind), int(two[4]), int(two[2]), values)

    @staticmethod
    def words(text):
        """Parameters as text; strings without their counts."""
        found, at = [], 0
        while True:
            counted = re.compile(r"(\d+)H").match(text, at)
            if counted:
                at = counted.end() + int(counted[1])
                found.append(text[counted.end() : at])
            else:
                end = re.compile("[,;]").search(text, at).start()
                found.append(text[at:end].strip())
                at = end
            at += 1
            if text[at - 1] == ";":
                assert not text[at:].strip()
                return found

    def curves(self):
        """Curves with the colours and the (name) properties that they point to."""
        return [self.curve(e) for e in self.entities.values() if e[0] == 126]

    def curve(self, entity):
        _, form, color, values = entity
        upper, degree, planar, closed, polynomial, periodic = map(int, values[:6])
        numbers = np.array([float(v.replace("D", "E")) for v in values[6:-3]])
        assert (form, periodic) == (0, 0)
        sizes = np.cumsum([upper + degree + 2, upper + 1, 3 * (upper + 1), 2])
        knots, weights, places, ends, normal = np.split(numbers, sizes)
        assert tuple(ends) == (knots[0], knots[-1])
        assert len(normal) == 3
        if planar:
            assert np.linalg.norm(normal) == 1 or abs(np.linalg.norm(normal) - 1) < 1e-12
        associated, properties, pointer = map(int, values[-3:])
        assert (associated, properties) == (0, 1)
        kind, form, _, (count, name) = self.entities[pointer]
        assert (kind, form, int(count)) == (406, 15, 1)
        tint = None
        if color:
            kind, _, _, shades = self.entities[-color]
            assert kind == 314
            tint = tuple(round(2.55 * float(v.replace("D", "E"))) for v in shades[:3])
        assert bool(polynomial) == bool((weights == weights[0]).all())
        return Curve(degree, knots, places.reshape(-1, 3), None if polynomial else weights,
                     bool(closed), name, tint)  # fmt: skip
