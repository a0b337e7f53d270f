"""Outlines to test with: committed ones, the large shared set when present, and drawn ones."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bozzetto_silhouette.outline.outline import Outline, outline_from_rings

Points = NDArray[np.float64]

ROOT = Path(__file__).parents[3]
COMMITTED = ROOT / "tests" / "data" / "silhouettes"
SHARED = ROOT.parent / "shared" / "data" / "silhouettes"


def svg_rings(path: Path) -> list[Points]:
    """Rings of the first path of an SVG that knows only M, L and Z."""
    found = re.search(r' d="([^"]+)"', path.read_text())
    assert found is not None
    rings = []
    for part in re.findall(r"M([^MZz]+)", found.group(1)):
        pairs = [p for p in re.split(r"[L ]+", part.strip()) if p]
        rings.append(np.array([[float(v) for v in pair.split(",")] for pair in pairs]))
    return rings


def outline(name: str) -> Outline:
    return outline_from_rings(svg_rings(COMMITTED / f"{name}.svg"))


def ink(path: Path) -> tuple[list[Points], float, Points, Points]:
    """Strokes in pixels; pixels per unit, canvas middle, and what it shows of the outline."""
    data = json.loads(path.read_text())
    camera, canvas = data["camera"], data["canvas"]
    strokes = [np.column_stack([s["x"], s["y"]]) for s in data["strokes"]]
    middle = np.array([canvas["width"] / 2, canvas["height"] / 2])
    target = np.array([camera["target"][0], -camera["target"][2]])
    return strokes, canvas["height"] / camera["height"], middle, target


def in_outline_units(drawn: Outline, path: Path) -> Outline:
    _, scale, middle, target = ink(path)
    return drawn.transformed(1.0 / scale, target - middle / scale)


def iou(one: Outline, other: Outline) -> float:
    a, b = one.polygon(), other.polygon()
    return float(a.intersection(b).area / a.union(b).area)


def circle(x: float, y: float, radius: float, count: int = 96) -> Points:
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.column_stack([x + radius * np.cos(angle), y + radius * np.sin(angle)])


def spiral(turns: float, wall: float, gap: float, count: int = 900) -> Points:
    angle = np.linspace(0.6, turns, count) * 2.0 * np.pi
    radius = (wall + gap) * angle / (2.0 * np.pi)
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack(
        [(radius + wall / 2)[:, None] * ray, ((radius - wall / 2)[:, None] * ray)[::-1]]
    )


def comb(teeth: int, wall: float, gap: float, height: float) -> Points:
    x = teeth * (wall + gap) - gap
    points = [(0.0, 0.0), (x, 0.0)]
    for i in range(teeth):
        points += [(x, height), (x - wall, height)]
        x -= wall
        if i < teeth - 1:
            points += [(x, 8.0), (x - gap, 8.0)]
            x -= gap
    return np.array(points)


def dense(ring: Points, spacing: float) -> Points:
    closed = np.vstack([ring, ring[:1]])
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    at = np.linspace(0.0, arc[-1], int(arc[-1] / spacing), endpoint=False)
    return np.column_stack([np.interp(at, arc, closed[:, k]) for k in (0, 1)])
