"""Bodies that are blended two by two: which of them meet, and how each lies to the other.

Where two bodies with the values a and b are blended, the level t = (b - a) / k runs from -1, where
the blend begins on the first, to 1, where it ends on the second; k is its reach there.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.plugin import remembered
from bozzetto_silhouette.implicit.blend import reach_by_angle
from bozzetto_silhouette.implicit.composite import Composite, Row
from bozzetto_silhouette.implicit.implicit_solid import Implicit
from bozzetto_silhouette.model.state import Operation
from bozzetto_silhouette.solids.batched_answers import each
from bozzetto_silhouette.solids.body import Body

FELT = 2.0
"""Distance between boxes, in reaches, up to which bodies may be blended: the promise of `Implicit`
on values outside is no better."""

TOUCHING = 0.05
"""Gap between bodies, as a share of the reach, up to which they count as touching."""

BRIDGED = 0.5
"""The same for bodies that merge."""


class Apart(Exception):
    """Strips do not suit some bodies; `groups` are the numbers of those that should be united."""

    def __init__(self, *groups: set[int]) -> None:
        super().__init__()
        self.groups = groups


class Contact(NamedTuple):
    """Two bodies, by number, that are blended where they meet, and the composite that does it."""

    one: int
    other: int
    node: Composite


class Pair(NamedTuple):
    """Two bodies that are blended.

    Attributes
    ----------
    one, other : int
        Their numbers.
    solid : Composite
        Of these two alone.
    step : float
        The finer spacing of their meshes.
    """

    one: int
    other: int
    solid: Composite
    step: float

    @classmethod
    def of(cls, contact: Contact, bodies: Sequence[Body]) -> Pair:
        """Return the pair of a contact of bodies."""
        one, other = bodies[contact.one], bodies[contact.other]
        node = contact.node
        solid = Composite(one.implicit, other.implicit, node.operation, node.blend, node.reach)
        return cls(contact.one, contact.other, solid, min(one.step, other.step))

    @property
    def ends(self) -> set[int]:
        """The numbers of both."""
        return {self.one, self.other}

    @property
    def gap(self) -> float:
        """The gap up to which the two count as touching, as a share of the reach."""
        return BRIDGED if self.solid.operation == "merge" else TOUCHING


class Told(NamedTuple):
    """Pairs at n points, each at its own.

    Attributes
    ----------
    first, second : (n,) float array
        Values of both bodies.
    first_slope, second_slope : (n, 3) float array
        Their gradients.
    local, reach : (n,) float array
        Of the blend: by the thickness of the bodies, and by the angle between them, too.
    value, slope : (n,), (n, 3) float array
        Of the blended solid.
    """

    first: Array
    second: Array
    first_slope: Array
    second_slope: Array
    local: Array
    reach: Array
    value: Array
    slope: Array

    @classmethod
    def of(cls, pairs: Sequence[Pair], points: Array, ends: Index) -> Told:
        """Sample pairs; those of pair k are the points from ``ends[k]`` up to ``ends[k + 1]``."""
        alike: dict[Operation, list[int]] = {}
        for k, pair in enumerate(pairs):
            if ends[k] < ends[k + 1]:
                alike.setdefault(pair.solid.operation, []).append(k)
        if len(alike) == 1:
            return cls._alike([pair.solid for pair in pairs], points, ends)
        n = len(points)
        shapes = [(n,), (n,), (n, 3), (n, 3), (n,), (n,), (n,), (n, 3)]
        result = cls(*(np.empty(shape) for shape in shapes))
        for members in alike.values():
            at = np.concatenate([np.arange(ends[k], ends[k + 1]) for k in members])
            own = np.cumsum([0, *(ends[k + 1] - ends[k] for k in members)])
            found = cls._alike([pairs[k].solid for k in members], points[at], own)
            for column, values in zip(result, found, strict=True):
                column[at] = values
        return result

    @classmethod
    def in_any_order(cls, pairs: Sequence[Pair], number: Index, points: Array) -> Told:
        """Sample the pair with a number (n,) at each point (n, 3)."""
        order = np.argsort(number, kind="stable")
        known, counts = np.unique(number, return_counts=True)
        found = cls.of([pairs[k] for k in known], points[order], np.cumsum([0, *counts]))
        back = np.empty(len(order), np.intp)
        back[order] = np.arange(len(order))
        return cls(*(column[back] for column in found))

    @classmethod
    def _alike(cls, solids: Sequence[Composite], points: Array, ends: Index) -> Told:
        row = Row(solids, ends)
        sides = row.sides(points)
        first, second, local = sides[0], sides[1], np.asarray(sides.reach)
        reach = local if row.operation == "merge" else reach_by_angle(first, second, local)
        value, slope, _ = row.blended(sides)
        return cls(
            first.value, second.value, first.gradient, second.gradient, local, reach, value, slope
        )


class Lead(NamedTuple):
    """How far the other body of a pair leads at vertices of its two bodies.

    Attributes
    ----------
    rows : (m,) int array
        The vertices near the other body: those of the first body, and from its count on those of
        the second.
    ahead : (m,) float array
        The value of the other body less that of the vertex's own.
    reach, local : (m,) float array
        As in `Told`.
    """

    rows: Index
    ahead: Array
    reach: Array
    local: Array


class _Question(NamedTuple):
    pair: Pair
    bodies: tuple[Body, Body]


def leads_of(pairs: Sequence[Pair], bodies: Sequence[Body]) -> list[Lead]:
    """Compare the bodies of pairs at the vertices of their meshes; each pair is remembered."""
    asked = [_Question(pair, (bodies[pair.one], bodies[pair.other])) for pair in pairs]
    return each(_compared, _all_compared, asked)


def _depends_on(some: _Question) -> Hashable:
    solid = some.pair.solid
    marks = [body.mark for body in some.bodies]
    return *marks, solid.operation, solid.blend, solid.reach


@remembered(limit=512, key=_depends_on)
def _compared(some: _Question) -> Lead:
    return _all_compared([some])[0]


def _all_compared(asked: Sequence[_Question]) -> list[Lead]:
    rows, counts, points = [], [], []
    for pair, (one, other) in asked:
        near = [
            np.flatnonzero(is_near(pair, mine, own, their))
            for mine, own, their in ((one.vertices, one, other), (other.vertices, other, one))
        ]
        rows.append(np.concatenate([near[0], len(one.vertices) + near[1]]))
        counts.append((len(near[0]), len(near[1])))
        points += [one.vertices[near[0]], other.vertices[near[1]]]
    ends = np.cumsum([0, *map(len, rows)])
    if not ends[-1]:
        return [Lead(some, *(np.zeros(0),) * 3) for some in rows]
    found = Told.of([some.pair for some in asked], np.concatenate(points), ends)
    flip = np.concatenate([np.repeat([1.0, -1.0], some) for some in counts])
    columns = (flip * (found.second - found.first), found.reach, found.local)
    split = [np.split(column, ends[1:-1]) for column in columns]
    return [Lead(*some) for some in zip(rows, *split, strict=True)]


def is_near(pair: Pair, points: Array, own: Body, other: Body) -> Flags:
    """Whether points (n, 3) of one body of a pair may be near the other."""
    room = FELT * pair.solid.reach + 1.5 * own.step
    low, high = other.bounds
    return np.asarray(((points >= low - room) & (points <= high + room)).all(axis=1))


def contacts(bodies: Sequence[Body], solid: Implicit) -> list[Contact] | None:
    """Return which bodies meet; None where more is done to them than to unite them.

    Parameters
    ----------
    bodies : sequence of Body
        Those of which a solid consists.
    solid : Implicit
        A tree of composites with the functions of the bodies for leaves.
    """
    number = {body.implicit: k for k, body in enumerate(bodies)}
    found: list[Contact] = []

    def leaves(node: Implicit) -> list[int] | None:
        if node in number:
            return [number[node]]
        if not isinstance(node, Composite) or node.operation not in ("add", "merge"):
            return None
        first, second = leaves(node.first), leaves(node.second)
        if first is None or second is None:
            return None
        for i, j in product(first, second):
            room = FELT * node.reach
            one, other = bodies[i].bounds, bodies[j].bounds
            if (np.maximum(one[0] - other[1], other[0] - one[1]) <= room).all():
                found.append(Contact(min(i, j), max(i, j), node))
        return first + second

    if len(number) < len(bodies) or leaves(solid) is None:
        return None
    pairs = [Pair.of(contact, bodies) for contact in found]
    return [
        contact
        for contact, pair, lead in zip(found, pairs, leads_of(pairs, bodies), strict=True)
        if (lead.ahead > -pair.gap * lead.reach).any()
    ]
