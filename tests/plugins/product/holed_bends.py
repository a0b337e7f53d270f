"""Bodies whose bent faces have holes, of which faces and volume are known."""

from __future__ import annotations

import numpy as np
import shapely

from bozzetto.arrays import Array
from tests.plugins.product.holed_plates import Plate, regular

SAMPLES = 65
KINDS = ("bore", "pocket", "boss")


def _round(corners: Array, bend: float) -> list[Array]:
    """Return the sides of a figure: straight, or arcs of one circle (bend = radius)."""
    rows = []
    for one, two in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        row = np.linspace(one, two, SAMPLES)
        if bend:
            middle = corners.mean(axis=0)
            start = np.arctan2(*(one - middle)[::-1])
            turn = start + np.linspace(0.0, 2.0 * np.pi / len(corners), SAMPLES)
            row = middle + bend * np.column_stack((np.cos(turn), np.sin(turn)))
            row[[0, -1]] = one, two
        rows.append(row)
    return rows


class Holed(Plate):
    """The curves of a body with holes in bent faces; see `Plate`."""

    def lift(self, name: str, rows: list[Array]) -> frozenset[str]:
        """Add an outline of given sides in space."""
        for k, row in enumerate(rows):
            self.curves[f"{name}{k}"] = row
        return frozenset(f"{name}{k}" for k in range(len(rows)))

    def walls(self, name: str, low: list[Array], high: list[Array]) -> tuple[frozenset[str], ...]:
        """Add two outlines and the wall between them; return both."""
        ends = self.lift(f"{name}f", low), self.lift(f"{name}t", high)
        count = len(low)
        for k in range(count):
            self.curves[f"{name}v{k}"] = np.stack((low[k][0], high[k][0]))
            edges = (f"{name}f{k}", f"{name}t{k}", f"{name}v{k}", f"{name}v{(k + 1) % count}")
            self.faces.append(frozenset((frozenset(edges),)))
        return ends


def _moment(rows: list[Array], primitive: Array | object) -> float:
    """Return the integral of a function of y over a figure in (y, z), by its primitive in y."""
    ring = np.concatenate([row[:-1] for row in rows])
    after = np.roll(ring, -1, axis=0)
    at, weights = np.polynomial.legendre.leggauss(6)
    share = 0.5 + 0.5 * at[:, None]
    y = (1.0 - share) * ring[:, 0] + share * after[:, 0]
    return float((0.5 * weights[:, None] * primitive(y) * (after[:, 1] - ring[:, 1])).sum())


def cylinder(
    radius: float,
    height: float,
    seams: int,
    features: list[tuple[str, int, Array, float, float]],
) -> Holed:
    """Return a cylinder of as many faces as seams, with features on them.

    Parameters
    ----------
    radius, height : float
        mm.
    seams : int
        Lines from circle to circle; even where bores go through.
    features : list of (str, int, (k, 2) float, float, float)
        What each is, the face that it is on, its corners across the middle of the face (y along
        the circle, z), the radius of the circle that they are on or 0, and its depth.
    """
    made = Holed()
    seam = np.pi / seams + 2.0 * np.pi * np.arange(seams) / seams
    rims = []
    for name, z in (("of", 0.0), ("ot", height)):
        turns = seam[:, None] + np.linspace(0.0, 2.0 * np.pi / seams, SAMPLES)
        rows = [
            np.column_stack((radius * np.cos(t), radius * np.sin(t), np.full(SAMPLES, z)))
            for t in turns
        ]
        made.face(made.lift(name, rows))
        rims.append(rows)
    outlines: list[list[frozenset[str]]] = []
    for k in range(seams):
        made.curves[f"ov{k}"] = np.stack((rims[0][k][0], rims[1][k][0]))
        edges = (f"of{k}", f"ot{k}", f"ov{k}", f"ov{(k + 1) % seams}")
        outlines.append([frozenset(edges)])
    made.volume = np.pi * radius**2 * height

    def reach(y: Array) -> Array:
        return np.sqrt(radius**2 - y**2)

    def segment(y: Array) -> Array:
        return 0.5 * (y * reach(y) + radius**2 * np.arcsin(y / radius))

    for number, (kind, face, corners, bend, depth) in enumerate(features):
        turn = seam[face] + np.pi / seams
        out, side = (np.cos(turn), np.sin(turn), 0.0), (-np.sin(turn), np.cos(turn), 0.0)
        axes = np.array((out, side, (0.0, 0.0, 1.0)))
        flat = _round(corners, bend)
        top = [np.column_stack((reach(row[:, 0]), row)) @ axes for row in flat]
        name = f"{chr(97 + number)}."
        level = radius - depth if kind == "pocket" else radius + depth
        if kind == "bore":
            low = [np.column_stack((-reach(row[:, 0]), row)) @ axes for row in flat]
        else:
            low = [np.column_stack((np.full(len(row), level), row)) @ axes for row in flat]
        foot, mouth = made.walls(name, low, top)
        outlines[face].append(mouth)
        if kind == "bore":
            outlines[(face + seams // 2) % seams].append(foot)
            made.volume -= _moment(flat, lambda y: 2.0 * segment(y))
        else:
            made.face(foot)
            made.volume += _moment(flat, lambda y, at=level: at * y - segment(y))
    for row in outlines:
        made.face(*row)
    return made


def random_cylinder(seed: int) -> Holed:
    """Return a cylinder with one to four features on its side that do not touch."""
    random = np.random.default_rng(seed)
    radius, height = float(random.uniform(15.0, 30.0)), float(random.uniform(40.0, 80.0))
    seams = int(random.choice((2, 4)))
    half = radius * np.sin(np.pi / seams) * (0.75 if seams == 2 else 0.9)
    bored: list[int] = []
    free = {k: shapely.box(-half, 2.0, half, height - 2.0) for k in range(seams)}
    features = []
    for _ in range(60):
        if len(features) == 4 or (features and random.random() < 0.05):
            break
        size, face = float(random.uniform(0.12, 0.35)) * radius, int(random.integers(seams))
        middle = random.uniform((-half, 2.0), (half, height - 2.0))
        round_ = bool(random.random() < 0.6)
        kind = KINDS[int(random.integers(3))]
        spot = shapely.Point(middle)
        if not free[face].contains(spot.buffer(size + 0.5)):
            continue
        if kind == "bore":
            opposite = (face + seams // 2) % seams
            there = shapely.Point(-middle[0], middle[1])
            if bored or any(f[1] in (face, opposite) for f in features):
                continue
            if not free[opposite].contains(there.buffer(size + 0.5)):
                continue
            free[opposite] = free[opposite].difference(there.buffer(size + 1.5))
            bored += [face, opposite]
        elif bored:
            continue
        free[face] = free[face].difference(spot.buffer(size + 1.5))
        corners = regular(
            int(random.integers(2, 5)) if round_ else int(random.integers(3, 7)),
            (float(middle[0]), float(middle[1])), size, float(random.uniform(0.0, 6.0)),
        )  # fmt: skip
        sag = radius - np.sqrt(radius**2 - (abs(middle[0]) + size) ** 2)
        depth = sag * (kind == "pocket") + float(random.uniform(0.08, 0.3)) * radius
        features.append((kind, face, corners, size if round_ else 0.0, depth))
    return cylinder(radius, height, seams, features)


def random_top(seed: int) -> Holed:
    """Return a prism of a bent top with one to three features on it; its volume is not known.

    The curves lie on the top exactly; where the surface goes between them they do not tell.
    """
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 6))
    at = np.sort(2.0 * np.pi * (np.arange(count) + random.uniform(-0.2, 0.2, count)) / count)
    rim = random.uniform(35.0, 50.0, count)[:, None] * np.column_stack((np.cos(at), np.sin(at)))
    bends, lean = random.uniform(-0.008, 0.008, 3), random.uniform(-0.1, 0.1, 2)
    wave, pace = random.uniform(0.0, 1.0), random.uniform(0.03, 0.06)

    def top(flat: Array) -> Array:
        x, y = flat.T
        return (
            30.0 + lean[0] * x + lean[1] * y + bends[0] * x * x + bends[1] * x * y
            + bends[2] * y * y + wave * np.sin(pace * (x + 2.0 * y))
        )  # fmt: skip

    def lifted(rows: list[Array], level: float | None = None) -> list[Array]:
        return [
            np.column_stack((row, top(row) if level is None else np.full(len(row), level)))
            for row in rows
        ]

    made = Holed()
    sides = _round(rim, 0.0)
    bottom, above = ([outline] for outline in made.walls("o", lifted(sides, 0.0), lifted(sides)))
    free = shapely.Polygon(rim).buffer(-2.0)
    number = 0
    for _ in range(60):
        if number == 3 or (number and random.random() < 0.1):
            break
        radius, middle = float(random.uniform(4.0, 11.0)), random.uniform(-40.0, 40.0, 2)
        if not free.contains(shapely.Point(middle).buffer(radius + 0.5)):
            continue
        free = free.difference(shapely.Point(middle).buffer(radius + 2.0))
        bend = radius if random.random() < 0.5 else 0.0
        place = (float(middle[0]), float(middle[1]))
        corners = regular(
            int(random.integers(3, 6)), place, radius, float(random.uniform(0.0, 6.0))
        )
        flat, name = _round(corners, bend), f"{chr(97 + number)}."
        heights = np.concatenate([top(row) for row in flat])
        kind = KINDS[int(random.integers(3))]
        level = {"bore": 0.0, "pocket": heights.min() - 4.0, "boss": heights.max() + 4.0}[kind]
        foot, mouth = made.walls(name, lifted(flat, level), lifted(flat))
        above.append(mouth)
        if kind == "bore":
            bottom.append(foot)
        else:
            made.face(foot)
        number += 1
    made.face(*bottom)
    made.face(*above)
    made.volume = float("nan")
    return made
