"""Known bodies, drawn edge by edge through a camera with a steady or a shaky pen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bozzetto.ink import Stroke
from bozzetto.testing import Pen
from bozzetto.view import Camera
from tests.plugins.polyhedron.objects import Polyhedron

VIEW = Camera(
    kind="orthographic",
    eye=(260.0, -430.0, 310.0),
    target=(0.0, 0.0, 40.0),
    height=240.0,
    viewport=(1200.0, 900.0),
)

LIGHT, FIRM = 0.25, 0.75
"""Pressure of hidden and of visible lines."""


def fitted(solid: Polyhedron, size: float = 120.0, at: Sequence[float] = (0, 0, 40)) -> np.ndarray:
    """Return the vertices of a solid so large and about a place, mm."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    return (solid.vertices - 0.5 * (low + high)) * (size / float((high - low).max())) + at


def strokes_of(
    vertices: np.ndarray,
    edges: np.ndarray,
    *,
    camera: Camera = VIEW,
    jitter: float = 0.0,
    hidden: Sequence[int] = (),
    seed: int = 0,
    shuffled: bool = False,
) -> list[Stroke]:
    """Return one stroke for every edge.

    Parameters
    ----------
    vertices, edges : array
    camera : Camera
    jitter : float
        Standard deviation of where strokes end, px, and of half the tremor along them.
    hidden : sequence of int
        Edges that are drawn lightly.
    seed : int
    shuffled : bool
        Whether the edges are drawn in any order and direction.
    """
    rng = np.random.default_rng((17, seed))
    places = camera.project(vertices)[0]
    made = []
    for number, edge in enumerate(edges):
        ends = places[edge] + jitter * rng.normal(size=(2, 2))
        if shuffled and rng.random() < 0.5:
            ends = ends[::-1]
        pressure = LIGHT if number in hidden else FIRM
        pen = Pen(camera, tremor=0.3 * jitter, pressure=pressure, seed=1000 * seed + number)
        made.append(pen.along(ends))
    return [made[k] for k in rng.permutation(len(made))] if shuffled else made
