"""Faces of a wireframe in space, where its lines alone do not tell them.

Planes through two lines of a corner gather the corners near them; the lines in a plane bound
regions; and the regions are chosen so that every line lies between two faces, by a small integer
programme.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring, neighbors_of
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.orientation import lines_of

FLATTEST: Final = 0.2
"""Least sine of the angle between two lines that span a plane."""

MOST_CANDIDATES: Final = 400
"""Regions among which faces are chosen."""

SECONDS: Final = 0.5
"""Longest time of the integer programme."""

_FACE, _AREA, _BENT, _OPEN = 0.02, 0.3, 5.0, 10.0
"""Costs of a face, of its area, of its distance from a plane, and of a side without a face."""


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A region that may be a face, and what it costs."""

    rings: Rings
    cost: float


def planar_faces(points: Array, lines: Index, tolerance: float) -> tuple[Rings, ...]:
    """Choose planar faces so that as many lines as possible lie between two of them.

    Parameters
    ----------
    points : (n, 3) array
        Corners in space, of about unit size.
    lines : (m, 2) array of int
        The smaller corner first.
    tolerance : float
        Distance of a corner from a plane in which it may lie.
    """
    candidates: list[_Candidate] = []
    for members, normal in _planes(points, lines, tolerance):
        candidates += _regions(points, lines, members, normal)
    candidates = sorted(candidates, key=lambda each: each.cost)[:MOST_CANDIDATES]
    return _chosen(candidates, lines) if candidates else ()


def inside(places: Array, ring: Array) -> Flags:
    """Whether places are inside a polygon, (k,) of bool, by the parity of crossings."""
    following = np.roll(ring, -1, axis=0)
    between = (ring[:, 1] > places[:, None, 1]) != (following[:, 1] > places[:, None, 1])
    rise = following[:, 1] - ring[:, 1]
    share = (places[:, None, 1] - ring[:, 1]) / np.where(rise == 0.0, 1.0, rise)
    left = places[:, None, 0] < ring[:, 0] + share * (following[:, 0] - ring[:, 0])
    return np.asarray((between & left).sum(1) % 2 == 1, bool)


def _planes(points: Array, lines: Index, tolerance: float) -> list[tuple[frozenset[int], Array]]:
    """Return the largest sets of corners in one plane, with its normal."""
    found: dict[frozenset[int], Array] = {}
    neighbors = neighbors_of(lines)
    for corner in sorted(neighbors):
        around = sorted(neighbors[corner])
        for place, first in enumerate(around):
            for second in around[place + 1 :]:
                plane = _plane_through(points, (corner, first, second), tolerance)
                if plane is not None:
                    found.setdefault(*plane)
    return [
        (members, normal)
        for members, normal in found.items()
        if not any(members < other for other in found)
    ]


def _plane_through(
    points: Array, seed: tuple[int, int, int], tolerance: float
) -> tuple[frozenset[int], Array] | None:
    """Return the corners near the plane through three of them, after fitting it to them."""
    middle = points[seed[0]]
    first, second = points[seed[1]] - middle, points[seed[2]] - middle
    normal = np.cross(first, second)
    size = float(np.linalg.norm(normal))
    if size < FLATTEST * float(np.linalg.norm(first) * np.linalg.norm(second)) or size == 0.0:
        return None
    normal = normal / size
    near = np.abs((points - middle) @ normal) < tolerance
    for _ in range(2):
        near[list(seed)] = True
        middle = points[near].mean(0)
        normal = np.linalg.svd(points[near] - middle)[2][2]
        near = np.abs((points - middle) @ normal) < tolerance
    near[list(seed)] = True
    return frozenset(np.flatnonzero(near).tolist()), normal


def _regions(
    points: Array, lines: Index, members: frozenset[int], normal: Array
) -> list[_Candidate]:
    """Return the regions that the lines in a plane bound, with and without their holes."""
    frame = np.linalg.svd(normal[None])[2][1:]
    flat = points @ frame.T
    inner = [line for line in lines.tolist() if line[0] in members and line[1] in members]
    rings: dict[frozenset[int], Ring] = {}
    for ring in _bounded(flat, inner):
        rings.setdefault(frozenset(ring), ring)
    areas = {key: abs(_area(flat[list(ring)])) for key, ring in rings.items()}
    found = []
    for key, ring in rings.items():
        places = points[list(ring)]
        bent = float(np.abs((places - places.mean(0)) @ normal).max())
        holes = _holes(flat, rings, areas, key)
        found.append(_Candidate((ring,), _FACE + _AREA * areas[key] + _BENT * bent))
        if holes:
            area = areas[key] - sum(areas[hole] for hole in holes)
            whole = (ring, *(rings[hole] for hole in holes))
            found.append(_Candidate(whole, _FACE + _AREA * area + _BENT * bent))
    return found


def _holes(
    flat: Array,
    rings: dict[frozenset[int], Ring],
    areas: dict[frozenset[int], float],
    outer: frozenset[int],
) -> list[frozenset[int]]:
    """Return the largest rings that lie inside one and share no corner with it."""
    around = flat[list(rings[outer])]
    within = [
        key
        for key in rings
        if areas[key] < areas[outer]
        and not key & outer
        and inside(flat[list(rings[key])], around).all()
    ]
    return [
        key
        for key in within
        if not any(
            other != key
            and areas[other] > areas[key]
            and inside(flat[list(rings[key])], flat[list(rings[other])]).any()
            for other in within
        )
    ]


def _bounded(flat: Array, lines: Sequence[Sequence[int]]) -> list[Ring]:
    """Return the simple rings round which lines in a plane lead, always turning left."""
    around = neighbors_of(lines)
    loose = [corner for corner, near in around.items() if len(near) < 2]
    while loose:
        corner = loose.pop()
        for other in around.pop(corner, set()):
            around[other].discard(corner)
            if len(around[other]) < 2:
                loose.append(other)
    ordered = {corner: _round(flat, corner, near) for corner, near in around.items() if near}
    seen: set[tuple[int, int]] = set()
    found = []
    for start in sorted(ordered):
        for following in ordered[start]:
            ring = []
            step = (start, following)
            while step not in seen:
                seen.add(step)
                ring.append(step[0])
                turns = ordered[step[1]]
                step = step[1], turns[turns.index(step[0]) - 1]
            if len(ring) >= 3 and len(set(ring)) == len(ring):
                found.append(tuple(ring))
    return [ring for ring in found if abs(_area(flat[list(ring)])) > 1e-9]


def _round(flat: Array, corner: int, near: set[int]) -> list[int]:
    """Return neighbours of a corner in the order of their bearings."""
    others = sorted(near)
    spans = flat[others] - flat[corner]
    return [others[k] for k in np.argsort(np.arctan2(spans[:, 1], spans[:, 0]), kind="stable")]


def _area(ring: Array) -> float:
    """Return the signed area of a polygon."""
    following = np.roll(ring, -1, axis=0)
    return float(0.5 * (ring[:, 0] * following[:, 1] - following[:, 0] * ring[:, 1]).sum())


def _chosen(candidates: Sequence[_Candidate], lines: Index) -> tuple[Rings, ...]:
    """Return the cheapest candidates that leave few sides of lines open."""
    number = {(int(a), int(b)): k for k, (a, b) in enumerate(lines)}
    count, slack = len(candidates), len(lines)
    use = np.zeros((slack, count + slack))
    for column, candidate in enumerate(candidates):
        for first, second in lines_of(candidate.rings):
            use[number[min(first, second), max(first, second)], column] += 1.0
    use[:, count:] = np.eye(slack)
    costs = np.concatenate(([each.cost for each in candidates], np.full(slack, _OPEN)))
    solved = milp(
        costs,
        constraints=[LinearConstraint(use, 2.0, 2.0)],
        integrality=np.ones(count + slack, np.int64),
        bounds=Bounds(0.0, np.concatenate((np.ones(count), np.full(slack, 2.0)))),
        options={"time_limit": SECONDS},
    )
    if solved.x is None:
        return ()
    return tuple(
        each.rings for each, taken in zip(candidates, solved.x, strict=False) if taken > 0.5
    )
