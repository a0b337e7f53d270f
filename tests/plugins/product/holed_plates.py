"""Plates with bores, pockets, bosses and grooves of which volume, area and faces are known."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely

from bozzetto.arrays import Array


@dataclass
class Plate:
    """The curves of a plate, and what its body is.

    Attributes
    ----------
    curves : dict of str to (n, 3) array
        In its own frame: the plate stands on z = 0.
    volume, area : float
        Of the body, mm³ and mm².
    faces : list of frozenset of frozenset of str
        Of each face the outlines, as names of curves.
    """

    curves: dict[str, Array] = field(default_factory=dict)
    volume: float = 0.0
    area: float = 0.0
    faces: list[frozenset[frozenset[str]]] = field(default_factory=list)

    def ring(self, name: str, corners: Array, bend: float, z: float) -> frozenset[str]:
        """Add an outline: straight from corner to corner, or arcs of one circle (bend = radius)."""
        names = []
        for k, (one, two) in enumerate(zip(corners, np.roll(corners, -1, axis=0), strict=True)):
            row = np.stack((one, two))
            if bend:
                middle = corners.mean(axis=0)
                start = np.arctan2(*(one - middle)[::-1])
                turn = start + np.linspace(0.0, 2.0 * np.pi / len(corners), 65)
                row = middle + bend * np.column_stack((np.cos(turn), np.sin(turn)))
                row[[0, -1]] = one, two
            self.curves[f"{name}{k}"] = np.column_stack((row, np.full(len(row), z)))
            names.append(f"{name}{k}")
        return frozenset(names)

    def wall(
        self, name: str, corners: Array, bend: float, low: float, high: float
    ) -> tuple[frozenset[str], frozenset[str]]:
        """Add a wall with an outline at its foot and one at its top; return these."""
        foot, top = (
            self.ring(f"{name}{end}", corners, bend, z) for end, z in (("f", low), ("t", high))
        )
        count = len(corners)
        for k, (x, y) in enumerate(corners.tolist()):
            self.curves[f"{name}v{k}"] = np.array([(x, y, low), (x, y, high)])
        for k in range(count):
            edges = (f"{name}f{k}", f"{name}t{k}", f"{name}v{k}", f"{name}v{(k + 1) % count}")
            self.faces.append(frozenset((frozenset(edges),)))
        length = 2.0 * np.pi * bend if bend else _length(corners)
        self.area += length * abs(high - low)
        return foot, top

    def face(self, *outlines: frozenset[str]) -> None:
        """Add a plane face."""
        self.faces.append(frozenset(outlines))

    def facts(self, frame: Array | None = None, scale: float = 1.0) -> dict[str, Any]:
        """Return the network as a file has it, its axes turned to the rows of a frame."""
        axes = np.eye(3) if frame is None else frame
        rows = [
            {"name": name, "points": (scale * points @ axes).tolist()}
            for name, points in self.curves.items()
        ]
        return {"network": {"curves": rows}, "unit": "mm"}


def _length(corners: Array) -> float:
    return float(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).sum())


def _size(corners: Array, bend: float) -> float:
    return float(np.pi * bend**2) if bend else float(shapely.Polygon(corners).area)


def regular(count: int, middle: tuple[float, float], radius: float, turn: float = 0.0) -> Array:
    """Return corners on a circle, counter-clockwise, (count, 2)."""
    at = turn + 2.0 * np.pi * np.arange(count) / count
    return np.array(middle) + radius * np.column_stack((np.cos(at), np.sin(at)))


CORE = 0.4
"""Size of what is inside a groove, and of the bore of a boss, as share of the whole."""

FEATURES = ("bore", "pocket", "boss", "groove", "drilled boss")


def plate(
    outline: Array,
    height: float,
    features: list[tuple[str, Array, float, float]],
) -> Plate:
    """Return a plate.

    Parameters
    ----------
    outline : (n, 2) float
        Its corners, counter-clockwise.
    height : float
        mm.
    features : list of (str, (k, 2) float, float, float)
        What each is, its corners, the radius of the circle they are on or 0 for straight edges, and
        its depth.
    """
    made = Plate()
    below, above = made.wall("o", outline, 0.0, 0.0, height)
    bottom, top = [below], [above]
    ground = _size(outline, 0.0)
    made.volume, made.area = ground * height, made.area + 2.0 * ground
    for number, (kind, corners, bend, depth) in enumerate(features):
        name, middle = f"{chr(97 + number)}.", corners.mean(axis=0)
        inner, small = middle + CORE * (corners - middle), CORE * bend
        size, core = _size(corners, bend), CORE**2 * _size(corners, bend)
        if kind == "bore":
            foot, rim = made.wall(name, corners, bend, 0.0, height)
            bottom.append(foot)
            top.append(rim)
            made.volume, made.area = made.volume - size * height, made.area - 2.0 * size
        elif kind == "pocket":
            foot, rim = made.wall(name, corners, bend, height - depth, height)
            top.append(rim)
            made.face(foot)
            made.volume -= size * depth
        elif kind == "boss":
            rim, lid = made.wall(name, corners, bend, height, height + depth)
            top.append(rim)
            made.face(lid)
            made.volume += size * depth
        elif kind == "groove":
            foot, rim = made.wall(name, corners, bend, height - depth, height)
            core_foot, core_rim = made.wall(f"{name}c", inner, small, height - depth, height)
            top.append(rim)
            made.face(foot, core_foot)
            made.face(core_rim)
            made.volume -= (size - core) * depth
        else:
            rim, lid = made.wall(name, corners, bend, height, height + depth)
            foot, mouth = made.wall(f"{name}d", inner, small, 0.0, height + depth)
            top.append(rim)
            bottom.append(foot)
            made.face(lid, mouth)
            made.volume += (size - core) * depth - core * height
            made.area -= 2.0 * core
    made.face(*bottom)
    made.face(*top)
    return made


def random_plate(seed: int) -> Plate:
    """Return a plate of any outline with one to five features that do not touch.

    No wall is thinner than a hundredth of the diagonal: at that curves count as nearly crossing.
    """
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 9))
    at = np.sort(2.0 * np.pi * (np.arange(count) + random.uniform(-0.25, 0.25, count)) / count)
    outline = random.uniform(40.0, 60.0, count)[:, None] * np.column_stack((np.cos(at), np.sin(at)))
    height = float(random.uniform(4.0, 25.0))
    room = shapely.Polygon(outline)
    free = room.buffer(-1.0)
    features = []
    for _ in range(60):
        if len(features) == 5 or (features and random.random() < 0.03):
            break
        radius = float(random.uniform(6.0, 14.0))
        middle = random.uniform(-50.0, 50.0, 2)
        if not free.contains(shapely.Point(middle).buffer(radius + 0.5)):
            continue
        free = free.difference(shapely.Point(middle).buffer(radius + 1.5))
        round_ = bool(random.random() < 0.5)
        corners = regular(
            int(random.integers(2, 5)) if round_ else int(random.integers(4, 8)),
            (float(middle[0]), float(middle[1])), radius, float(random.uniform(0.0, 6.0)),
        )  # fmt: skip
        kind = FEATURES[int(random.integers(len(FEATURES)))]
        depth = float(random.uniform(0.2, 0.8)) * height
        features.append((kind, corners, radius if round_ else 0.0, depth))
    return plate(outline, height, features)
