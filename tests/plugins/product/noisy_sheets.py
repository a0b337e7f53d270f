"""Sheets of patches on known surfaces, with the noise of a hand on the curves of their middle."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from bozzetto.geometry import Spline
from bozzetto_product.network.net import Edge, Loop, Net
from tests.plugins.product.known_surfaces import KnownSurface, ellipsoid, fitted, graph, torus

ROWS = 4
"""Patches along each side of a sheet; the middle ones are the group."""


@dataclass(frozen=True)
class NoisySheet:
    """A sheet; the curves between its middle patches have noise, all others are true."""

    name: str
    surface: KnownSurface
    net: Net
    loops: tuple[Loop, ...]
    members: frozenset[int]
    diagonal: float
    """Of the group, in the units of the surface."""


def noisy_sheet(name: str, surface: KnownSurface, chart: Callable, noise: float, seed: int):
    """Return a sheet over a chart of the unit square.

    Parameters
    ----------
    noise : float
        Standard deviation of inner joints, and twice that of the inner control points of curves
        between them, per diagonal of a patch.
    """
    random = np.random.default_rng(seed)
    share = np.linspace(0, 1, ROWS + 1)
    flat = np.array([(a, b) for a in share for b in share])

    def lifted(q):
        return surface.lift(chart(q))

    nodes = lifted(flat)
    inside = (flat > 0.3).all(axis=1) & (flat < 0.7).all(axis=1)
    within = (flat > 0.2).all(axis=1) & (flat < 0.8).all(axis=1)
    diagonal = float(np.linalg.norm(np.ptp(nodes[within], axis=0)))
    step = noise * diagonal / 2 / np.sqrt(3)
    nodes[inside] += step * random.normal(size=(int(inside.sum()), 3))
    edges = []
    for i, j in np.ndindex(ROWS + 1, ROWS + 1):
        for di, dj in ((1, 0), (0, 1)):
            if i + di > ROWS or j + dj > ROWS:
                continue
            a, b = i * (ROWS + 1) + j, (i + di) * (ROWS + 1) + j + dj
            t = np.linspace(0, 1, 129)[:, None]
            curve = fitted(lifted(flat[a] + t * (flat[b] - flat[a])))
            points = curve.control_points.copy()
            if inside[a] or inside[b]:
                along = np.linspace(0, 1, len(points))[:, None]
                points += (1 - along) * (nodes[a] - points[0]) + along * (nodes[b] - points[-1])
                points[1:-1] += 0.5 * step * random.normal(size=(len(points) - 2, 3))
            points[0], points[-1] = nodes[a], nodes[b]
            edges.append(Edge(Spline(curve.knots, points), a, b, f"c{len(edges)}"))
    numbers = {(edge.start, edge.end): k for k, edge in enumerate(edges)}
    loops, members = [], set()
    for i, j in np.ndindex(ROWS, ROWS):
        a, b = i * (ROWS + 1) + j, (i + 1) * (ROWS + 1) + j
        ring = ((a, b, True), (b, b + 1, True), (a + 1, b + 1, False), (a, a + 1, False))
        if {i, j} <= {1, 2}:
            members.add(len(loops))
        loops.append(tuple((numbers[x, y], way) for x, y, way in ring))
    net = Net(nodes, tuple(edges), (("", False),) * len(nodes))
    return NoisySheet(name, surface, net, tuple(loops), frozenset(members), diagonal)


def sheets(noise: float, seed: int) -> Iterator[NoisySheet]:
    """Yield sheets on an ellipsoid, a torus, a saddle and a wave, each of its own proportions."""
    random = np.random.default_rng(seed)
    a, b, c = random.uniform(0.8, 1.3, 3)
    wide = random.uniform(1.0, 1.5)

    def square(q):
        return wide * (q - 0.5)

    def ring(q):
        return np.column_stack((1.5 * q[:, 0], -0.8 + 1.8 * q[:, 1]))

    yield noisy_sheet("ellipsoid", ellipsoid(1.2 * a, b + 0.2, 0.7 * c), square, noise, seed)
    yield noisy_sheet("torus", torus(1.0, 0.3 + 0.1 * a), ring, noise, seed)
    saddle = graph(lambda x, y: 0.4 * a * x * y + 0.2 * b * x**2)
    yield noisy_sheet("saddle", saddle, square, noise, seed)
    wave = graph(lambda x, y: 0.2 * a * np.sin(1.6 * x) * np.cos(1.2 * b * y))
    yield noisy_sheet("wave", wave, square, noise, seed)
