"""The plane polygon over which the patches of a loop are smooth together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array

MOST_TURN: Final = 2.64
"""Largest turn at a corner of the domain, radians: patches get no thinner."""

LEAST_TURN: Final = 0.5
"""Least turn at a corner of the domain, radians: with none a patch would be a triangle."""

FLATTEST: Final = 0.35
"""Turn in space below which all corners are alike, radians: so little tells no shape."""

EVEN_SHARE: Final = 0.6
"""Least turn at a corner, as share of that of a regular polygon."""

DIAMETER: Final = 1.6
"""Square root of the area of a domain: about that of the unit circle's squares."""

SOFTENINGS: Final = (1.0, 0.75, 0.5, 0.3, 0.15)
"""Shares of a concave corner's angle that are tried until all of the domain is seen from its
centre."""

GRID: Final = 24
"""Places along the domain's box at which a centre is looked for."""


@dataclass(frozen=True, eq=False)
class Domain:
    """A star-shaped polygon, cut into a quadrangle for each corner.

    Parameters
    ----------
    corners : (n, 2) float
        Counter-clockwise.
    middles : (n, 2) float
        Where the sides are cut: side k leads from corner k over middle k.
    centre : (2,) float
        Where the quadrangles meet.
    """

    corners: Array
    middles: Array
    centre: Array

    @property
    def key(self) -> bytes:
        """Say which domain it is, to the last bit."""
        return self.corners.tobytes() + self.middles.tobytes() + self.centre.tobytes()

    @property
    def quads(self) -> Array:
        """Return the quadrangles (corner, middle, centre, middle before), (n, 4, 2)."""
        before = np.roll(self.middles, 1, axis=0)
        centre = np.broadcast_to(self.centre, self.corners.shape)
        return np.stack((self.corners, self.middles, centre, before), axis=1)

    def places(self, u: Array, v: Array) -> Array:
        """Return the place of parameters of every patch, (n, m, 2)."""
        shares = np.stack(((1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v), axis=1)
        return np.asarray(np.einsum("mc,kcd->kmd", shares, self.quads))


def cross(a: Array, b: Array) -> Array:
    """Return the cross product of vectors in the plane, (…,)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def domain_of(lengths: Array, angles: Array, bends: Array) -> Domain:
    """Return a domain as like a loop as can be.

    Side lengths and angles are those of the loop in space; the turns at the corners are scaled
    to close the polygon. Sides bend only at concave corners of the loop.

    Parameters
    ----------
    lengths : (n, 2) float
        Of the first and second half of each side.
    angles : (n,) float
        Between the sides at each corner, radians.
    bends : (n,) float
        How far each side bends inward at its middle, radians; 0 where it is smooth.
    """
    if len(lengths) == 3 and not bends.any():
        turn = 2 * np.pi * np.arange(3) / 3
        corners = np.column_stack((np.cos(turn), np.sin(turn)))
        return _cut(corners, lengths)
    best: Domain | None = None
    best_room = -np.inf
    for share in SOFTENINGS:
        made = _polygon(lengths, angles, share * bends)
        centre, room = _centre(made, straight=not bends.any())
        if best is None or room > best_room:
            best, best_room = Domain(made[0::2], made[1::2], centre), room
        if room > 0.08 or not bends.any():
            break
    if best is None or best_room <= 0.0:
        return regular_domain(len(lengths), lengths)
    return best


def regular_domain(count: int, lengths: Array) -> Domain:
    """Return a regular polygon, cut where the lengths of the halves say."""
    turn = 2 * np.pi * np.arange(count) / count
    radius = DIAMETER / np.sqrt(0.5 * count * np.sin(2 * np.pi / count))
    return _cut(radius * np.column_stack((np.cos(turn), np.sin(turn))), lengths)


def _cut(corners: Array, lengths: Array) -> Domain:
    share = (lengths[:, 0] / lengths.sum(axis=1))[:, None]
    middles = (1.0 - share) * corners + share * np.roll(corners, -1, axis=0)
    return Domain(corners, middles, _middle(corners, middles, straight=True))


def _middle(corners: Array, middles: Array, *, straight: bool) -> Array:
    """Return the mean of the corners; of four straight sides, where lines between middles meet.

    There what opposite sides have in common can be carried from one to the other
    (`opposite_sides`).
    """
    if len(corners) == 4 and straight:
        (a, b), way = middles[:2], middles[2:] - middles[:2]
        angle = float(cross(way[0], way[1]))
        if abs(angle) > 1e-6:
            return np.asarray(a + float(cross(b - a, way[1])) / angle * way[0])
    return np.asarray(corners.mean(axis=0))


def _polygon(lengths: Array, angles: Array, bends: Array) -> Array:
    """Return corners and middles in turn, (2 n, 2)."""
    count = len(lengths)
    turn = np.empty(2 * count)
    turn[0::2] = _turns(np.pi - angles, 2 * np.pi + float(bends.sum()))
    turn[1::2] = -bends
    turn[0] = 0.0
    way = np.cumsum(turn)
    sides = lengths.ravel()[:, None] * np.column_stack((np.cos(way), np.sin(way)))
    sides -= lengths.ravel()[:, None] / lengths.sum() * sides.sum(axis=0)
    ring = np.concatenate((np.zeros((1, 2)), np.cumsum(sides, axis=0)[:-1]))
    straight = bends == 0.0
    share = (lengths[:, 0] / lengths.sum(axis=1))[:, None]
    chord = (1.0 - share) * ring[0::2] + share * np.roll(ring[0::2], -1, axis=0)
    ring[1::2] = np.where(straight[:, None], chord, ring[1::2])
    area = 0.5 * abs(float(cross(ring, np.roll(ring, -1, axis=0)).sum()))
    ring -= ring[0::2].mean(axis=0)
    return np.asarray(ring * DIAMETER / np.sqrt(max(area, 1e-12)))


def _turns(turns: Array, total: float) -> Array:
    """Return turns in proportion, between the least and the most, that sum to a total."""
    least = min(LEAST_TURN, EVEN_SHARE * total / len(turns))
    low, high = 0.0, 1e3
    for _ in range(60):
        factor = 0.5 * (low + high)
        made = np.clip(factor * np.maximum(turns, FLATTEST), least, MOST_TURN)
        low, high = (factor, high) if made.sum() < total else (low, factor)
    return np.asarray(made * total / made.sum())


def _centre(ring: Array, *, straight: bool) -> tuple[Array, float]:
    """Return a place from which all of a polygon is seen, and its least room to any side's line.

    It is also beyond the lines that cut the corners off, from middle to middle, so that no
    quadrangle is bent inward there. Their own middle is taken if it has enough room; else the place
    with the most.
    """
    after = np.concatenate((np.roll(ring, -1, axis=0), ring[1::2]))
    start = np.concatenate((ring, np.roll(ring[1::2], 1, axis=0)))
    way = after - start
    way = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-12)

    def room(places: Array) -> Array:
        return np.asarray(cross(way[None], places[:, None] - start[None]).min(axis=1))

    mean = _middle(ring[0::2], ring[1::2], straight=straight)
    here = float(room(mean[None])[0])
    if here > 0.25:
        return mean, here
    low, high = ring.min(axis=0), ring.max(axis=0)
    x, y = np.meshgrid(*(np.linspace(a, b, GRID) for a, b in zip(low, high, strict=True)))
    tried = np.column_stack((x.ravel(), y.ravel()))
    rooms = room(tried)
    most = int(np.argmax(rooms))
    if rooms[most] <= here:
        return mean, here
    return tried[most], float(rooms[most])
