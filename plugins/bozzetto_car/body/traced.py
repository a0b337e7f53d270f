"""How far edges are from the strokes that trace them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.ink import FARTHEST, distances_to_polyline
from bozzetto.plugin import cached_property
from bozzetto.view import Camera
from bozzetto_car.body.edge_runs import Run
from bozzetto_car.camera.rational_projection import (
    Pictured,
    camera_matrix,
)
from bozzetto_car.template.network import Network

PLACES: Final = 100
"""Pieces of an edge where lengths and distances on the sheet are measured."""


@dataclass(frozen=True, eq=False)
class Traced:
    """A network and a stroke along its edges.

    Attributes
    ----------
    network : Network
    run : Run
        The edges that the stroke was taken to trace.
    camera : Camera
    """

    network: Network
    run: Run
    camera: Camera

    @cached_property
    def farthest(self) -> tuple[tuple[float, Array], ...]:
        """The largest distance of each edge from its part of the stroke, px, and where that is.

        It is measured on the stretch of the edge that the stroke runs beside. Places are (2,) px.
        """
        return tuple(_farthest(self.network, self.run, self.camera))

    @property
    def deviations(self) -> tuple[float, ...]:
        """The largest distance of each edge from its part of the stroke, px."""
        return tuple(px for px, _ in self.farthest)


def _farthest(network: Network, run: Run, camera: Camera) -> Iterator[tuple[float, Array]]:
    for signed, part in zip(run.edges, run.parts, strict=True):
        path = _path(network, signed, camera)
        first, last = (
            int(np.argmin(np.linalg.norm(path - end, axis=1))) for end in (part[0], part[-1])
        )
        beside = path[min(first, last) : max(first, last) + 1]
        samples = part[_beside(part, path)]
        pairs = [(distances_to_polyline(beside, part), beside)]
        if len(samples):
            pairs.append((distances_to_polyline(samples, path), samples))
        off, places = max(pairs, key=lambda pair: float(pair[0].max()))
        yield float(off.max()), places[int(off.argmax())]


def _path(network: Network, signed: int, camera: Camera) -> Array:
    """Return the picture of an edge in the direction of the run, (k, 2) px.

    Both nodes are in view; what lies between them behind the eye is left out.
    """
    points = network.control_points[max(signed, ~signed)]
    pictured = Pictured.of(camera_matrix(camera), points if signed >= 0 else points[::-1])
    pixels = pictured.laid_out(PLACES)
    return np.asarray(pixels[(np.abs(pixels) <= FARTHEST).all(axis=1)])


def _beside(part: Array, path: Array) -> Flags:
    """Whether samples are nearer to the inside of a polyline than to either of its ends, (k,)."""
    away = np.linalg.norm(part[:, None] - path, axis=2).argmin(axis=1)
    return np.asarray((away > 0) & (away < len(path) - 1))
