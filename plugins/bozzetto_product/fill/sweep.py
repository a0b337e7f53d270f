"""Surfaces swept between two sides that are alike: the one moves into the other.

A profile that is turned, pushed along, or both at once, has the same shape on two sides of a
loop, and the sides between are its orbits under one screw motion. No energy tells that the profile
goes through the middle as well: a plate sags there, and its curvature is not even. So where the
sides say that they are swept, the surface is fitted to the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, cross_product, frozen
from bozzetto.plugin import cached_property
from bozzetto_product.fill.half_sides import Side
from bozzetto_product.fill.patch_space import PatchSpace
from bozzetto_product.fill.quintic import DEGREE, NODES, bernstein

ALIKE: Final = 0.01
"""Distance of sides from a sweep, as share of the size of their loop, up to which they are one."""

LEANING: Final = 0.5
"""Sine between the normals along the sides and those of the sweep, root mean square, up to which it
is what they ask for."""

STRAIGHT: Final = 1e-3
"""Share of the largest singular value below which the second tells no turn: a line."""

MOST_TURN: Final = 5.5
"""Largest turn, radians: what is turned farther begins beside its end."""

TURNING: Final = 1e-3
"""What each radian of a turn counts as a distance, share of the size: of two sweeps of one surface,
as of a cylinder, polynomials follow the one better that turns less."""

WAYS: Final = 0.1
"""Weight of the directions of the sides beside them against the places of a side that moves."""

PUSHED: Final = 1e-4
"""Turn in radians below which a motion is a mere push."""

HALF: Final = frozen(np.linspace(0.0, 1.0, 21), np.float64)
"""Parameters along half a side at which it is compared."""

RESTING: Final = 0.05
"""Share of the greatest speed below which a place rests, as on the axis: it has no direction."""


@dataclass(frozen=True, eq=False)
class Screw:
    """A turn about an axis and a push along it.

    Parameters
    ----------
    angle : float
        Radians; 0 where it is a push.
    axis : (3,) float
        Unit vector.
    foot : (3,) float
        A place on the axis.
    push : (3,) float
        Along the axis; anywhere where nothing is turned.
    """

    angle: float
    axis: Array
    foot: Array
    push: Array

    @classmethod
    def of(cls, turn: Array, shift: Array) -> Screw:
        """Return the motion to ``turn @ x + shift`` (Chasles's theorem).

        Parameters
        ----------
        turn : (3, 3) float
            A rotation; of half a turn at most about the axis that is found.
        shift : (3,) float
            What is added.
        """
        skew = turn - turn.T
        sine = 0.5 * np.array((skew[2, 1], skew[0, 2], skew[1, 0]))
        cosine = 0.5 * (np.trace(turn) - 1.0)
        angle = float(np.arctan2(np.linalg.norm(sine), cosine))
        if angle < PUSHED:
            return cls(0.0, np.array((0.0, 0.0, 1.0)), np.zeros(3), shift)
        axis = sine / max(float(np.linalg.norm(sine)), 1e-300)
        if cosine < 0.0:
            # Near half a turn the sine tells little: the axis is what both turns leave as it is.
            found = np.linalg.eigh(turn + turn.T)[1][:, 2]
            axis = -found if found @ sine < 0.0 else found
        push = float(shift @ axis) * axis
        across = shift - push
        foot = 0.5 * (across + cross_product(axis, across) / np.tan(0.5 * angle))
        return cls(angle, axis, foot, push)

    def other_way(self) -> Screw:
        """Return the motion to the same place by what is left of the whole turn."""
        return Screw(2.0 * np.pi - self.angle, -self.axis, self.foot, self.push)

    def moved(self, places: Array, share: Array) -> Array:
        """Return places after shares (n,) of the motion, (n, 3)."""
        share = share[:, None]
        from_foot = places - self.foot
        along = (from_foot @ self.axis)[:, None] * self.axis
        out = from_foot - along
        turned = np.cos(share * self.angle) * out + np.sin(share * self.angle) * cross_product(
            self.axis, out
        )
        return np.asarray(self.foot + along + turned + share * self.push)

    def turned(self, vectors: Array, share: Array) -> Array:
        """Return vectors after shares (n,) of the turn, (n, 3)."""
        moved = self.moved(self.foot + vectors, share)
        return np.asarray(moved - self.foot - share[:, None] * self.push)

    def speeds(self, places: Array) -> Array:
        """Return the derivatives of places by the share of the motion, (n, 3)."""
        return np.asarray(self.angle * cross_product(self.axis, places - self.foot) + self.push)

    def shares(self, places: Array, start: Array) -> Array:
        """Return the shares, 0 … 1, at which a moved place comes nearest to places, (n,)."""
        if self.angle == 0.0:
            square = float(self.push @ self.push)
            made = (places - start) @ self.push / max(square, 1e-300)
        else:
            one = start - self.foot
            one = one - float(one @ self.axis) * self.axis
            other = places - self.foot
            sine = cross_product(one, other) @ self.axis
            angle = np.arctan2(sine, other @ one) - 0.5 * self.angle
            angle = (angle + np.pi) % (2.0 * np.pi) - np.pi
            made = angle / self.angle + 0.5
        return np.clip(made, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class SidePlaces:
    """Places along a side in the frame of its loop.

    Parameters
    ----------
    side : Side
    places, slopes : (n, 3) float
    back : bool
        They run against the loop.
    """

    side: Side
    places: Array
    slopes: Array
    back: bool = False

    @classmethod
    def of(cls, side: Side, origin: Array, size: float) -> SidePlaces:
        """Return places at even parameters of both halves, as the loop runs."""
        rows = []
        for half, sense in zip(side.halves, (1, -1), strict=True):
            places, slopes = half.value(HALF), sense * half.value(HALF, 1)
            rows.append((((places - origin) / size)[::sense], (slopes / size)[::sense]))
        (first, leave), (second, arrive) = rows
        places, slopes = np.concatenate((first, second[1:])), np.concatenate((leave, arrive[1:]))
        return cls(side, places, slopes)

    def reversed(self) -> SidePlaces:
        """Return the places the other way round."""
        return SidePlaces(self.side, self.places[::-1], -self.slopes[::-1], not self.back)

    @cached_property
    def normals(self) -> Array:
        """Unit normals of the surface, (n, 3); NaN where the side is a crease."""
        rows = []
        for half, sense in zip(self.side.halves, (1, -1), strict=True):
            normals = half.normals(HALF)
            normals = np.full((len(HALF), 3), np.nan) if normals is None else normals
            rows.append(normals[::sense])
        made = np.concatenate((rows[0], rows[1][1:]))
        return made[::-1] if self.back else made

    def by_length(self) -> Array:
        """Return places at even lengths, (n, 3)."""
        steps = np.linalg.norm(np.diff(self.places, axis=0), axis=1)
        length = np.concatenate(((0.0,), np.cumsum(steps)))
        at = np.linspace(0.0, length[-1], len(self.places))
        return np.column_stack([np.interp(at, length, axis) for axis in self.places.T])


@dataclass(frozen=True, eq=False)
class Sweep:
    """A motion of one side of a loop into another.

    Parameters
    ----------
    first : int
        The side that moves.
    last : int
        Where it comes to, which the loop runs the other way.
    screw : Screw
    off : float
        Largest distance of the sides from it, share of the size.
    """

    first: int
    last: int
    screw: Screw
    off: float

    def places(self, space: PatchSpace, controls: Array) -> Array:
        """Return where the Gauss points of all patches are to be, (n · 49, 3).

        Parameters
        ----------
        space : PatchSpace
            Of three or four patches.
        controls : (10 n, 3) float
            Of the sides; see `LoopSides`.
        """
        along, across = self._shares(space)
        start = on_side(controls, space.count, self.first, along)
        end = on_side(controls, space.count, self.last, 1.0 - along)
        fade = (across**2 * (3.0 - 2.0 * across))[:, None]
        moved = self.screw.moved(start, across), self.screw.moved(end, across - 1.0)
        return np.asarray((1.0 - fade) * moved[0] + fade * moved[1])

    def _shares(self, space: PatchSpace) -> tuple[Array, Array]:
        """Return where the Gauss points are along the side that moves and in its way, 0 … 1."""
        if space.count == 3:
            u, v = (x.ravel() for x in np.meshgrid(NODES, NODES, indexing="ij"))
            corners = np.vstack((space.domain.corners.T, np.ones(3)))
            places = space.domain.places(u, v).reshape(-1, 2)
            shares = np.linalg.solve(corners, np.vstack((places.T, np.ones(len(places)))))
            start, pole, end = (shares[k % 3] for k in range(self.first, self.first + 3))
            return pole, end / np.maximum(start + end, 1e-12)
        s, t = square_shares()
        return (s, t) if self.first == 0 else (1.0 - t, s)


def square_shares() -> tuple[Array, Array]:
    """Return where the Gauss points of four patches are in the unit square, (4 · 49,) each.

    Side 0 leads along the first coordinate, side 1 along the second, from its end.
    """
    u, v = (x.ravel() for x in np.meshgrid(NODES, NODES, indexing="ij"))
    corner = np.array(((0, 0), (1, 0), (1, 1), (0, 1)))
    middle = 0.5 * (corner + np.roll(corner, -1, axis=0))
    quads = np.stack((corner, middle, np.full((4, 2), 0.5), np.roll(middle, 1, axis=0)), axis=1)
    weights = np.stack(((1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v), axis=1)
    s, t = np.moveaxis(np.einsum("mc,kcd->kmd", weights, quads).reshape(-1, 2), 1, 0)
    return s, t


def on_side(controls: Array, count: int, side: int, at: Array) -> Array:
    """Return places on the polynomials of a side, (n, 3)."""
    ring = controls.reshape(count, 2 * DEGREE, 3)
    points = np.concatenate((ring[side], ring[(side + 1) % count][:1]))
    first = bernstein(np.minimum(2.0 * at, 1.0)) @ points[: DEGREE + 1]
    second = bernstein(np.maximum(2.0 * at - 1.0, 0.0)) @ points[DEGREE:]
    return np.asarray(np.where((at <= 0.5)[:, None], first, second))


def sweep_of(sides: tuple[Side, ...], origin: Array, size: float) -> Sweep | None:
    """Return the sweep that a loop of three or four sides is; None where it is none.

    Parameters
    ----------
    sides : tuple of Side
        Head to tail.
    origin : (3,) float
        Of the loop's frame, mm.
    size : float
        Of the loop, mm.
    """
    count = len(sides)
    if count not in (3, 4) or any(side.bend for side in sides):
        return None
    every = [SidePlaces.of(side, origin, size) for side in sides]
    pairs = ((0, 2), (3, 1)) if count == 4 else ((0, 1), (1, 2), (2, 0))
    found = [_between(every, first, last) for first, last in pairs]
    sound = [one for one in found if one is not None]
    return min(sound, key=lambda one: one.off + TURNING * one.screw.angle) if sound else None


def _between(every: list[SidePlaces], first: int, last: int) -> Sweep | None:
    """Return the motion of one side into another if it is one, and the others are its orbits."""
    count = len(every)
    start, end = every[first], every[last].reversed()
    one, two = start.by_length(), end.by_length()
    orbits = [(every[first - 1].reversed(), start.places[0])]
    if count == 4:
        orbits.append((every[(first + 1) % count], start.places[-1]))
    screw = _motion(one, two, np.array([_end_slopes(side) for side, _ in orbits]))
    if screw is None:
        return None
    ways = [screw]
    if 2.0 * np.pi - screw.angle <= MOST_TURN:
        ways.append(screw.other_way())
    away, screw = min(
        ((_off(way, one, two, orbits), way) for way in ways), key=lambda found: found[0]
    )
    if away > ALIKE:
        return None
    shares = [screw.shares(side.places, place) for side, place in orbits]
    rows = [(side, side.slopes) for side in (start, end)]
    for (side, _), share, slope in zip(orbits, shares, start.slopes[[0, -1]], strict=False):
        rows.append((side, screw.turned(np.broadcast_to(slope, side.places.shape), share)))
    if _leaning(screw, rows) > LEANING:
        return None
    return Sweep(first, last, screw, away)


def _off(screw: Screw, one: Array, two: Array, orbits: Sequence[tuple[SidePlaces, Array]]) -> float:
    """Return how far a motion of places to others, and of places along sides, is from them."""
    away = float(np.linalg.norm(screw.moved(one, np.ones(len(one))) - two, axis=1).max())
    for side, place in orbits:
        share = screw.shares(side.places, place)
        orbit = screw.moved(np.broadcast_to(place, side.places.shape), share)
        away = max(away, float(np.linalg.norm(side.places - orbit, axis=1).max()))
    return away


def _end_slopes(side: SidePlaces) -> Array:
    """Return the unit directions of a side at its start and its end, (2, 3)."""
    slopes = side.slopes[[0, -1]]
    length = np.linalg.norm(slopes, axis=1, keepdims=True)
    return np.asarray(slopes / np.maximum(length, 1e-300))


def _motion(one: Array, two: Array, ways: Array) -> Screw | None:
    """Return the rigid motion of places to others (Kabsch 1976); None where nothing tells it.

    Parameters
    ----------
    one, two : (n, 3) float
        Places.
    ways : (k, 2, 3) float
        Unit directions in which the motion begins and ends: of a line they tell the turn about it.
    """
    middle, other = one.mean(axis=0), two.mean(axis=0)
    square = (one - middle).T @ (two - other)
    square += WAYS * np.linalg.norm(square) * (ways[:, 0].T @ ways[:, 1])
    left, values, right = np.linalg.svd(square)
    if values[1] < STRAIGHT * values[0]:
        return None
    sense = np.sign(np.linalg.det(right.T @ left.T))
    turn = right.T @ np.diag((1.0, 1.0, sense)) @ left.T
    return Screw.of(turn, other - turn @ middle)


def _leaning(screw: Screw, rows: list[tuple[SidePlaces, Array]]) -> float:
    """Return the root mean square sine between normals along sides and those of a sweep.

    Parameters
    ----------
    screw : Screw
        The motion.
    rows : list of (SidePlaces, (n, 3) float)
        Each with the directions of the profile at its places.
    """
    squares: list[Array] = []
    speeds = [screw.speeds(side.places) for side, _ in rows]
    fastest = max(float(np.linalg.norm(speed, axis=1).max()) for speed in speeds)
    for (side, ways), speed in zip(rows, speeds, strict=True):
        across = cross_product(ways, speed)
        length = np.linalg.norm(across, axis=1)
        told = np.isfinite(side.normals[:, 0]) & (length > 0.0)
        told &= np.linalg.norm(speed, axis=1) > RESTING * fastest
        cosine = (across[told] * side.normals[told]).sum(axis=1) / length[told]
        squares.append(1.0 - np.minimum(cosine**2, 1.0))
    whole = np.concatenate(squares)
    return float(np.sqrt(whole.mean())) if len(whole) else 0.0
