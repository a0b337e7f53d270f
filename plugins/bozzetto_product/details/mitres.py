"""Mitres: where the floors of neighbouring zones meet, and where they meet an outline.

A floor goes on beyond its zone, or ends before it, until it meets the floor of the next one. Over a
place of the crease both meet in the plane across it, moved along it by what walls at its ends need.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product
from bozzetto.errors import UserError
from bozzetto.geometry import Curve
from bozzetto_product.details.chart import Chart
from bozzetto_product.details.floor import Floor
from bozzetto_product.details.joint_edges import FittedEdge, Track, fitted_edges
from bozzetto_product.details.levels import Level
from bozzetto_product.details.region import CutShell, OutlineEdge, Seat
from bozzetto_product.details.ring import Ring
from bozzetto_product.details.wall_feet import Node, following, run_of
from bozzetto_product.details.zones import CreaseEdge, ZonedRegion

SAME: Final = 1e-6
"""Distance, as share of the size of the whole, between ends of edges that are one."""

ROUNDS: Final = 40
"""Most steps of Newton's method."""

FOUND: Final = 3e-14
"""Distance between floors, as share of the size, at which they meet."""

LOOSELY: Final = 1e-9
"""The same, where rounding lets them come no nearer."""

ALONG: Final = 0.05
"""Least sine between an outline and a crease that it crosses."""

MOST_ZONES: Final = 3
"""Floors that meet in one place, whatever their depth: three planes have a common point."""

NARROW: Final = (
    "The outline goes over an edge by less than the walls and the depth need. Draw it farther over "
    "the edge, or make the detail less deep."
)
LENGTHWISE: Final = "The outline runs along an edge that is a crease. Draw it across the edge."
CROWDED: Final = (
    "More than three creases meet under the outline. Draw the detail beside the corner."
)


@dataclass(frozen=True, eq=False)
class Mitre:
    """A curve in which two floors meet.

    Parameters
    ----------
    crease : CreaseEdge
    nodes : (int, int)
        Where it begins and ends: numbers of outline edges that begin there; below 0 inside.
    forward, back : FittedEdge
        In the floors of the crease's zones; the curve is the first one's.
    """

    crease: CreaseEdge
    nodes: tuple[int, int]
    forward: FittedEdge
    back: FittedEdge


@dataclass(frozen=True, eq=False)
class MitredFloors:
    """Floors of zones that meet in mitres.

    Parameters
    ----------
    mitres : tuple of Mitre
    seats : tuple of Seat
        Of each edge of the outlines.
    zones : tuple of int
        The zone of each.
    """

    mitres: tuple[Mitre, ...]
    seats: tuple[Seat, ...]
    zones: tuple[int, ...]


def mitred_floors(
    cut: CutShell,
    region: ZonedRegion,
    rings: Sequence[Ring],
    edges: Sequence[OutlineEdge],
    levels: Sequence[Level],
    height: float,
    inward: float,
) -> MitredFloors:
    """Return where floors of zones meet one another, and the walls over creases.

    Parameters
    ----------
    cut : CutShell
        Cut along the outlines.
    region : ZonedRegion
        The faces inside.
    rings : sequence of Ring
        The outlines.
    edges : sequence of OutlineEdge
        Those of the outlines.
    levels : sequence of Level
        Of each zone.
    height : float
        Of the floors, mm, outward.
    inward : float
        By which walls lean inward, mm.

    Raises
    ------
    UserError
        If there is no room for that.
    """
    shell = cut.shell
    zones = tuple(
        next(region.of_face[face] for face, trim in shell.users[top] if trim.forward)
        for top in cut.tops
    )
    floors = [level.floor for level in levels if level.floor is not None]
    joints = _Joints(shell.edges, region.zones[0].chart, floors, height, inward, shell.size)
    nodes = {k: Node(edge.top.curve.control_points[0]) for k, edge in enumerate(edges)}
    runs: list[tuple[CreaseEdge, tuple[int, int]]] = []
    for crease in region.creases:
        curve = shell.edges[crease.edge]
        ends = [_node_at(nodes, curve.control_points[k], SAME * shell.size) for k in (0, -1)]
        for number, at in zip(ends, curve.range, strict=True):
            nodes[number].ends.append((crease, float(at)))
        runs.append((crease, (ends[0], ends[1])))
    before = {following(edges, k): k for k in range(len(edges))}
    for number, node in nodes.items():
        if number < 0:
            node.at = joints.inside(node)
        elif node.ends or zones[before[number]] != zones[number]:
            pair = before[number], number
            joints.on_outline(
                node, (edges[pair[0]], edges[pair[1]]), (zones[pair[0]], zones[pair[1]])
            )
    mitres = tuple(joints.mitre(crease, ends, nodes) for crease, ends in runs)
    seats = []
    for number, zone in enumerate(zones):
        run = run_of(edges, rings, nodes, zone, number)
        first, last = (nodes[k].at.get(zone) for k in (number, following(edges, number)))
        seats.append(Seat(run.slid(levels[zone]), (_pair(first), _pair(last))))
    return MitredFloors(mitres, tuple(seats), zones)


def _pair(at: Array | None) -> tuple[float, float] | None:
    return None if at is None else (float(at[0]), float(at[1]))


def _node_at(nodes: dict[int, Node], place: Array, near: float) -> int:
    """Return the number of the node at a place; a new one counts down from −1."""
    for number, node in nodes.items():
        if np.linalg.norm(node.place - place) <= near:
            return number
    number = -1 - len(nodes)
    nodes[number] = Node(place)
    return number


@dataclass(frozen=True, eq=False)
class _Fold:
    """Places of a crease: where it is, (n, 3), its unit tangents, and the normals on both sides."""

    points: Array
    along: Array
    normals: tuple[Array, Array]

    @property
    def way(self) -> Array:
        """The way from the crease to where surfaces one higher meet, (n, 3)."""
        one, two = self.normals
        return np.asarray((one + two) / (1.0 + (one * two).sum(axis=1, keepdims=True)))


@dataclass(frozen=True, eq=False)
class _Joints:
    """What finds where floors meet.

    Parameters
    ----------
    curves : sequence of Curve
        The edges of the shell.
    chart : Chart
    floors : sequence of Floor
        Of each zone.
    height, inward : float
        See `mitred_floors`.
    size : float
        Of the whole, mm.
    """

    curves: Sequence[Curve]
    chart: Chart
    floors: Sequence[Floor]
    height: float
    inward: float
    size: float

    def mitre(self, crease: CreaseEdge, ends: tuple[int, int], nodes: Mapping[int, Node]) -> Mitre:
        """Return the curve in which floors meet over an edge."""
        low, high = self.curves[crease.edge].range
        own = [self.floors[zone] for zone in crease.zones]
        fold = self._fold(crease, np.array((low, high)))
        at = np.stack([nodes[k].at[crease.zones[0]] for k in ends])
        feet = own[0].surface.value(*at.T)
        shifts = ((feet - fold.points) * fold.along).sum(axis=1)
        if not (feet[1] - feet[0]) @ (fold.points[1] - fold.points[0]) > 0.0:
            raise UserError(NARROW)

        def on(side: int) -> Callable[[Array], Array]:
            def parameters(places: Array) -> Array:
                share = (places - low) / (high - low)
                moved = (1.0 - share) * shifts[0] + share * shifts[1]
                return self._met(crease, self._fold(crease, places), moved)[side]

            return parameters

        tracks = [Track(floor.surface, on(k)) for k, floor in enumerate(own)]
        forward, back = fitted_edges(tracks, low, high, self.size)
        return Mitre(crease, ends, forward, back)

    def on_outline(
        self, node: Node, edges: tuple[OutlineEdge, OutlineEdge], zones: tuple[int, int]
    ) -> None:
        """Find where the walls on both sides of a crease meet on the floors.

        The foot of each by itself would end elsewhere on the mitre, but where the outline crosses
        the crease squarely; both end half-way.
        """
        if len(node.ends) != 1 or zones[0] == zones[1]:
            raise UserError(LENGTHWISE)
        ((crease, at),) = node.ends
        fold = self._fold(crease, np.array([at]))
        along, way = fold.along[0], self.height * fold.way[0]
        shifts, courses = [], []
        for edge, zone, end in zip(edges, zones, (-1, 0), strict=True):
            curve = edge.top.curve
            course = curve.derivative(np.array([curve.range[end]]), 1)[0]
            speed = float(np.linalg.norm(course))
            course = course / speed
            normal = fold.normals[crease.zones.index(zone)][0]
            across = cross_product(normal, along)
            inside = self.inward * cross_product(normal, course)
            if abs(course @ across) < ALONG:
                raise UserError(LENGTHWISE)
            run = ((way - inside) @ across) / (course @ across)
            shifts.append(float((inside + run * course) @ along))
            courses.append((zone, course / speed))
        shift = 0.5 * sum(shifts)
        node.slides = {zone: float((way + shift * along) @ course) for zone, course in courses}
        found = self._met(crease, fold, np.array([shift]))
        node.at = {zone: where[0] for zone, where in zip(crease.zones, found, strict=True)}

    def inside(self, node: Node) -> dict[int, Array]:
        """Return where the floors round an end of creases inside an outline meet."""
        zones = sorted({zone for crease, _ in node.ends for zone in crease.zones})
        if len(zones) > MOST_ZONES:
            raise UserError(CROWDED)
        folds = [(crease, self._fold(crease, np.array([at]))) for crease, at in node.ends]
        if len(zones) == 2:
            crease, fold = folds[0]
            found = self._met(crease, fold, np.zeros(1))
            return {zone: where[0] for zone, where in zip(crease.zones, found, strict=True)}
        normals = {
            zone: normal[0]
            for crease, fold in folds
            for zone, normal in zip(crease.zones, fold.normals, strict=True)
        }
        way = _solved(np.stack([normals[zone] for zone in zones])[None], np.ones((1, 3)))[0]
        goal = node.place + self.height * way
        at = np.stack([self._first(z, goal[None], normals[z][None])[0] for z in zones])
        off = np.inf
        for _ in range(ROUNDS):
            places, slopes = zip(*map(self._jet, zones, at[:, None]), strict=True)
            rest = np.concatenate((places[0][0] - places[1][0], places[0][0] - places[2][0]))
            off = float(np.abs(rest).max())
            if off <= FOUND * self.size:
                break
            jacobian = np.zeros((6, 6))
            jacobian[:3, :2] = jacobian[3:, :2] = slopes[0][0]
            jacobian[:3, 2:4], jacobian[3:, 4:] = -slopes[1][0], -slopes[2][0]
            at = at + _solved(jacobian[None], -rest[None])[0].reshape(3, 2)
        if not off <= LOOSELY * self.size:
            raise UserError(NARROW)
        return dict(zip(zones, at, strict=True))

    def _fold(self, crease: CreaseEdge, at: Array) -> _Fold:
        curve = self.curves[crease.edge]
        along = curve.derivative(at, 1)
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        return _Fold(curve.value(at), along, crease.normals(at))

    def _first(self, zone: int, goal: Array, normals: Array) -> Array:
        """Return parameters of a floor near places in space, (n, 2), to begin with."""
        low, high = np.transpose(self.floors[zone].surface.ranges)
        return np.clip(self.chart.flat(goal - self.height * normals), low, high)

    def _jet(self, zone: int, at: Array) -> tuple[Array, Array]:
        """Return places of a floor, (n, 3), and their derivatives by u and v, (n, 3, 2)."""
        surface = self.floors[zone].surface
        slopes = [surface.derivative(at[:, 0], at[:, 1], *order) for order in ((1, 0), (0, 1))]
        return surface.value(*at.T), np.stack(slopes, axis=2)

    def _met(self, crease: CreaseEdge, fold: _Fold, shifts: Array) -> tuple[Array, Array]:
        """Return the parameters, (n, 2) each, at which two floors meet over places of a crease.

        Parameters
        ----------
        crease : CreaseEdge
            Between them.
        fold : _Fold
            Its places.
        shifts : (n,) float
            How far along the crease from its place each is, mm.

        Raises
        ------
        UserError
            If they do not meet there.
        """
        goal = fold.points + self.height * fold.way + shifts[:, None] * fold.along
        one, two = (
            self._first(zone, goal, up) for zone, up in zip(crease.zones, fold.normals, strict=True)
        )
        off = np.inf
        for _ in range(ROUNDS):
            place, slope = self._jet(crease.zones[0], one)
            other, tilt = self._jet(crease.zones[1], two)
            beyond = ((place - fold.points) * fold.along).sum(axis=1) - shifts
            rest = np.column_stack((place - other, beyond))
            off = float(np.abs(rest).max(initial=0.0))
            if off <= FOUND * self.size:
                break
            jacobian = np.zeros((len(goal), 4, 4))
            jacobian[:, :3, :2], jacobian[:, :3, 2:] = slope, -tilt
            jacobian[:, 3, :2] = np.einsum("nd,nda->na", fold.along, slope)
            step = _solved(jacobian, -rest)
            one, two = one + step[:, :2], two + step[:, 2:]
            for zone, at in zip(crease.zones, (one, two), strict=True):
                low, high = np.transpose(self.floors[zone].surface.ranges)
                np.clip(at, low, high, out=at)
        if not off <= LOOSELY * self.size:
            raise UserError(NARROW)
        return one, two


def _solved(matrix: Array, right: Array) -> Array:
    """Return solutions of linear equations, (n, k).

    Raises
    ------
    UserError
        If floors are parallel.
    """
    try:
        return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
    except np.linalg.LinAlgError as error:
        raise UserError(NARROW) from error
