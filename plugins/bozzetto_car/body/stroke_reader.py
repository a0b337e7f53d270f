"""What strokes along edges say: which edges they trace, where nodes go, and what still counts.

A stroke that was drawn over another one on the same sketch replaces it there; one in another view
of the car, which is a correction, counts a hundred times as much.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry.patches import bernstein
from bozzetto.ink import arc_length, distinct
from bozzetto.view import Camera
from bozzetto_car.body.dimension_map import Reshaping
from bozzetto_car.body.edge_pictures import UNSEEN
from bozzetto_car.body.edge_runs import Run, find_run
from bozzetto_car.body.stretch import stretch
from bozzetto_car.camera.rational_projection import (
    Pictured,
    camera_matrix,
    largest_scale,
    places_of,
    slopes_at,
)
from bozzetto_car.listening import look
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import Network

MOST_SAMPLES: Final = 48
"""Most samples of a stroke that a fit uses: a cubic has no finer detail."""

WORTH: Final = 20.0
"""Number of independent places, each known to a pixel, that a stroke along an edge counts as. A
hand errs in long waves, so that more samples tell no more."""

NEAR_END: Final = 0.25
"""Distance of the end of a stroke from a node, per length of the edge in the view, within which the
stroke is taken to end in the node."""

ALONG_END: Final = 1.0
"""Worth of the end of a stroke: a hand begins early and ends late, so that an end tells less."""

OVERRULED: Final = 0.01
"""Weight that is left to a stroke where an edge was traced again in a view of the car: it tells
what the later view does not show."""

REDRAWN: Final = 0.7
"""Share of a stroke from which a later one along the same edge replaces all of it."""

PIECES: Final = 20
"""Pieces of an edge for the decision whether it is seen."""

IN_PIECES: Final = bernstein(np.linspace(0.0, 1.0, PIECES + 1))


@dataclass(frozen=True, eq=False)
class Line:
    """A stroke that edges are to be seen along.

    Attributes
    ----------
    points : (k, 2) float
        Samples in either direction, px.
    camera : Camera
        The view that it was drawn in.
    edges : tuple of int
        The edges that are meant, in the order of the row that they make; the nearest if none.
    nodes_follow : bool
        Whether nodes that the stroke passes, or reaches with an end, go to it.
    sketch : str
        Id of the sketch that it was drawn on; "" for another view.
    map_ : Reshaping, optional
        From the network to the car that the camera shows.
    """

    points: Array
    camera: Camera
    edges: tuple[int, ...] = ()
    nodes_follow: bool = False
    sketch: str = ""
    map_: Reshaping | None = None


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a stroke along one edge, or along the mirror image of one.

    Attributes
    ----------
    number : int
        Of the stroke.
    edge, node : int
        The edge of the right half or the middle; see `Sighting`.
    flip : (3,) float
        Ones, or `MIRROR` where the stroke shows the image on the other side.
    points : (k, 2) float
    weights : (k,) float
    """

    number: int
    edge: int
    flip: Array
    points: Array
    weights: Array

    @property
    def is_mirrored(self) -> bool:
        """Whether it shows the left side."""
        return bool(self.flip[1] < 0.0)


@dataclass(frozen=True, eq=False)
class Goal:
    """A place of a stroke to which a node goes."""

    number: int
    node: int
    flip: Array
    pixel: Array
    weight: float = ALONG_END


@dataclass(frozen=True, eq=False)
class Said:
    """What strokes say that can be seen along edges.

    Attributes
    ----------
    runs : mapping of int to Run
        By the number of the stroke: the edges that it was taken to trace.
    problems : mapping of int to str
        Why other strokes say nothing.
    parts : tuple of Part
    goals : tuple of Goal
    """

    runs: Mapping[int, Run]
    problems: Mapping[int, str]
    parts: tuple[Part, ...]
    goals: tuple[Goal, ...]


class StrokeReader:
    """Strokes, and the template of the network that they are looked at on."""

    def __init__(self, template: Template, lines: tuple[Line, ...]) -> None:
        self.lines = lines
        self.own_nodes = np.arange(len(template.names))
        self.own_nodes[template.pairs[:, 1]] = template.pairs[:, 0]
        image = template.mirrored_edges
        self.own_edges = np.minimum(np.arange(len(image)), np.maximum(image, ~image))

    def said(self, seen_on: Network) -> Said:
        """Return what the strokes say where they are looked at on a network."""
        runs: dict[int, Run] = {}
        problems: dict[int, str] = {}
        parts: list[Part] = []
        goals: list[Goal] = []
        for number, line in enumerate(self.lines):
            look()
            there = seen_on if line.map_ is None else stretch(seen_on, line.map_)
            try:
                run, own = self._looked_at(number, line, there)
            except UserError as problem:
                problems[number] = problem.message
                continue
            runs[number] = run
            parts += own
            if line.nodes_follow:
                goals += self._goals(number, line, run, there)
        parts, goals = self._overruled(parts, goals, seen_on)
        order = self._in_order()
        parts.sort(key=lambda part: (part.edge, part.is_mirrored, order[part.number]))
        goals.sort(key=lambda goal: (goal.node, bool(goal.flip[1] < 0.0), order[goal.number]))
        return Said(runs, problems, tuple(parts), tuple(goals))

    def _in_order(self) -> dict[int, int]:
        """Return an order of the strokes in which it makes no difference when they were drawn."""
        keys = [
            (line.sketch, line.edges, line.points.shape, line.points.tobytes())
            for line in self.lines
        ]
        row = sorted(range(len(keys)), key=keys.__getitem__)
        return {number: place for place, number in enumerate(row)}

    def _looked_at(self, number: int, line: Line, there: Network) -> tuple[Run, list[Part]]:
        """Return the edges that a stroke traces, and its parts along those that are seen.

        Raises
        ------
        UserError
            If there are none.
        """
        run = find_run(there, line.points, line.camera, line.edges, directed=len(line.edges) != 1)
        if len(line.edges) == 1:
            run = _toward(run, there, line.camera)
        parts = []
        for signed, points in zip(run.edges, run.parts, strict=True):
            edge = max(signed, ~signed)
            if _is_seen(there, edge, line.camera):
                own = int(self.own_edges[edge])
                flip = np.ones(3) if own == edge else MIRROR
                parts.append(Part(number, own, flip, *_thinned(points)))
        if not parts:
            names = ", ".join(there.template.edge_names[max(edge, ~edge)] for edge in run.edges)
            raise UserError(
                f"The stroke runs along {names}, seen end-on from here: it cannot tell the shape. "
                "Turn the view and trace it again."
            )
        return run, parts

    def _goals(self, number: int, line: Line, run: Run, there: Network) -> Iterable[Goal]:
        """Yield where nodes of a run go: to places of the stroke that are near them."""
        pixels = [run.parts[0][0], *(part[-1] for part in run.parts)]
        matrix = camera_matrix(line.camera)
        places = there.positions[list(run.nodes)]
        seen = places_of(places @ matrix[:, :3].T + matrix[:, 3])
        lengths = [_length(there, max(edge, ~edge), matrix) for edge in run.edges]
        for at, (node, pixel) in enumerate(zip(run.nodes, pixels, strict=True)):
            beside = lengths[max(at - 1, 0) : at + 1]
            if np.linalg.norm(pixel - seen[at]) <= NEAR_END * min(beside):
                own = int(self.own_nodes[node])
                yield Goal(number, own, np.ones(3) if own == node else MIRROR, pixel)

    def _overruled(
        self, parts: list[Part], goals: list[Goal], seen_on: Network
    ) -> tuple[list[Part], list[Goal]]:
        """Return parts and goals of strokes with less weight where edges were traced again."""
        by_edge: dict[int, list[int]] = {}
        for at, part in enumerate(parts):
            by_edge.setdefault(part.edge, []).append(at)
        factors = {number: 1.0 for number in range(len(self.lines))}

        @lru_cache(None)
        def shares(at: int) -> Array:
            return self._shares(parts[at], seen_on)

        made: list[Part | None] = list(parts)
        for row in by_edge.values():
            for place, older in enumerate(row):
                kept, weights = parts[older], parts[older].weights
                for at, newer in enumerate(row[place + 1 :], place + 1):
                    again = any(self._is_replaced(parts[one], parts[newer]) for one in row[:at])
                    left = self._left(kept, parts[newer], again)
                    if left < 1.0:
                        along = _along(shares(older), shares(newer))
                        weights = np.where(along, left * weights, weights)
                        if along.all():
                            factors[kept.number] = min(factors[kept.number], left)
                if weights is not kept.weights:
                    made[older] = None if not weights.any() else Part(
                        kept.number, kept.edge, kept.flip, kept.points, weights
                    )  # fmt: skip
        ends = [
            Goal(goal.number, goal.node, goal.flip, goal.pixel, goal.weight * factor)
            for goal in goals
            if (factor := factors[goal.number]) > 0.0
        ]
        return [part for part in made if part is not None], ends

    def _left(self, older: Part, newer: Part, again: bool) -> float:
        """Return the weight that a part of a stroke keeps along a later one.

        One that was drawn again is meant to be followed, whatever other strokes say.
        """
        if older.number == newer.number:
            return 1.0
        if self._is_replaced(older, newer):
            return 0.0
        on_sketches = self.lines[older.number].sketch and self.lines[newer.number].sketch
        return 1.0 if on_sketches and not again else OVERRULED

    def _is_replaced(self, older: Part, newer: Part) -> bool:
        """Whether two strokes are on one sketch, and on the same side of the car."""
        was, now = self.lines[older.number].sketch, self.lines[newer.number].sketch
        is_same_side = older.is_mirrored == newer.is_mirrored
        return bool(was) and was == now and is_same_side and older.number != newer.number

    def _shares(self, part: Part, seen_on: Network) -> Array:
        """Return the parameters of the edge's places that are seen nearest to samples, (k,)."""
        line = self.lines[part.number]
        matrices = edge_matrices(part.edge, part.flip, line, seen_on)
        points = np.append(seen_on.control_points[part.edge], np.ones((4, 1)), axis=1)
        path = places_of(IN_PIECES @ (matrices @ points[..., None])[..., 0])
        return np.asarray(
            np.linalg.norm(part.points[:, None] - path, axis=2).argmin(axis=1) / PIECES
        )


def _along(older: Array, newer: Array) -> Flags:
    """Whether samples (k,) of a stroke are on the stretch of the edge of a later one, (k,)."""
    along = (older >= newer.min()) & (older <= newer.max())
    return np.ones_like(along) if along.mean() >= REDRAWN else along


def _toward(run: Run, network: Network, camera: Camera) -> Run:
    """Return a run along one edge in the direction of its stroke."""
    ends = np.asarray(camera.project(network.positions[list(run.nodes)])[0])
    first = run.parts[0][[0, -1]]
    if np.linalg.norm(first - ends) <= np.linalg.norm(first[::-1] - ends):
        return run
    return Run((~run.edges[0],), run.nodes[::-1], run.parts, run.distance)


def _thinned(samples: Array) -> tuple[Array, Array]:
    """Return samples thinned out, and weights by the lengths that they stand for."""
    points = samples[distinct(samples)]
    if len(points) > MOST_SAMPLES:
        points = points[np.linspace(0, len(points) - 1, MOST_SAMPLES).round().astype(int)]
    lengths = np.hypot(*np.diff(points, axis=0).T)
    share = np.zeros(len(points))
    share[:-1] += lengths
    share[1:] += lengths
    whole = share.sum()
    weights = share / whole if whole > 0.0 else np.full(len(points), 1.0 / len(points))
    return points, WORTH * weights


def edge_matrices(edge: int, flip: Array, line: Line, seen_on: Network) -> Array:
    """Return the matrix of a stroke's camera for each Bézier point of an edge, (4, 3, 4)."""
    if line.map_ is None:
        return np.broadcast_to(camera_matrix(line.camera) * np.append(flip, 1.0), (4, 3, 4))
    start, end = seen_on.template.edges[edge].tolist()
    first, last = (node_matrix(node, flip, line, seen_on) for node in (start, end))
    return np.stack((first, first, last, last))


def node_matrix(node: int, flip: Array, line: Line, seen_on: Network) -> Array:
    """Return the matrix (3, 4) of a stroke's camera at a node of the right half or the middle.

    A map of the car is linear there, as it is for tangents; see `stretch`.
    """
    matrix = camera_matrix(line.camera)
    if line.map_ is not None:
        place = seen_on.positions[node] * flip
        slopes = line.map_.tangents(np.ones(3), place)
        at = matrix[:, :3] @ (line.map_.points(place) - slopes * place) + matrix[:, 3]
        matrix = np.column_stack((matrix[:, :3] * slopes, at))
    return np.asarray(matrix * np.append(flip, 1.0))


def _is_seen(network: Network, edge: int, camera: Camera) -> bool:
    """Whether an edge is long enough in the view for its picture to tell its shape."""
    matrix, points = camera_matrix(camera), network.control_points[edge]
    curve = IN_PIECES @ points
    scale = float(largest_scale(slopes_at(matrix, curve[PIECES // 2])))
    return _length(network, edge, matrix) >= UNSEEN * scale * float(arc_length(curve)[-1])


def _length(network: Network, edge: int, matrix: Array) -> float:
    """Return the length of the picture of an edge, px."""
    pictured = Pictured.of(matrix, network.control_points[edge])
    return float(arc_length(pictured.laid_out(PIECES))[-1])
