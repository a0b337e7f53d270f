"""Assembly of a mechanism: bodies with mass, and the joints between them. SI units."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from bozzetto.arrays import Array, Flags, Index, cross_product
from bozzetto_polyhedron.mechanism.convex_parts import Polytope
from bozzetto_polyhedron.mechanism.drives import Drive

GROUND: Final = -1
"""Number of what does not move."""

RowKind = Literal["direction", "distance", "angle"]

DIRECTION, DISTANCE, ANGLE = 0, 1, 2
"""Kinds of rows, as numbers."""


@dataclass(frozen=True, eq=False)
class Joints:
    """Scalar constraints between points of two bodies, row by row.

    Parameters
    ----------
    kind : (m,) intp
        `DIRECTION`: the gap between two points along a direction is 0. `DISTANCE`: their distance
        is what it was. `ANGLE`: the second body is turned against the first about an axis by so
        much.
    first, second : (m,) intp
        Bodies; the second may be the ground.
    first_point, second_point : (m, 3) float64
        In the frames of the bodies, m; those of the ground in the world. For angles two vectors
        square to the axis which lie on one another where the angle is 0.
    direction : (m, 3) float64
        Unit vectors in the frame of the second body; for angles the axis.
    target : (m,) float64
        Distance, m, or angle, rad.
    drive : (m,) object
        What a motor adds to the target, a `Drive`, m or rad; None where there is none.
    """

    kind: Index
    first: Index
    second: Index
    first_point: Array
    second_point: Array
    direction: Array
    target: Array
    drive: npt.NDArray[np.object_]

    def __len__(self) -> int:
        return len(self.kind)

    def __add__(self, other: Joints) -> Joints:
        return Joints(
            *(
                np.concatenate((getattr(self, name), getattr(other, name)))
                for name in self.__dataclass_fields__
            )
        )

    @property
    def drives(self) -> tuple[tuple[int, Drive], ...]:
        """Rows that a motor moves, each with what it does."""
        return tuple((k, each) for k, each in enumerate(self.drive) if each is not None)

    def taken(self, which: Index | Flags) -> Joints:
        """Return some of the rows."""
        return Joints(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


@dataclass(frozen=True, eq=False)
class Springs:
    """Springs between points of two bodies.

    Parameters
    ----------
    first, second : (k,) intp
    first_point, second_point : (k, 3) float64
    length : (k,) float64
        Without force, m.
    stiffness : (k,) float64
        N/m.
    """

    first: Index
    second: Index
    first_point: Array
    second_point: Array
    length: Array
    stiffness: Array

    @staticmethod
    def none() -> Springs:
        """Return no springs."""
        none = np.zeros(0, np.intp)
        return Springs(none, none, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))


@dataclass(frozen=True, eq=False)
class Ground:
    """The level ground under corners of bodies.

    Parameters
    ----------
    bodies : (k,) intp
    points : (k, 3) float64
        Corners in the frames of their bodies, m.
    height : float
        m.
    """

    bodies: Index
    points: Array
    height: float


@dataclass(frozen=True, eq=False)
class Colliding:
    """Bodies that meet one another.

    Parameters
    ----------
    bodies : (k,) intp
        Which body each part belongs to.
    parts : tuple of Polytope
        In the frames of their bodies, m.
    passing : frozenset of (int, int)
        Pairs of bodies that pass through one another all the same, the smaller number first.
    """

    bodies: Index
    parts: tuple[Polytope, ...]
    passing: frozenset[tuple[int, int]] = frozenset()


@dataclass(frozen=True, eq=False)
class Stops:
    """Hinges that turn between two angles.

    Parameters
    ----------
    first, second : (k,) intp
        Bodies.
    place : (k, 3) float64
        On the axes, in the frames of the second bodies, m.
    axis : (k, 3) float64
        Unit vectors in the frames of the second bodies.
    mark : (k, 3) float64
        Vectors square to the axes in the frames of the first bodies, as long as these are wide, m.
    middle : (k, 3) float64
        Unit vectors in the frames of the second bodies on which marks lie half-way.
    reach : (k,) float64
        Angles from there to both sides, rad.
    """

    first: Index
    second: Index
    place: Array
    axis: Array
    mark: Array
    middle: Array
    reach: Array

    def __len__(self) -> int:
        return len(self.first)

    def angles(self, motion: Motion) -> Array:
        """Return how far each hinge is turned from the middle of its way, (k,) rad."""
        mark = np.einsum("kij,kj->ki", motion.turns[self.first], self.mark)
        own = np.einsum("kji,kj->ki", motion.turns[self.second], mark)
        across = np.einsum("ki,ki->k", self.axis, cross_product(self.middle, own))
        return np.asarray(np.arctan2(across, np.einsum("ki,ki->k", self.middle, own)))


@dataclass(frozen=True, eq=False)
class Assembly:
    """Bodies and joints.

    Parameters
    ----------
    masses : (n,) float64
        kg.
    inertias : (n, 3, 3) float64
        About the centres of mass in the frames of the bodies, kg m²; zeros for a point mass.
    joints : Joints
    springs : Springs
    gravity : (3,) float64
        m/s².
    ground : Ground, optional
        None where nothing can be stood on.
    colliding : Colliding, optional
        None where nothing meets anything else.
    stops : Stops, optional
        Hinges that turn between two angles; None where none does.
    friction : float
        Coefficient of Coulomb's friction, of the ground and of bodies.
    planar : (3,) float64, optional
        Normal of the plane in which all moves, an axis of the world; None where nothing is
        confined to one.
    """

    masses: Array
    inertias: Array
    joints: Joints = field(default_factory=lambda: no_joints())
    springs: Springs = field(default_factory=Springs.none)
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    ground: Ground | None = None
    colliding: Colliding | None = None
    stops: Stops | None = None
    friction: float = 0.5
    planar: Array | None = None

    @property
    def freedoms(self) -> Array:
        """Which of the six velocities of a body are free, (6,) of 0 and 1."""
        if self.planar is None:
            return np.ones(6)
        normal = np.abs(self.planar)
        return np.concatenate((1.0 - normal, normal))


@dataclass(frozen=True, eq=False)
class Motion:
    """Where bodies are, and how they move.

    Parameters
    ----------
    places : (n, 3) float64
        Centres of mass, m.
    turns : (n, 3, 3) float64
        Rotations from the frames of the bodies.
    velocities : (n, 3) float64
        m/s.
    momenta : (n, 3) float64
        Angular momenta about the centres, kg m²/s.
    time : float
        s.
    """

    places: Array
    turns: Array
    velocities: Array
    momenta: Array
    time: float = 0.0

    @classmethod
    def at_rest(cls, places: Array) -> Motion:
        """Return bodies that stand where they are, not turned."""
        places = np.asarray(places, float)
        still = np.zeros_like(places)
        return cls(places, np.tile(np.eye(3), (len(places), 1, 1)), still, still)

    def stopped(self) -> Motion:
        """Return the same pose without any velocity."""
        still = np.zeros_like(self.places)
        return replace(self, velocities=still, momenta=still)


def no_joints() -> Joints:
    """Return no rows."""
    none = np.zeros(0, np.intp)
    return Joints(
        none, none, none, np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)),
        np.zeros(0), np.full(0, None),
    )  # fmt: skip


def spherical(motion: Motion, first: int, second: int, place: Array) -> Joints:
    """Return a joint that keeps a place (3,) of two bodies together, m in the world."""
    rows = np.eye(3)
    return directed(motion, first, second, np.tile(place, (3, 1)), rows)


def hinge(motion: Motion, first: int, second: int, begin: Array, end: Array) -> Joints:
    """Return a joint about the line between two places (3,), m in the world.

    The first place is kept together, the second one in the two directions square to the line:
    five rows, none of them twice.
    """
    axis = (np.asarray(end) - begin) / np.linalg.norm(np.asarray(end) - begin)
    aside = np.stack(square_to(axis))
    return spherical(motion, first, second, begin) + directed(
        motion, first, second, np.tile(end, (2, 1)), aside
    )


def slider(
    motion: Motion, first: int, second: int, begin: Array, end: Array, *, turns: bool = True
) -> Joints:
    """Return a joint that lets a place of the first body slide along a line of the second.

    Parameters
    ----------
    motion : Motion
        At rest.
    first, second : int
        Bodies, or the ground as the second.
    begin, end : (3,) array
        The place, and another one on the line, m.
    turns : bool
        Whether the first body may turn against the second one.
    """
    axis = np.asarray(end) - begin
    length = float(np.linalg.norm(axis))
    aside = np.stack(square_to(axis / length))
    made = directed(motion, first, second, np.tile(begin, (2, 1)), aside)
    if turns:
        return made
    beside = begin + length * aside[0]
    places = np.stack((np.asarray(end), np.asarray(end), beside))
    return made + directed(motion, first, second, places, np.vstack((aside, aside[1:])))


def link(motion: Motion, first: int, second: int, begin: Array, end: Array) -> Joints:
    """Return a massless bar between a place of the first body and one of the second."""
    begin, end = np.asarray(begin, float), np.asarray(end, float)
    length = float(np.linalg.norm(end - begin))
    return Joints(
        np.array([DISTANCE]),
        np.array([first]),
        np.array([second]),
        _local(motion, first, begin[None]),
        _local(motion, second, end[None]),
        np.zeros((1, 3)),
        np.array([length]),
        np.full(1, None),
    )


def motor(motion: Motion, first: int, second: int, axis: Array, drive: Drive) -> Joints:
    """Return a row that turns the first body against the second about an axis, by a drive, rad."""
    axis = np.asarray(axis, float) / np.linalg.norm(axis)
    mark = square_to(axis)[0]
    return Joints(
        np.array([ANGLE]),
        np.array([first]),
        np.array([second]),
        _turned_back(motion, first, mark[None]),
        _turned_back(motion, second, mark[None]),
        _turned_back(motion, second, axis[None]),
        np.zeros(1),
        np.array([drive], object),
    )


def pusher(
    motion: Motion, first: int, second: int, begin: Array, end: Array, drive: Drive
) -> Joints:
    """Return a row that moves a place of the first body along a line of the second, by a drive, m.

    Parameters
    ----------
    motion : Motion
        At rest.
    first, second : int
        Bodies, or the ground as the second.
    begin, end : (3,) array
        The place, and another one on the line, in the direction of larger values, m.
    drive : Drive
        In m.
    """
    along = (np.asarray(end) - begin) / np.linalg.norm(np.asarray(end) - begin)
    made = directed(motion, first, second, np.asarray(begin)[None], along[None])
    return replace(made, drive=np.array([drive], object))


def directed(motion: Motion, first: int, second: int, places: Array, directions: Array) -> Joints:
    """Return rows that keep places (k, 3) of two bodies together along directions (k, 3)."""
    count = len(places)
    return Joints(
        np.full(count, DIRECTION),
        np.full(count, first),
        np.full(count, second),
        _local(motion, first, places),
        _local(motion, second, places),
        _turned_back(motion, second, directions),
        np.zeros(count),
        np.full(count, None),
    )


def _local(motion: Motion, body: int, places: Array) -> Array:
    """Return places of the world (k, 3) in the frame of a body."""
    if body == GROUND:
        return np.asarray(places, float)
    return np.asarray((places - motion.places[body]) @ motion.turns[body])


def _turned_back(motion: Motion, body: int, directions: Array) -> Array:
    return np.asarray(directions if body == GROUND else directions @ motion.turns[body], float)


def square_to(axis: Array) -> tuple[Array, Array]:
    """Return two unit vectors square to an axis and to one another."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(axis, helper)
    first /= np.linalg.norm(first)
    return first, np.asarray(np.cross(axis, first))
