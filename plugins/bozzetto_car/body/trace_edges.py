"""Trace edges: bend them to strokes along the picture of the car, from any side."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags
from bozzetto.errors import UserError
from bozzetto.geometry.patches import bernstein, joint_rows
from bozzetto.ink import FARTHEST, arc_length, distances_to_polyline, distinct
from bozzetto.plugin import cached_property
from bozzetto.view import Camera
from bozzetto_car.body.chain_smoothing import smooth_chains, smooth_joints
from bozzetto_car.body.dimension_map import Reshaping
from bozzetto_car.body.drag import drag_place
from bozzetto_car.body.edge_pictures import UNSEEN
from bozzetto_car.body.edge_runs import Run, find_run
from bozzetto_car.body.joint_fit import JointFit, SeenNode, SharedJoint, Sighting, node_axes
from bozzetto_car.body.stretch import stretch
from bozzetto_car.camera.rational_projection import (
    Pictured,
    camera_matrix,
    largest_scale,
    places_of,
    slopes_at,
)
from bozzetto_car.listening import look
from bozzetto_car.solver.prior import DEVIATION
from bozzetto_car.template.model import MIRROR
from bozzetto_car.template.network import Network, junctions, with_positions, with_tangents

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

PLACES: Final = 100
"""Pieces of an edge where lengths and distances on the sheet are measured."""


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
class Fitted:
    """A network after strokes.

    Attributes
    ----------
    network : Network
    runs : mapping of int to Run
        By the number of the stroke: the edges that it was taken to trace.
    problems : mapping of int to str
        Why other strokes were left out.
    """

    network: Network
    runs: Mapping[int, Run]
    problems: Mapping[int, str]


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


def trace(
    network: Network,
    stroke: ArrayLike,
    camera: Camera,
    *,
    edges: Sequence[int] = (),
    nodes_follow: bool = False,
) -> Traced:
    """Bend the edges that a stroke runs along until they are seen where it is; see `trace_all`.

    Parameters
    ----------
    network : Network
        The network to change.
    stroke : (k, 2) array_like
        Samples of the stroke, px, in either direction.
    camera : Camera
        The view that the stroke was drawn in.
    edges : sequence of int, optional
        The edges that are meant, in the order of the row that they make; by default the
        nearest ones.
    nodes_follow : bool
        Nodes that the stroke passes, or reaches with an end, go to it, parallel to the image
        plane. Otherwise no node moves.

    Raises
    ------
    UserError
        If the stroke runs along no edge, or along nothing but edges that are seen end-on.
    """
    line = Line(np.asarray(stroke, float), camera, tuple(edges), nodes_follow)
    made = trace_all(network, (line,))
    if made.problems:
        raise UserError(made.problems[0])
    return Traced(made.network, made.runs[0], camera)


def trace_all(
    network: Network,
    lines: Sequence[Line],
    *,
    even: bool = True,
    information: Array | None = None,
) -> Fitted:
    """Bend the edges that strokes run along until they are seen along all of them.

    All strokes are fitted at once, so their order has no say, unless one traces again what another
    one has traced. On the same sketch the later one replaces the stretch that it runs along. It
    is then meant as a correction, as one in another view of the car is, and counts a hundred times
    as much as what was drawn along that stretch before. Strokes on two sketches, or on both sides
    of the car, count alike.

    A node that one stroke reaches goes to it, parallel to the image plane. One that several reach
    goes to where all of them, and what was known of it, are met best. Neighbours in smooth chains
    take the new directions and keep the lengths of their tangents. The other side of the car
    follows.

    Parameters
    ----------
    network : Network
        The network to change.
    lines : sequence of Line
        The strokes in the order in which they were drawn.
    even : bool
        Whether joints that make smooth surfaces share one ratio of the lengths of tangents.
    information : (q, q) float, optional
        Information about the variables of the car, mm⁻²: what moving a node costs.
    """
    fit = _Fit(network, tuple(lines), even, information)
    first = fit.made(network)
    return fit.made(first.network) if fit.depends_on_network(first) else first


@dataclass(frozen=True, eq=False)
class _Part:
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
class _Goal:
    """A place of a stroke to which a node goes."""

    number: int
    node: int
    flip: Array
    pixel: Array
    weight: float = ALONG_END


class _Fit:
    """Strokes and the network before them."""

    def __init__(
        self, network: Network, lines: tuple[Line, ...], even: bool, information: Array | None
    ) -> None:
        self.network, self.lines, self.even, self.information = network, lines, even, information
        template = network.template
        self.own_nodes = np.arange(len(template.names))
        self.own_nodes[template.pairs[:, 1]] = template.pairs[:, 0]
        image = template.mirrored_edges
        self.own_edges = np.minimum(np.arange(len(image)), np.maximum(image, ~image))

    def depends_on_network(self, first: Fitted) -> bool:
        """Whether moved nodes change how strokes are split, or how they are seen in a stretch."""
        if first.network is self.network or not any(line.nodes_follow for line in self.lines):
            return False
        return any(
            self.lines[number].map_ is not None or len(run.edges) > 1
            for number, run in first.runs.items()
        )

    def made(self, seen_on: Network) -> Fitted:
        """Return the network after all strokes, which are looked at on another network."""
        runs: dict[int, Run] = {}
        problems: dict[int, str] = {}
        parts: list[_Part] = []
        goals: list[_Goal] = []
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
        if not parts:
            return Fitted(self.network, runs, problems)
        order = self._in_order()
        parts.sort(key=lambda part: (part.edge, part.is_mirrored, order[part.number]))
        goals.sort(key=lambda goal: (goal.node, bool(goal.flip[1] < 0.0), order[goal.number]))
        return Fitted(self._fitted(parts, goals, runs, seen_on), runs, problems)

    def _in_order(self) -> dict[int, int]:
        """Return an order of the strokes in which it makes no difference when they were drawn."""
        keys = [
            (line.sketch, line.edges, line.points.shape, line.points.tobytes())
            for line in self.lines
        ]
        row = sorted(range(len(keys)), key=keys.__getitem__)
        return {number: place for place, number in enumerate(row)}

    # -- what strokes say --

    def _looked_at(self, number: int, line: Line, there: Network) -> tuple[Run, list[_Part]]:
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
                parts.append(_Part(number, own, flip, *_thinned(points)))
        if not parts:
            names = ", ".join(there.template.edge_names[max(edge, ~edge)] for edge in run.edges)
            raise UserError(
                f"The stroke runs along {names}, seen end-on from here: it cannot tell the shape. "
                "Turn the view and trace it again."
            )
        return run, parts

    def _goals(self, number: int, line: Line, run: Run, there: Network) -> Iterable[_Goal]:
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
                yield _Goal(number, own, np.ones(3) if own == node else MIRROR, pixel)

    def _overruled(
        self, parts: list[_Part], goals: list[_Goal], seen_on: Network
    ) -> tuple[list[_Part], list[_Goal]]:
        """Return parts and goals of strokes with less weight where edges were traced again."""
        by_edge: dict[int, list[int]] = {}
        for at, part in enumerate(parts):
            by_edge.setdefault(part.edge, []).append(at)
        factors = {number: 1.0 for number in range(len(self.lines))}

        @lru_cache(None)
        def shares(at: int) -> Array:
            return self._shares(parts[at], seen_on)

        made: list[_Part | None] = list(parts)
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
                    made[older] = None if not weights.any() else _Part(
                        kept.number, kept.edge, kept.flip, kept.points, weights
                    )  # fmt: skip
        ends = [
            _Goal(goal.number, goal.node, goal.flip, goal.pixel, goal.weight * factor)
            for goal in goals
            if (factor := factors[goal.number]) > 0.0
        ]
        return [part for part in made if part is not None], ends

    def _left(self, older: _Part, newer: _Part, again: bool) -> float:
        """Return the weight that a part of a stroke keeps along a later one.

        One that was drawn again is meant to be followed, whatever other strokes say.
        """
        if older.number == newer.number:
            return 1.0
        if self._is_replaced(older, newer):
            return 0.0
        on_sketches = self.lines[older.number].sketch and self.lines[newer.number].sketch
        return 1.0 if on_sketches and not again else OVERRULED

    def _is_replaced(self, older: _Part, newer: _Part) -> bool:
        """Whether two strokes are on one sketch, and on the same side of the car."""
        was, now = self.lines[older.number].sketch, self.lines[newer.number].sketch
        is_same_side = older.is_mirrored == newer.is_mirrored
        return bool(was) and was == now and is_same_side and older.number != newer.number

    def _shares(self, part: _Part, seen_on: Network) -> Array:
        """Return the parameters of the edge's places that are seen nearest to samples, (k,)."""
        line = self.lines[part.number]
        matrices = _matrices(part.edge, part.flip, line, seen_on)
        points = np.append(seen_on.control_points[part.edge], np.ones((4, 1)), axis=1)
        path = places_of(IN_PIECES @ (matrices @ points[..., None])[..., 0])
        return np.asarray(
            np.linalg.norm(part.points[:, None] - path, axis=2).argmin(axis=1) / PIECES
        )

    # -- the network --

    def _fitted(
        self, parts: list[_Part], goals: list[_Goal], runs: Mapping[int, Run], seen_on: Network
    ) -> Network:
        network = self.network
        counts: dict[int, set[int]] = {}
        for goal in goals:
            counts.setdefault(goal.node, set()).add(goal.number)
        alone = [goal for goal in goals if len(counts[goal.node]) == 1]
        if alone:
            network = with_positions(network, self._placed(alone))
        shared = [goal for goal in goals if len(counts[goal.node]) > 1]
        fit = JointFit(
            network,
            [
                Sighting(
                    part.edge, part.points, part.weights,
                    _matrices(part.edge, part.flip, self.lines[part.number], seen_on),
                )
                for part in parts
            ],
            self._joints({part.edge for part in parts}),
            [
                SeenNode(
                    goal.node, goal.pixel,
                    _matrix(goal.node, goal.flip, self.lines[goal.number], seen_on), goal.weight,
                )
                for goal in shared
            ],
            self._cost_of_moving(sorted({goal.node for goal in shared})),
        )  # fmt: skip
        found = fit.solved()
        if found is None:
            return network
        places: dict[int, Array] = {}
        for (node, axis), value in zip(fit.node_axes, found[0].tolist(), strict=True):
            places.setdefault(node, network.positions[node].copy())[axis] = value
        made = with_positions(network, places) if places else network
        made = with_tangents(made, {
            (edge, end): found[1][number, end]
            for number, edge in enumerate(fit.edges) for end in (0, 1)
            if not np.array_equal(found[1][number, end], network.tangents[edge, end])
        })  # fmt: skip
        nodes = {node for run in runs.values() for node in run.nodes}
        return smooth_chains(made, leading=fit.edges, nodes=nodes)

    def _placed(self, goals: Iterable[_Goal]) -> dict[int, Array]:
        """Return nodes, which one stroke reaches, at the places that belong to them there."""
        network, found = self.network, dict[int, list[Array]]()
        for goal in goals:
            line = self.lines[goal.number]
            place = network.positions[goal.node]
            there = place if line.map_ is None else line.map_.points(place)
            free = np.array([True, bool(network.template.mirrored[goal.node] != goal.node), True])
            moved = drag_place(there * goal.flip, goal.pixel, line.camera, free) * goal.flip
            back = moved if line.map_ is None else line.map_.points_before(moved)
            found.setdefault(goal.node, []).append(back)
        return {node: np.mean(places, axis=0) for node, places in found.items()}

    def _joints(self, traced: set[int]) -> list[SharedJoint]:
        """Return the smooth joints between two traced edges of the right half or the middle."""
        template = self.network.template
        left = set(template.pairs[:, 1].tolist())
        rows = joint_rows(template.sides, smooth_joints(template)) if self.even else ()
        row_of = {
            number: (at, sense) for at, row in enumerate(rows) for number, sense in row.items()
        }
        return [
            SharedJoint(joint, *row_of.get(number, (len(rows) + number, 1.0)))
            for number, joint in enumerate(junctions(template))
            if not joint.crosses and joint.node not in left
            and traced.issuperset((joint.before[0], joint.after[0]))
        ]  # fmt: skip

    def _cost_of_moving(self, nodes: Sequence[int]) -> Array:
        axes = node_axes(self.network, nodes)
        if self.information is None:
            return np.eye(len(axes)) / DEVIATION**2
        first = np.argmax(self.network.template.basis == 1.0, axis=0).tolist()
        found = {divmod(row, 3): number for number, row in enumerate(first)}
        own = [found[key] for key in axes]
        return np.asarray(self.information[np.ix_(own, own)])


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


def _matrices(edge: int, flip: Array, line: Line, seen_on: Network) -> Array:
    """Return the matrix of a stroke's camera for each Bézier point of an edge, (4, 3, 4)."""
    if line.map_ is None:
        return np.broadcast_to(camera_matrix(line.camera) * np.append(flip, 1.0), (4, 3, 4))
    start, end = seen_on.template.edges[edge].tolist()
    first, last = (_matrix(node, flip, line, seen_on) for node in (start, end))
    return np.stack((first, first, last, last))


def _matrix(node: int, flip: Array, line: Line, seen_on: Network) -> Array:
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


def _path(network: Network, signed: int, camera: Camera) -> Array:
    """Return the picture of an edge in the direction of the run, (k, 2) px.

    Both nodes are in view; what lies between them behind the eye is left out.
    """
    points = network.control_points[max(signed, ~signed)]
    pictured = Pictured.of(camera_matrix(camera), points if signed >= 0 else points[::-1])
    pixels = pictured.laid_out(PLACES)
    return np.asarray(pixels[(np.abs(pixels) <= FARTHEST).all(axis=1)])


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


def _beside(part: Array, path: Array) -> Flags:
    """Whether samples are nearer to the inside of a polyline than to either of its ends, (k,)."""
    away = np.linalg.norm(part[:, None] - path, axis=2).argmin(axis=1)
    return np.asarray((away > 0) & (away < len(path) - 1))
