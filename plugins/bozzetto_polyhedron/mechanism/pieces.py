"""From bodies to what moves: bars, plates hinged at edges, or one piece."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.mechanism.assembly import (
    GROUND,
    Assembly,
    Colliding,
    Ground,
    Joints,
    Motion,
    directed,
    hinge,
    link,
    no_joints,
    spherical,
    square_to,
)
from bozzetto_polyhedron.mechanism.convex_parts import Polytope
from bozzetto_polyhedron.mechanism.masses import (
    bar_masses,
    plate_masses,
    sheet_masses,
    solid_masses,
    triangle_masses,
)
from bozzetto_polyhedron.mechanism.stops import stops_of
from bozzetto_polyhedron.mechanism.touches import jointed, lying_in_one_another
from bozzetto_polyhedron.reconstruction.answer import Rings

Moves = Literal["whole", "links", "plates", "flat"]

Folds = frozenset[tuple[int, int]]

METRE: Final = 1e-3
"""Metres in a millimetre."""

THICKNESS: Final = 2.0
"""Of bars and plates that have no thickness of their own, mm."""

OWN: Final = 1e-9
"""Moment, kg m², that every piece has at least: a needle turns about its own axis, too."""

TOGETHER: Final = 0.01
"""Distance of corners of two bodies, in the extent of all, within which they are joined."""


@dataclass(frozen=True, eq=False)
class Shape:
    """One body as a mechanism needs it.

    Parameters
    ----------
    vertices : (n, 3) float64
        mm.
    edges : (m, 2) intp
    faces : tuple of Rings
    moves : {"whole", "links", "plates", "flat"}
    anchors : mapping of int to (3,) float64
        Vertices that are held, and where, mm.
    density : float
        kg/m³.
    thickness : float
        Of its walls, mm; 0 where it is solid, or has those of `THICKNESS`.
    solid : bool
        Whether its faces enclose a volume that is full.
    triangles : (t, 3) intp, optional
        Of one whose faces are not plane: it moves as a whole, and stands on its parts.
    parts : tuple of Polytope
        What of it meets other bodies, mm; one that moves as bars, or whose faces are all hinged,
        has none.
    faces_of_parts : tuple of int
        Which face each part is of, where it folds; empty where it moves as a whole.
    normal : (3,) float64, optional
        Of the plane in which the bars of a flat shape lie and move.
    folds : frozenset of (int, int), optional
        Edges at which plates are hinged, the smaller number first; those that share another one are
        one piece. None where all of them are.
    """

    vertices: Array
    edges: Index
    faces: tuple[Rings, ...]
    moves: Moves
    anchors: Mapping[int, Array] = field(default_factory=dict)
    density: float = 1240.0
    thickness: float = 0.0
    solid: bool = False
    triangles: Index | None = None
    parts: tuple[Polytope, ...] = ()
    faces_of_parts: tuple[int, ...] = ()
    normal: Array | None = None
    folds: Folds | None = None

    @property
    def wall(self) -> float:
        """Thickness of bars and plates, m."""
        return (self.thickness or THICKNESS) * METRE


@dataclass(frozen=True, eq=False)
class Machine:
    """Pieces with mass and joints, and where the vertices of the shapes are on them.

    Parameters
    ----------
    assembly : Assembly
    rest : Motion
        As it was drawn.
    holders : tuple of (n,) intp
        For each shape the piece that carries each vertex.
    plates : tuple of (f,) intp
        For each shape the piece that each face belongs to; empty where faces do not move rigidly.
    bars : tuple of (e,) intp
        For each shape the piece that each edge is; empty where edges are none.
    """

    assembly: Assembly
    rest: Motion
    shapes: tuple[Shape, ...]
    holders: tuple[Index, ...]
    plates: tuple[Index, ...]
    bars: tuple[Index, ...]

    def piece_at(self, number: int, place: Array) -> int:
        """Return the piece of a shape that is at a place at rest, mm; that of the nearest corner.

        Of bars it is the nearest one. Where plates meet in a corner it is the one whose face lies
        nearest.
        """
        if number == GROUND:
            return GROUND
        shape, plates = self.shapes[number], self.plates[number]
        if shape.moves == "plates" and len(plates):
            away = [_distance(shape.vertices, rings, place) for rings in shape.faces]
            return int(plates[int(np.argmin(away))])
        if len(self.bars[number]):
            return int(self.bars[number][int(np.argmin(self._from_bars(number, place)))])
        nearest = np.linalg.norm(shape.vertices - place, axis=1)
        return int(self.holders[number][int(np.argmin(nearest))])

    def bars_at(self, number: int, place: Array) -> list[int]:
        """Return the bars of a shape that pass through a place at rest, mm, between its corners."""
        if not len(self.bars[number]):
            return []
        reach = TOGETHER * float(np.linalg.norm(np.ptp(self.shapes[number].vertices, axis=0)))
        near = self._from_bars(number, place) <= reach
        return [int(piece) for piece in self.bars[number][near]]

    def _from_bars(self, number: int, place: Array) -> Array:
        """Return how far a place at rest is from each bar of a flat shape, (e,) mm."""
        begin, end = np.moveaxis(self.shapes[number].vertices[self.shapes[number].edges], 1, 0)
        along = end - begin
        lengths = np.maximum((along**2).sum(axis=1), 1e-300)
        share = np.clip(((place - begin) * along).sum(axis=1) / lengths, 0.0, 1.0)
        return np.asarray(np.linalg.norm(begin + share[:, None] * along - place, axis=1))

    def bar_between(self, number: int, begin: Array, end: Array) -> int | None:
        """Return the bar of a shape between the corners nearest to two places, mm."""
        vertices = self.shapes[number].vertices
        ends = {int(np.argmin(np.linalg.norm(vertices - place, axis=1))) for place in (begin, end)}
        for edge, piece in zip(self.shapes[number].edges, self.bars[number], strict=False):
            if {int(edge[0]), int(edge[1])} == ends:
                return int(piece)
        return None

    def fold_between(self, number: int, begin: Array, end: Array) -> tuple[int, int] | None:
        """Return the plates that share the edge between the corners nearest to two places, mm.

        The first is the one round which the edge leads from the first place to the second. None
        where no two plates that turn against one another do.
        """
        shape, plates = self.shapes[number], self.plates[number]
        if shape.moves != "plates":
            return None
        one, other = (
            int(np.argmin(np.linalg.norm(shape.vertices - at, axis=1))) for at in (begin, end)
        )
        found = {
            pair: int(piece)
            for rings, piece in zip(shape.faces, plates, strict=True)
            for pair in sides_of(rings)
        }
        pieces = found.get((one, other)), found.get((other, one))
        if pieces[0] is None or pieces[1] is None or pieces[0] == pieces[1]:
            return None
        return pieces[0], pieces[1]

    def moved(self, number: int, motion: Motion, pieces: Index | None = None) -> Array:
        """Return the vertices of a shape where a motion has taken them, (n, 3) mm.

        Parameters
        ----------
        number : int
            Of the shape.
        motion : Motion
            Of this machine.
        pieces : (n,) intp, optional
            With which piece each vertex goes; by default the one that holds it.
        """
        vertices = self.shapes[number].vertices * METRE
        holders = self.holders[number] if pieces is None else pieces
        if not len(self.rest.places):
            return np.asarray(vertices / METRE)
        local = vertices - self.rest.places[holders]
        there = np.einsum("nij,nj->ni", motion.turns[holders], local) + motion.places[holders]
        return np.asarray(np.where((holders == GROUND)[:, None], vertices, there) / METRE)

    def local(self, number: int, vertex: int) -> Array:
        """Return where a vertex is in the frame of the piece that holds it, m."""
        piece = self.holders[number][vertex]
        return np.asarray(self.shapes[number].vertices[vertex] * METRE - self.rest.places[piece])


class _Builder:
    """Collects pieces and joints of all shapes."""

    def __init__(self) -> None:
        self.places: list[Array] = []
        self.masses: list[float] = []
        self.inertias: list[Array] = []
        self.holders: list[Index] = []
        self.plates: list[Index] = []
        self.edges: list[Index] = []
        self.hinges: list[tuple[int, int, Array, Array]] = []
        self.balls: list[tuple[int, int, Array]] = []
        self.planes: list[tuple[int, int, Array, Array]] = []
        self.bars: list[tuple[int, int, Array, Array]] = []
        self.held: list[tuple[int, Array, Array, Array]] = []

    def add(self, shape: Shape) -> None:
        self.edges.append(_no_numbers())
        {
            "links": self._links,
            "plates": self._plates,
            "whole": self._whole,
            "flat": self._flat,
        }[shape.moves](shape)

    def _piece(self, points: Array, masses: Array) -> int:
        """Add a rigid piece of point masses."""
        total = float(masses.sum())
        middle = masses @ points / total
        arms = points - middle
        square = (masses * (arms**2).sum(axis=1)).sum()
        spread = np.einsum("k,ki,kj->ij", masses, arms, arms)
        self.places.append(middle)
        self.masses.append(total)
        self.inertias.append((square + OWN) * np.eye(3) - spread)
        return len(self.places) - 1

    def _links(self, shape: Shape) -> None:
        """Add a point mass at every corner and a bar for every edge (the paper's linkages)."""
        points = shape.vertices * METRE
        lengths = np.linalg.norm(points[shape.edges[:, 0]] - points[shape.edges[:, 1]], axis=1)
        masses = np.full(len(points), 1e-6)
        for end in (0, 1):
            np.add.at(masses, shape.edges[:, end], 0.5 * shape.density * shape.wall**2 * lengths)
        holders = len(self.places) + np.arange(len(points))
        self.places.extend(points)
        self.masses.extend(masses.tolist())
        self.inertias.extend(np.zeros((len(points), 3, 3)))
        for one, other in shape.edges:
            if int(one) not in shape.anchors or int(other) not in shape.anchors:
                self.bars.append(
                    (int(holders[one]), int(holders[other]), points[one], points[other])
                )
        self.holders.append(holders)
        self.plates.append(_no_numbers())
        self._anchored(shape, holders, np.eye(3))

    def _flat(self, shape: Shape) -> None:
        """Add a rigid bar for every edge, pinned where edges meet; all stay in one plane."""
        points, normal = shape.vertices * METRE, shape.normal
        if normal is None:
            raise ValueError("a flat shape needs the normal of its plane")
        aside = np.stack(square_to(normal))
        holders = np.full(len(points), GROUND)
        numbers: list[int] = []
        for first, second in shape.edges:
            begin, end = points[first], points[second]
            piece = self._piece(*bar_masses(begin, end, shape.wall, shape.density))
            numbers.append(piece)
            across = begin + np.cross(normal, end - begin)
            for place in (begin, end, across):
                self.planes.append((piece, GROUND, place[None], normal[None]))
            for corner in (int(first), int(second)):
                if holders[corner] == GROUND:
                    holders[corner] = piece
                else:
                    place = np.tile(points[corner], (2, 1))
                    self.planes.append((piece, int(holders[corner]), place, aside))
        self._anchored(shape, holders, aside)
        self.holders.append(holders)
        self.plates.append(_no_numbers())
        self.edges[-1] = np.array(numbers, np.intp)

    def _plates(self, shape: Shape) -> None:
        """Add a plate for every face, hinged at the edges that are folds, one with others there."""
        points = shape.vertices * METRE
        holders = np.full(len(points), GROUND)
        groups = rigid_faces(shape.faces, shape.folds)
        weights = [plate_masses(points, rings, shape.wall, shape.density) for rings in shape.faces]
        numbers = np.zeros(len(groups), np.intp)
        for group in range(int(groups.max(initial=-1)) + 1):
            own = [weights[k] for k in np.flatnonzero(groups == group)]
            where, masses = (np.concatenate([part[k] for part in own]) for k in (0, 1))
            numbers[groups == group] = self._piece(where, masses)
        at_edge: dict[tuple[int, int], int] = {}
        for rings, number in zip(shape.faces, numbers, strict=True):
            piece = int(number)
            for ring in rings:
                holders[list(ring)] = np.where(holders[list(ring)] < 0, piece, holders[list(ring)])
            for begin, end in sides_of(rings):
                edge = (min(begin, end), max(begin, end))
                if at_edge.get(edge, piece) != piece:
                    self.hinges.append((piece, at_edge[edge], points[edge[0]], points[edge[1]]))
                at_edge[edge] = piece
        self.holders.append(holders)
        self.plates.append(numbers)
        self._anchored(shape, holders, np.eye(3))

    def _whole(self, shape: Shape) -> None:
        """Add the body as one piece: full, or its mass where its walls are."""
        points = shape.vertices * METRE
        if shape.triangles is not None:
            if shape.solid:
                piece = self._piece(*triangle_masses(points, shape.triangles, shape.density))
            else:
                piece = self._piece(
                    *sheet_masses(points, shape.triangles, shape.wall, shape.density)
                )
        elif shape.solid:
            piece = self._piece(*solid_masses(points, shape.faces, shape.density))
        else:
            parts = [
                plate_masses(points, rings, shape.wall, shape.density) for rings in shape.faces
            ]
            parts = parts or [(points, np.full(len(points), 1e-3))]
            where, masses = (np.concatenate([part[k] for part in parts]) for k in (0, 1))
            piece = self._piece(where, masses)
        holders = np.full(len(points), piece)
        self.holders.append(holders)
        self.plates.append(np.full(len(shape.faces), piece))
        self._anchored(shape, holders, np.eye(3))

    def _anchored(self, shape: Shape, holders: Index, directions: Array) -> None:
        """Hold corners along directions (k, 3)."""
        for vertex, at in shape.anchors.items():
            if holders[vertex] != GROUND:
                place = shape.vertices[vertex] * METRE
                self.held.append((int(holders[vertex]), place, at * METRE, directions))

    def joined(self, shapes: Sequence[Shape]) -> None:
        """Join corners of different bodies that lie on one another."""
        points = [
            shape.vertices[: len(shape.vertices) if shape.triangles is None else 0] * METRE
            for shape in shapes
        ]
        every = np.concatenate(points)
        if not len(every):
            return
        extent = float(np.linalg.norm(np.ptp(every, axis=0)))
        for one in range(len(shapes)):
            for other in range(one):
                away = np.linalg.norm(points[one][:, None] - points[other][None], axis=2)
                for first, second in np.argwhere(away < TOGETHER * extent):
                    pieces = self.holders[one][first], self.holders[other][second]
                    if pieces[0] == GROUND:
                        pieces = pieces[::-1]
                    if pieces[0] != GROUND and pieces[0] != pieces[1]:
                        self.balls.append((int(pieces[0]), int(pieces[1]), points[one][first]))

    def joints(self, rest: Motion) -> Joints:
        made = no_joints()
        for bar in self.bars:
            made += link(rest, *bar)
        for turned in self.hinges:
            made += hinge(rest, *turned)
        for ball in self.balls:
            made += spherical(rest, *ball)
        for piece, other, places, directions in self.planes:
            made += directed(rest, piece, other, places, directions)
        for piece, place, at, directions in self.held:
            count = len(directions)
            rows = directed(rest, piece, GROUND, np.tile(place, (count, 1)), directions)
            made += replace(rows, second_point=np.tile(at, (count, 1)))
        return made

    def ground(self, shapes: Sequence[Shape]) -> Ground:
        """Return the ground: at z = 0, or under the lowest corner at rest where that is below."""
        bodies, points = [], []
        for shape, holders, plates in zip(shapes, self.holders, self.plates, strict=True):
            if shape.triangles is not None:
                for part in shape.parts:
                    bodies += [int(holders[0])] * len(part.corners)
                    points += list(part.corners * METRE - self.places[int(holders[0])])
                continue
            vertices = shape.vertices * METRE
            pairs = {(int(piece), k) for k, piece in enumerate(holders) if piece != GROUND}
            for rings, piece in zip(shape.faces, plates, strict=False):
                pairs |= {(int(piece), k) for ring in rings for k in ring}
            for piece, k in sorted(pairs):
                bodies.append(piece)
                points.append(vertices[k] - self.places[piece])
        lowest = min((float(shape.vertices[:, 2].min()) for shape in shapes), default=0.0)
        return Ground(
            np.array(bodies, np.intp),
            np.reshape(np.array(points, float), (-1, 3)),
            min(0.0, lowest * METRE),
        )


def machine_of(
    shapes: Sequence[Shape],
    *,
    gravity: float = 0.0,
    planar: int | None = None,
    ground: bool = False,
    friction: float = 0.5,
) -> Machine:
    """Return what moves of some bodies.

    Parameters
    ----------
    shapes : sequence of Shape
        In one frame; corners of different bodies that lie on one another are joined.
    gravity : float
        Downwards, m/s².
    planar : int, optional
        The axis of the world along which nothing moves.
    ground : bool
        Whether there is any.
    friction : float
        Coefficient of Coulomb's friction.
    """
    builder = _Builder()
    for shape in shapes:
        builder.add(shape)
    if len(shapes) > 1:
        builder.joined(shapes)
    rest = Motion.at_rest(np.reshape(np.array(builder.places, float), (-1, 3)))
    assembly = Assembly(
        np.array(builder.masses, float),
        np.reshape(np.array(builder.inertias, float), (-1, 3, 3)),
        builder.joints(rest),
        gravity=np.array([0.0, 0.0, -gravity]),
        ground=builder.ground(shapes) if ground else None,
        friction=friction,
        planar=None if planar is None else np.eye(3)[planar],
    )
    return Machine(
        assembly,
        rest,
        tuple(shapes),
        tuple(builder.holders),
        tuple(builder.plates),
        tuple(builder.edges),
    )


def meeting(machine: Machine) -> Machine:
    """Return a machine whose bodies meet; those drawn in one another never do.

    Those at a hinge turn until they meet. Those at another joint, and the pieces of one shape, pass
    through one another.
    """
    bodies: list[int] = []
    parts: list[Polytope] = []
    together: set[tuple[int, int]] = set()
    for shape, holders, plates in zip(machine.shapes, machine.holders, machine.plates, strict=True):
        own = plates[list(shape.faces_of_parts)] if shape.faces_of_parts else holders[:1]
        for part, body in zip(shape.parts, np.resize(own, len(shape.parts)), strict=True):
            bodies.append(int(body))
            parts.append(part.scaled(METRE, -machine.rest.places[body] / METRE))
        together |= set(combinations(np.unique(own).tolist(), 2))
    if len(set(bodies)) < 2:
        return machine
    joints, rest = machine.assembly.joints, machine.rest
    made = Colliding(np.array(bodies, np.intp), tuple(parts))
    passing = jointed(joints) | lying_in_one_another(made, rest) | together
    stops = stops_of(joints, rest, bodies, parts)
    several = len(set(combinations(sorted(set(bodies)), 2)) - passing) > 0
    colliding = replace(made, passing=passing) if several else None
    assembly = replace(machine.assembly, colliding=colliding, stops=stops)
    return replace(machine, assembly=assembly)


def rigid_faces(faces: Sequence[Rings], folds: Folds | None) -> Index:
    """Return the number of the rigid piece that each face is part of, (f,), counted from 0.

    Parameters
    ----------
    faces : sequence of Rings
        Of one body.
    folds : frozenset of (int, int), optional
        Edges at which faces turn against one another, the smaller number first; None for all.
    """
    groups = np.arange(len(faces))
    if folds is None:
        return groups
    at_edge: dict[tuple[int, int], int] = {}
    for face, rings in enumerate(faces):
        for begin, end in sides_of(rings):
            edge = (min(begin, end), max(begin, end))
            if edge in at_edge and edge not in folds:
                one, other = groups[face], groups[at_edge[edge]]
                groups[groups == max(one, other)] = min(one, other)
            at_edge[edge] = face
    return np.unique(groups, return_inverse=True)[1]


def sides_of(rings: Rings) -> list[tuple[int, int]]:
    """Return the edges of a face from corner to corner, as its rings lead round it."""
    return [pair for ring in rings for pair in zip(ring, (*ring[1:], *ring[:1]), strict=True)]


def _no_numbers() -> Index:
    return np.zeros(0, np.intp)


def _distance(vertices: Array, rings: Rings, place: Array) -> float:
    """Return how far a place is from the plane of a face and from its corners, added, mm."""
    ring = vertices[list(rings[0])]
    normal = np.cross(ring - ring[0], np.roll(ring, -1, axis=0) - ring[0]).sum(axis=0)
    length = max(float(np.linalg.norm(normal)), 1e-300)
    away = place - ring
    return abs(float(away[0] @ normal)) / length + 1e-3 * float(np.linalg.norm(away, axis=1).min())
