"""Loops on surfaces that are known exactly, to judge fills by."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import make_lsq_spline

from bozzetto.geometry import Spline
from bozzetto_product.fill.corners import loop_corners
from bozzetto_product.fill.edge_pieces import pieces_of
from bozzetto_product.fill.fill import Fill
from bozzetto_product.fill.loop_fill import fill_loop
from bozzetto_product.fill.loop_sides import piece_count, sides_of_loop
from bozzetto_product.fill.normal_field import NormalField, frame_parameters
from bozzetto_product.fill.normals import LoopNormals, common_fields, fitted_to_corners
from bozzetto_product.network.net import Edge, Loop, Net


@dataclass(frozen=True)
class KnownSurface:
    """A surface given as the places where a function is nought, and how a chart is laid on it."""

    function: Callable[[np.ndarray], np.ndarray]
    lift: Callable[[np.ndarray], np.ndarray]
    step: float = 1e-5

    def gradient(self, x):
        axes = self.step * np.eye(3)
        return np.stack(
            [(self.function(x + e) - self.function(x - e)) / (2 * self.step) for e in axes], axis=-1
        )

    def normal(self, x):
        g = self.gradient(x)
        return g / np.linalg.norm(g, axis=-1, keepdims=True)

    def distance(self, x):
        """To first order."""
        return np.abs(self.function(x)) / np.linalg.norm(self.gradient(x), axis=-1)


def ellipsoid(a, b, c):
    def lift(q):
        z = c * np.sqrt(np.maximum(1 - (q[:, 0] / a) ** 2 - (q[:, 1] / b) ** 2, 1e-9))
        return np.column_stack((q, z))

    return KnownSurface(
        lambda x: (x[..., 0] / a) ** 2 + (x[..., 1] / b) ** 2 + (x[..., 2] / c) ** 2 - 1, lift
    )


def torus(big, small):
    def lift(q):
        u, v = q.T
        ring = big + small * np.cos(v)
        return np.column_stack((ring * np.cos(u), ring * np.sin(u), small * np.sin(v)))

    return KnownSurface(
        lambda x: np.hypot(np.hypot(x[..., 0], x[..., 1]) - big, x[..., 2]) - small, lift
    )


def graph(f):
    return KnownSurface(
        lambda x: x[..., 2] - f(x[..., 0], x[..., 1]),
        lambda q: np.column_stack((q, f(q[:, 0], q[:, 1]))),
    )


@dataclass(frozen=True)
class KnownLoop:
    name: str
    surface: KnownSurface
    net: Net
    loop: Loop

    @property
    def diagonal(self):
        return float(
            np.linalg.norm(
                np.ptp(np.concatenate([edge.spline.sampled(33) for edge in self.net.edges]), axis=0)
            )
        )


def fitted(points, controls=7):
    """Cubic spline of so many control points nearest to a dense chain, through its ends."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = np.concatenate(((0.0,), np.cumsum(steps) / steps.sum()))
    at[-1] = 1.0
    knots = np.concatenate((np.zeros(3), np.linspace(0, 1, controls - 2), np.ones(3)))
    found = make_lsq_spline(at, points, knots, 3).c
    found[[0, -1]] = points[[0, -1]]
    return Spline(knots, found)


def net_of_splines(splines):
    """One loop of open curves, head to tail."""
    nodes = np.array([spline.control_points[0] for spline in splines])
    count = len(splines)
    edges = []
    for number, spline in enumerate(splines):
        points = spline.control_points.copy()
        points[0], points[-1] = nodes[number], nodes[(number + 1) % count]
        curve = Spline(spline.knots, points)
        edges.append(Edge(curve, number, (number + 1) % count, f"c{number}"))
    return Net(nodes, tuple(edges)), tuple((number, True) for number in range(count))


def loop_on(name, surface, corners, lift=None, controls=7):
    """Curves that are straight in the chart."""
    t = np.linspace(0, 1, 129)[:, None]
    lift = lift or surface.lift
    chains = [
        lift(a * (1 - t) + b * t) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)
    ]
    net, loop = net_of_splines([fitted(chain, controls) for chain in chains])
    return KnownLoop(name, surface, net, loop)


def polygon(count, start, x=1.0, y=1.0):
    turn = 2 * np.pi * np.arange(count) / count + start
    return np.column_stack((x * np.cos(turn), y * np.sin(turn)))


def analytic_loops():
    """Fifteen loops on spheres, ellipsoids, a torus, saddles and waves."""
    sphere, egg = ellipsoid(1, 1, 1), ellipsoid(1, 0.7, 0.5)
    unit = lambda x: x / np.linalg.norm(x, axis=1, keepdims=True)  # noqa: E731
    onto = lambda x: x / np.sqrt((x**2 / (1, 0.49, 0.25)).sum(axis=1, keepdims=True))  # noqa: E731
    cap = np.array([[1, -0.6, -0.6], [1, 0.6, -0.6], [1, 0.6, 0.6], [1, -0.6, 0.6]])
    made = [
        loop_on("sphere octant", sphere, np.eye(3), unit),
        loop_on("sphere cap", sphere, cap, unit),
    ]
    for count, radius in ((5, 0.6), (6, 0.8), (8, 0.8), (12, 0.8)):
        flat = polygon(count, 0.2, radius, 0.7 * radius)
        corners = np.column_stack((flat, np.full(count, 0.5 * np.sqrt(1 - radius**2))))
        made.append(loop_on(f"ellipsoid {count}", egg, corners, onto))
    flat = np.array([[0.8, -0.4], [0.8, 0.45], [0.1, 0.05], [-0.7, 0.5], [-0.75, -0.4], [0, -0.25]])
    height = 0.5 * np.sqrt(1 - np.minimum(0.9, (flat**2).sum(axis=1)))
    corners = np.column_stack((flat * (1, 0.7), height))
    made.append(loop_on("ellipsoid concave", egg, corners, onto))
    ring = torus(1, 0.4)
    q = np.pi / 4
    for name, low, high in (("outer", -q, q), ("upper", 0, 2 * q), ("inner", 3 * q, 5 * q)):
        chart = np.array([[0, low], [2 * q, low], [2 * q, high], [0, high]])
        made.append(loop_on(f"torus {name}", ring, chart))
    saddle = graph(lambda x, y: 0.5 * x * y + 0.2 * x**2)
    wave = graph(lambda x, y: 0.3 * np.sin(2 * x) * np.cos(1.5 * y))
    made += [loop_on(f"saddle {n}", saddle, polygon(n, 0.3, 1, 0.8)) for n in (3, 5, 7)]
    made += [loop_on(f"wave {n}", wave, polygon(n, 0.3, 1, 0.8)) for n in (4, 6)]
    return made


def random_loop(seed):
    """A loop of 3 to 12 sides on a random quadric, torus, saddle or wave; a third are concave."""
    random = np.random.default_rng(seed)
    count = int(random.integers(3, 13))
    kind = ("quadric", "torus", "saddle", "wave")[seed % 4]
    turn = 2 * np.pi * (np.arange(count) + random.uniform(-0.25, 0.25, count)) / count
    radius = random.uniform(0.8, 1.0, count)
    concave = count >= 5 and seed % 3 == 0
    if concave:
        bent = random.choice(count, max(1, count // 5), replace=False)
        radius[bent] *= 0.5
    chart = radius[:, None] * np.column_stack((np.cos(turn), np.sin(turn)))
    if kind == "quadric":
        axes = random.uniform(0.6, 1.4, 3)
        surface, chart = ellipsoid(*axes), 0.8 * chart * axes[:2]
    elif kind == "torus":
        surface = torus(1.0, random.uniform(0.25, 0.6))
        chart = chart * (random.uniform(0.4, 0.8), random.uniform(0.5, 0.9))
        chart[:, 1] += random.uniform(0, 2 * np.pi)
        side = surface.lift(chart)
        if (
            np.cross(side[1] - side[0], side[2] - side[1]) @ surface.normal(side[1]) < 0
            and not concave
        ):
            chart = chart[::-1]
    elif kind == "saddle":
        a, b, c = random.uniform(-0.5, 0.5, 3)
        surface = graph(lambda x, y: a * x * y + b * x**2 + c * y**2)
    else:
        a, b = random.uniform(0.1, 0.25), random.uniform(1.0, 2.0, 2)
        surface = graph(lambda x, y: a * np.sin(b[0] * x) * np.cos(b[1] * y))
    name = f"{kind} {count}{' concave' if concave else ''} ({seed})"
    return loop_on(name, surface, chart)


def oriented_normals(known):
    """Corner normals of the loop on the side to which it runs counter-clockwise."""
    return loop_corners(known.net, known.loop)


def true_normals(known):
    """The surface's own normals along the loop's edges."""
    corners = oriented_normals(known)
    votes = sum(
        float(known.surface.normal(known.net.nodes[k]) @ corner.normal)
        for k, corner in enumerate(corners)
    )
    sign = 1.0 if votes >= 0 else -1.0
    fields = []
    for edge in known.net.edges:
        begin, end = edge.spline.range
        at = np.linspace(begin, end, 8 * len(frame_parameters(edge.spline)))
        normals = sign * known.surface.normal(edge.spline.value(at))
        fields.append(NormalField(edge.spline, at, normals))
    return LoopNormals(tuple(corners), tuple(fields))


def estimated_normals(known):
    """Normals from the corners, carried along the edges."""
    corners = oriented_normals(known)
    uses = {edge: [(0, place, forward)] for place, (edge, forward) in enumerate(known.loop)}
    fields = common_fields(known.net, [known.loop], [corners], uses)
    return LoopNormals(tuple(corners), tuple(fields[edge] for edge, _ in known.loop))


def filled(known, normals) -> Fill:
    """The surface of a loop with these normals, which the corners' own planes hold at its ends."""
    ends = zip(normals.corners, (*normals.corners[1:], normals.corners[0]), strict=True)
    fields = tuple(
        None if field is None else fitted_to_corners(field, pair, True)
        for field, pair in zip(normals.fields, ends, strict=True)
    )
    normals = LoopNormals(normals.corners, fields)
    count = piece_count(normals.corners)
    pieces = [pieces_of(edge.spline, count) for edge in known.net.edges]
    return fill_loop(sides_of_loop(known.loop, normals, pieces), loop=known.loop)


def points_of(fill, count=15):
    at = np.linspace(0, 1, count)
    u, v = (x.ravel() for x in np.meshgrid(at, at, indexing="ij"))
    return np.concatenate([patch.value(u, v) for patch in fill.patches])


def error_percent(known, fill):
    """Mean distance from the known surface, % of the loop's diagonal."""
    return 100 * float(known.surface.distance(points_of(fill)).mean()) / known.diagonal
