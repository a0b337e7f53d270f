"""Pressure on a membrane of triangles (Kara & Shimada, book chapter, section 13.2.3.2).

Each vertex is moved along its normal by the pressure times its Voronoi area, and held back toward
the mean of its neighbours. At rest both are equal:

    γ (v_i − mean of neighbours of v_i) = ξ p A_i n_i.

What holds a vertex back counts here from the surface without pressure, so nothing jumps where a
slider leaves 0; over a plane outline the two are the same. The state at rest is found by solving
the left side for all vertices at once and turning the load to the new normals, not by the chapter's
small steps. The pressure is the one that presses out a given volume: beyond the half ball a film
holds more volume at less pressure, where steps at a given pressure do not end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index, cross_product
from bozzetto_product.paper.neighbours import held_back, neighbour_means
from bozzetto_product.paper.triangulation import Triangles
from bozzetto_product.paper.v_spring import vertex_normals
from bozzetto_product.shaping.volume import size_for

STEP: Final = 0.06
"""Largest volume of one step, as share of the cube of the surface's size."""

ROUNDS: Final = 60
"""Most solves at one volume."""

RELAXATION: Final = 0.8
"""Share of the way that is gone at once; the whole way swings."""

SETTLED: Final = 1e-5
"""Move, as share of the size, at which the membrane is at rest."""


@dataclass(frozen=True, eq=False)
class Pressed:
    """A membrane under pressure.

    Parameters
    ----------
    points : (n, 3) float
        mm.
    pressure : float
        ξ p / γ of the equation above, 1 / mm.
    limited : bool
        No pressure presses out the volume asked for; this is as far as it went.
    """

    points: Array
    pressure: float
    limited: bool


def voronoi_areas(points: Array, faces: Index) -> Array:
    """Return the area about each vertex, (n,); mm².

    Within the Voronoi cell where a triangle is acute; of an obtuse one half belongs to its wide
    corner and a quarter to each other one (Meyer, Desbrun, Schröder & Barr 2003, section 3.3).
    """
    corners = points[faces]
    ways = np.roll(corners, -1, axis=1) - corners
    squares = (ways**2).sum(axis=2)
    whole = 0.5 * np.linalg.norm(cross_product(ways[:, 0], ways[:, 1]), axis=1)
    dots = -(ways * np.roll(ways, 1, axis=1)).sum(axis=2)
    cotangents = dots / np.maximum(2.0 * whole, 1e-300)[:, None]
    # Of each corner: the edge to the next one faces the corner before it, and the other way round.
    onward = squares * np.roll(cotangents, 1, axis=1)
    back = np.roll(squares, 1, axis=1) * np.roll(cotangents, -1, axis=1)
    shares = (onward + back) / 8.0
    wide = dots < 0.0
    obtuse = wide.any(axis=1)
    halves = np.where(wide, 0.5, 0.25) * whole[:, None]
    shares[obtuse] = halves[obtuse]
    return np.asarray(np.bincount(faces.ravel(), shares.ravel(), len(points)), float)


def pressed(
    mesh: Triangles, volume: float, *, checkpoint: Callable[[], None] = lambda: None
) -> Pressed:
    """Return a membrane that holds a volume over the surface without pressure.

    Parameters
    ----------
    mesh : Triangles
        Without pressure; its border stays.
    volume : float
        mm³, positive to the side of its normals.
    checkpoint : callable
        Called before each solve.
    """
    rest = mesh.points
    if volume == 0.0 or not np.isfinite(volume):
        return Pressed(rest, 0.0, limited=False)
    size = float(np.linalg.norm(np.ptp(rest, axis=0)))
    origin = rest.mean(axis=0)
    solved = held_back(neighbour_means(mesh.faces, len(rest)), mesh.border)
    free = slice(mesh.border, None)
    points, pressure = rest, 0.0
    scale = volume / size**3
    for goal in _goals(scale):
        before = points, pressure
        for _ in range(ROUNDS):
            checkpoint()
            load = voronoi_areas(points, mesh.faces)[:, None] * vertex_normals(points, mesh.faces)
            way = np.zeros_like(rest)
            way[free] = solved(load[free])
            over = _volume_by(rest - origin, way, mesh.faces, size)
            # Under an even load a way of one size presses out its height times the area.
            found = size_for(over, goal, pressure or goal / (over(1e-9) / 1e-9))
            if found is None:
                return Pressed(before[0], before[1], limited=True)
            pressure = found
            move = rest + pressure * way - points
            points = points + RELAXATION * move
            if not float(np.abs(move).max()) > SETTLED * size:
                break
        points = rest + pressure * way
    return Pressed(points, pressure, limited=False)


def _goals(wanted: float) -> Iterator[float]:
    count = max(int(np.ceil(abs(wanted) / STEP - 1e-9)), 1)
    for number in range(1, count + 1):
        yield wanted * number / count


def _volume_by(points: Array, way: Array, faces: Index, size: float) -> Callable[[float], float]:
    """Return the volume between points and points moved by a way, by its size; a cubic."""

    def under(places: Array) -> float:
        a, b, c = (places[faces[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, cross_product(b, c))) / (6.0 * size**3)

    start = under(points)
    return lambda scale: under(points + scale * way) - start
