"""Creases between patches: the angle along an edge, and tangents that make it smooth.

Over an edge with two patches the derivatives across it are blended from those in its two ends.
Where the tangents in each end are opposite, as in smooth lines that cross the edge, the patches
have one tangent plane all along it only if the *ratio* of their lengths is the same in both ends.
Smooth curves alone do not make a smooth surface: with ratios of 1 and 3 the middle of an edge
may be creased by 10°.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.geometry.patches.coons import edge_numbers
from bozzetto.geometry.patches.patch import grid_normals

if TYPE_CHECKING:
    from bozzetto.arrays import Array, Index

SMOOTH: Final = 0.1
"""Degrees below which no crease is seen: the tolerance of class A surfacing."""

CREASE_SAMPLES: Final = 33
"""Places along an edge in which its crease is measured."""

ROUNDING: Final = 64.0 * float(np.finfo(float).eps)
"""Change of the logarithm of a ratio that is no more than rounding: control points are kept, and a
length is that of a difference of two of them, which may be thirty times as far from the origin."""

KNOWN: Final = 16
"""Number of networks whose rows of joints are remembered."""

Joint = tuple[int, int]
"""Two edges that leave a node, each as ``e`` from its start or ``~e`` from its end, and make one
smooth line there."""


def crease_angles(nets: ArrayLike, sides: ArrayLike, edges: int) -> Array:
    """Return the largest angle between the tangent planes of both patches along each edge.

    Parameters
    ----------
    nets : (k, 4, 4, 3) array_like
        Control points, mm.
    sides : (k, 4) array_like of int
        As in `coons`; no edge belongs to more than two of them.
    edges : int
        How many edges there are.

    Returns
    -------
    (edges,) float
        Degrees, 0 … 180. NaN for edges of one patch and of none: they have no crease.
    """
    signed = np.asarray(sides, np.intp)
    at = np.linspace(0.0, 1.0, CREASE_SAMPLES)
    normals = np.stack(
        (
            grid_normals(nets, at, [0.0])[:, :, 0],
            grid_normals(nets, [1.0], at)[:, 0],
            grid_normals(nets, at, [1.0])[:, ::-1, 0],
            grid_normals(nets, [0.0], at)[:, 0, ::-1],
        ),
        axis=1,
    )
    along = np.where((signed < 0)[..., None, None], normals[..., ::-1, :], normals)
    along = along.reshape(-1, CREASE_SAMPLES, 3)
    numbers = edge_numbers(signed).ravel()
    order = np.argsort(numbers, kind="stable")
    twice = np.flatnonzero(numbers[order][1:] == numbers[order][:-1])
    one, other = along[order[twice]], along[order[twice + 1]]
    sine = np.linalg.norm(np.cross(one, other), axis=-1)
    angle = np.degrees(np.arctan2(sine, (one * other).sum(axis=-1)))
    found = np.full(edges, np.nan)
    found[numbers[order[twice]]] = angle.max(axis=1)
    return found


def locked(
    edges: ArrayLike,
    sides: ArrayLike,
    joints: tuple[Joint, ...],
    firmness: ArrayLike | None = None,
) -> Array:
    """Even out the tangent lengths of edges, so that joints make smooth surfaces.

    Joints in both ends of an edge that lies between their lines need one ratio of lengths, and
    so do those in the ends of the next edge in line: each such row gets the one that changes the
    logarithms of all lengths least, in the sum of squares. Where all edges are as firm, that is
    the geometric mean of the ratios, and each joint keeps the product of its two lengths. All
    tangents keep their directions.

    Parameters
    ----------
    edges : (m, 4, 3) array_like
        The tangents in a joint are opposite (the lock cannot make them so).
    sides : (k, 4) array_like of int
        As in `coons_nets`.
    joints : tuple of (int, int)
        No end of an edge is in two of them.
    firmness : (m,) array_like, optional
        Weight, above 0, of the change of each edge: an edge that was drawn is firmer than one
        that nobody has looked at.

    Returns
    -------
    (m, 4, 3) float
        Ends of edges stay bit for bit, and so do tangents that need no change. A network
        that is symmetric to the last bit stays so.
    """
    made = np.array(edges, float)
    lengths = np.linalg.norm(made[:, [1, 2]] - made[:, [0, 3]], axis=2).tolist()
    firm = [1.0] * len(made) if firmness is None else np.asarray(firmness, float).tolist()
    signed = np.asarray(sides, np.intp)
    for row in joint_rows(signed, joints):
        found = {number: _ratio(lengths, joints[number]) for number in row}
        pairs = {number: tuple(firm[max(end, ~end)] for end in joints[number]) for number in row}
        # A joint whose two lengths give way best to a change of their ratio resists it so much.
        weights = {number: 2.0 * a * b / (a + b) for number, (a, b) in pairs.items()}
        # Exact sums do not depend on their order: both sides of a car get the same.
        mean = math.fsum(
            weights[number] * sign * found[number] for number, sign in row.items()
        ) / math.fsum(weights.values())
        for number, sign in row.items():
            change = sign * mean - found[number]
            if abs(change) > ROUNDING:
                (one, other), (a, b) = joints[number], pairs[number]
                _stretch(made, one, math.exp(-change * b / (a + b)))
                _stretch(made, other, math.exp(change * a / (a + b)))
    return made


def _ratio(lengths: list[list[float]], joint: Joint) -> float:
    """Return the logarithm of the ratio of two tangents' lengths; 0 where one has none."""
    one, other = (lengths[e][0] if e >= 0 else lengths[~e][1] for e in joint)
    return math.log(other) - math.log(one) if one > 0.0 < other else 0.0


def _stretch(edges: Array, end: int, share: float) -> None:
    """Scale the tangent in one end of an edge."""
    edge, node, inner = (end, 0, 1) if end >= 0 else (~end, 3, 2)
    edges[edge, inner] = edges[edge, node] + share * (edges[edge, inner] - edges[edge, node])


def joint_rows(sides: ArrayLike, joints: tuple[Joint, ...]) -> tuple[dict[int, float], ...]:
    """Return the rows of joints that need one ratio of lengths, as in `locked`.

    Parameters
    ----------
    sides : (k, 4) array_like of int
        As in `coons_nets`.
    joints : tuple of (int, int)
        No end of an edge is in two of them.

    Returns
    -------
    tuple of dict of int to float
        For each row the numbers of its joints, each with 1, or -1 where the inverse of its ratio
        counts.
    """
    signed = np.asarray(sides, np.intp)
    return _rows(signed.tobytes(), len(signed), joints)


@lru_cache(KNOWN)
def _rows(sides: bytes, count: int, joints: tuple[Joint, ...]) -> tuple[dict[int, float], ...]:
    """Return joints that need one ratio, each with the sense in which it counts.

    A body is locked after each of its edits, and rows follow from the network alone.
    """
    return tuple(_found_rows(np.frombuffer(sides, np.intp).reshape(count, 4), joints))


def _found_rows(sides: Index, joints: tuple[Joint, ...]) -> Iterator[dict[int, float]]:
    links = _links(sides, joints)
    seen: set[int] = set()
    for first in range(len(joints)):
        if first in seen:
            continue
        senses = {first: 1.0}
        open_ = [first]
        while open_:
            number = open_.pop()
            for other, turn in links.get(number, ()):
                if other not in senses:
                    senses[other] = senses[number] * turn
                    open_.append(other)
        seen.update(senses)
        yield senses


def _links(sides: Index, joints: tuple[Joint, ...]) -> dict[int, list[tuple[int, float]]]:
    """Return for each joint those in the other ends of the edges between its lines.

    The sign says whether both name the two sides of the edge in the same order.
    """
    where = {frozenset(joint): number for number, joint in enumerate(joints)}
    sided: dict[int, tuple[int, int]] = {}
    links: dict[int, list[tuple[int, float]]] = {}
    for row in sides.tolist():
        for place, side in enumerate(row):
            # The ends that leave the start and the end of this side within the patch.
            sided[side] = (~row[place - 1], row[(place + 1) % 4])
    for side, (start, end) in sided.items():
        if side < 0 or ~side not in sided:
            continue
        other_end, other_start = sided[~side]  # that patch runs the other way
        one = where.get(frozenset((start, other_start)))
        two = where.get(frozenset((end, other_end)))
        if one is None or two is None:
            continue
        same = (joints[one][0] == start) == (joints[two][0] == end)
        turn = 1.0 if same else -1.0
        links.setdefault(one, []).append((two, turn))
        links.setdefault(two, []).append((one, turn))
    return links
