"""A line graph in units of its own size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.plugin import cached_property
from bozzetto_polyhedron.graph.line_graph import LineGraph
from bozzetto_polyhedron.reconstruction.line_samples import CoveredLines

LEAST_NOISE: Final = 0.002
"""Least standard deviation of a corner, diagonals: nobody draws better."""

MOST_NOISE: Final = 0.06
"""Largest standard deviation of a corner, diagonals, beyond which all lines would be parallel."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """Corners and lines; x right, y up, the middle of the corners at 0, the diagonal 1.

    Parameters
    ----------
    points : (n, 2) float64
        Corners, diagonals.
    lines : (m, 2) intp
        Numbers of corners, the smaller one first, each pair once.
    light : (m,) float64
        How likely a line was drawn as a hidden one, 0 … 1.
    noise : float
        Standard deviation of a corner, diagonals.
    center : (2,) float64
        Where the middle of the corners is, canvas pixels.
    diagonal : float
        Diagonal of the box around the corners, px.
    """

    points: Array
    lines: Index
    light: Array
    noise: float
    center: Array
    diagonal: float

    @cached_property
    def covered(self) -> CoveredLines:
        """Which places on its lines are inside faces."""
        return CoveredLines(self.points, self.lines)

    @property
    def lengths(self) -> Array:
        """Length of each line, (m,), diagonals."""
        return np.asarray(np.linalg.norm(self.spans, axis=1))

    @property
    def spans(self) -> Array:
        """Vector of each line from its smaller to its larger corner, (m, 2)."""
        return np.asarray(self.points[self.lines[:, 1]] - self.points[self.lines[:, 0]])


def drawing_of(graph: LineGraph) -> Drawing:
    """Return a graph in units of its size, without lines that have no length or stand twice."""
    places = np.nan_to_num(np.asarray(graph.places, float).reshape(-1, 2), posinf=0.0, neginf=0.0)
    low, high = (places.min(0), places.max(0)) if len(places) else (np.zeros(2), np.zeros(2))
    center = (low + high) / 2.0
    diagonal = float(np.hypot(*(high - low)))
    size = diagonal if 0.0 < diagonal < np.inf else 1.0
    points = (places - center) / size * (1.0, -1.0)
    if len(points):
        middle = points.mean(0)
        points = points - middle
        center = center + middle * (size, -size)
    lines, light = _sound_lines(points, graph)
    noise = float(graph.noise) / size
    if not np.isfinite(noise):
        noise = MOST_NOISE
    return Drawing(
        points, lines, light, float(np.clip(noise, LEAST_NOISE, MOST_NOISE)), center, size
    )


def _sound_lines(points: Array, graph: LineGraph) -> tuple[Index, Array]:
    """Lines between two places, smaller corner first, each once; and how light they are."""
    given = np.sort(np.asarray(graph.lines, np.intp).reshape(-1, 2), axis=1)
    light = np.clip(np.nan_to_num(np.asarray(graph.light, float).reshape(-1)), 0.0, 1.0)
    if len(light) != len(given):
        light = np.zeros(len(given))
    inside = (given >= 0).all(1) & (given < len(points)).all(1)
    given, light = given[inside], light[inside]
    long = np.linalg.norm(points[given[:, 1]] - points[given[:, 0]], axis=1) > 1e-9
    given, light = given[long], light[long]
    lines, first = np.unique(given, axis=0, return_index=True)
    return lines.reshape(-1, 2), light[first]
