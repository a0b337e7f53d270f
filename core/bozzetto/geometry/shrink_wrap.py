"""A skin over curves in space: a sphere that is shrunk and subdivided onto them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.errors import UserError
from bozzetto.geometry.anchors import anchored, with_edges
from bozzetto.geometry.fairing import Stiffness, drawn_to, held_at
from bozzetto.geometry.icosphere import Icosphere, icosphere
from bozzetto.geometry.mesh import Mesh
from bozzetto.geometry.mesh_feet import mesh_feet
from bozzetto.geometry.wireframe import MIRROR, Wireframe, wireframe

__all__ = ["LEVELS", "curve_distances", "shrink_wrap"]

Array = NDArray[np.float64]
Checkpoint = Callable[[float, str], None]

LEVELS: Final = (3, 6)
"""Coarsest and finest level of subdivision that can be asked for."""

START: Final = 3
"""Level at which a sphere begins to shrink: few vertices, so that it gets far."""


def _nobody(fraction: float, step: str) -> None:
    """Progress that no one watches."""


def shrink_wrap(
    curves: Sequence[ArrayLike],
    *,
    level: int = 5,
    tightness: float = 1.0,
    smoothing: float = 0.5,
    checkpoint: Checkpoint = _nobody,
) -> Mesh:
    frame = wireframe(curves)
    start = START if level > 4 else 2
    vertices = _around(icosphere(start), frame)
    places = None
    for now in range(start, level):
        sphere = icosphere(now)
        some = frame.every(2 ** max(0, 5 - now))
        rounds = 6 if now == start else 3
        for k in range(rounds):
            checkpoint(0.1, "Shrinking")
            points = some.both_sides()
            feet = mesh_feet(sphere, vertices, points)
            near = feet.vertices
            weights = 1.0 / np.bincount(near, minlength=len(vertices))[near]
            vertices = drawn_to(now, feet, points, weights, _stiffness(now, smoothing, 1e-2))
            vertices = _evened(sphere, vertices, frame)
        vertices = icosphere(now + 1).refined(vertices)
    sphere = icosphere(level)
    for _ in range(2):
        checkpoint(0.8, "Anchoring")
        feet = mesh_feet(sphere, vertices, frame.places)
        reached = feet.distances < 0.02
        anchors = anchored(sphere, vertices, frame, reached)
        vertices = held_at(level, anchors.vertices, anchors.places, _stiffness(level, smoothing, 1.0))
        vertices = _evened(sphere, vertices, frame)
    faces = with_edges(sphere.faces, anchors.links)
    return Mesh((vertices * frame.size + frame.centre).astype(np.float32), faces.astype(np.int32))


def _stiffness(level: int, smoothing: float, strength: float) -> Stiffness:
    length = 0.02 * 100.0**smoothing
    ratio = (length / (0.56 * 2.0**-level)) ** 2
    return Stiffness(strength / (1 + ratio), strength * ratio / (1 + ratio))


def _around(sphere: Icosphere, frame: Wireframe) -> Array:
    points = frame.both_sides()
    half = 0.5 * np.ptp(points, axis=0)
    centre = points.mean(axis=0) * (1.0, 0.0 if frame.symmetric else 1.0, 1.0)
    support = ((points - centre) / half @ sphere.directions.T).max(axis=0)
    facing = sphere.directions @ sphere.directions.T
    radius = np.where(facing > 1e-3, support / np.where(facing > 1e-3, facing, 1), np.inf).min(axis=1)
    return centre + sphere.directions * radius[:, None] * half


def _evened(sphere: Icosphere, vertices: Array, frame: Wireframe) -> Array:
    if not frame.symmetric:
        return vertices
    return 0.5 * (vertices + vertices[sphere.mirrored] * MIRROR)


def curve_distances(curves: Sequence[ArrayLike], mesh: Mesh) -> Array:
    raise NotImplementedError
