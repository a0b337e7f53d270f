"""A line on the body as places on its patches, with crossings from patch to patch.

A *path* is `Places` in order. Between two places of one patch it runs smoothly in u and v, so it
never leaves the surface. Where it goes on to another patch, one point is in it twice: as a place on
the shared edge of either patch. Shared edges have the same parameter on both sides, so both places
stay one point when the body changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags
from bozzetto.geometry.patches import Places, bernstein, points_at, sides_of
from bozzetto_car.template.model import Template

SAME: Final = 1e-6
"""Distance, mm, below which two places are one point."""

GAP: Final = 1e-3
"""Distance, mm, from which a line is broken where it goes on to another patch. What was one point
up to `SAME` may be twice as far apart on a larger body."""

CORNERS: Final = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
"""u and v of the nodes of a patch, in their order; side k leads from the k-th to the next."""

LARGEST_DETOUR: Final = 1.0
"""Largest distance of a crossing from the straight line between two places, per length of that
line."""

EDGE_PLACES: Final = 65
"""Places of an edge that are tried where the line between two places misses it."""

CROWDED: Final = 0.3
"""Distance of a place from a crossing, per step beyond it, below which it is left out: the rounding
of places that are too close would show in a smooth line through them."""

FEWEST: Final = 4
"""Fewest places on a patch, with ends and crossings, that a cubic needs."""

REAL: Final = 1e-7
"""Imaginary part of a root that counts as rounding."""


def join_paths(paths: Sequence[Places]) -> Places:
    """Return paths one after the other as one."""
    if not paths:
        return Places(np.zeros(0, np.intp), np.zeros((0, 2)))
    return Places(
        np.concatenate([path.patches for path in paths]),
        np.concatenate([path.parameters for path in paths]),
    )


def split_at_gaps(nets: Array, places: Places) -> list[Places]:
    """Cut a line where two places of different patches are not one point."""
    if not len(places):
        return []
    apart = np.linalg.norm(np.diff(points_at(nets, places), axis=0), axis=1) > GAP
    cuts = np.flatnonzero((np.diff(places.patches) != 0) & apart) + 1
    return [places[part] for part in np.split(np.arange(len(places)), cuts)]


def is_closed(nets: Array, path: Places) -> bool:
    """Whether a path ends where it begins."""
    ends = points_at(nets, path[np.array([0, -1])])
    return len(path) > FEWEST and bool(np.linalg.norm(ends[1] - ends[0]) <= GAP)


# -- from patch to patch ---------------------------------------------------------------------------


def connect_places(
    template: Template, nets: Array, places: Places, sight: Array, passing: Flags | None = None
) -> list[Places]:
    """Make paths of places that lie close together along a line.

    Parameters
    ----------
    template : Template
        The template of the body.
    nets : (k, 4, 4, 3) float
        Control nets of the body, mm.
    places : Places
        All of them on patches.
    sight : (n, 3) float
        At each place a direction along which the way to the next place looks straight: the line
        of sight, or the normal of the surface. Of any length above 0.
    passing : (n,) bool, optional
        Places that only help to find crossings of edges. They are left out unless a path begins
        or ends there.

    Returns
    -------
    list of Places
        The paths with the crossings of edges; cut where no edge leads to the next patch.
    """
    if not len(places):
        return []
    points = points_at(nets, places)
    extra = np.zeros(len(places), bool) if passing is None else passing
    paths: list[Places] = []
    made: list[Places] = []
    flags: list[Flags] = []
    start = 0
    for cut in [*(np.flatnonzero(np.diff(places.patches)) + 1).tolist(), len(places)]:
        made.append(places[start:cut])
        flags.append(extra[start:cut])
        start, between = cut, None
        if cut < len(places):
            pair = slice(cut - 1, cut + 1)
            between = _crossing(template, nets, places[pair], points[pair], sight[cut - 1])
        if between is None:
            paths.append(_thinned(nets, join_paths(made), np.concatenate(flags)))
            made, flags = [], []
        else:
            made.append(between)
            flags.append(np.zeros(len(between), bool))
    return paths


def _crossing(
    template: Template, nets: Array, pair: Places, ends: Array, sight: Array
) -> Places | None:
    """Return where the line between two places leaves one patch, and that point on the other.

    Returns no place if both are one point already, and None if there is no such crossing.
    """
    one, other = (template.patches[number] for number in pair.patches)
    length = float(np.linalg.norm(ends[1] - ends[0]))
    if length <= SAME:
        return pair[:0]
    limit = LARGEST_DETOUR * length + SAME
    across = np.cross(ends[1] - ends[0], sight)
    found: list[tuple[float, Array, Array]] = []
    for side, edge in enumerate(one.edges):
        if ~edge not in other.edges:
            continue
        curve = sides_of(nets[pair.patches[:1]])[0, side]
        tried = [*_roots((curve - ends[0]) @ across)] or np.linspace(0.0, 1.0, EDGE_PLACES)
        beyond = other.edges.index(~edge)
        points = bernstein(tried) @ curve
        found += [
            (_detour(point, ends), _on_side(side, at), _on_side(beyond, 1.0 - at))
            for at, point in zip(tried, points, strict=True)
        ]
    for node in {*one.nodes} & {*other.nodes} if not found else ():
        here, there = one.nodes.index(node), other.nodes.index(node)
        point = nets[pair.patches[0], -int(CORNERS[here, 0]), -int(CORNERS[here, 1])]
        found.append((_detour(point, ends), CORNERS[here], CORNERS[there]))
    best = min(found, key=lambda crossing: crossing[0], default=None)
    if best is None or best[0] > limit:
        return None
    return Places(pair.patches, np.stack(best[1:]))


def _roots(heights: Array) -> Iterator[float]:
    """Yield parameters in 0 … 1 at which a cubic with these Bernstein coefficients is 0."""
    b0, b1, b2, b3 = heights
    powers = [b3 - 3.0 * b2 + 3.0 * b1 - b0, 3.0 * (b2 - 2.0 * b1 + b0), 3.0 * (b1 - b0), b0]
    for root in np.roots(powers):
        if abs(root.imag) <= REAL and -REAL <= root.real <= 1.0 + REAL:
            yield float(np.clip(root.real, 0.0, 1.0))


def _on_side(side: int, at: float) -> Array:
    """Return the place at a share of the way along a side of a patch."""
    begin, end = CORNERS[side], CORNERS[(side + 1) % len(CORNERS)]
    return np.asarray((1.0 - at) * begin + at * end)


def _detour(point: Array, ends: Array) -> float:
    """Return the distance of a point from a straight line, mm."""
    way = ends[1] - ends[0]
    square = float(way @ way)
    share = float(np.clip((point - ends[0]) @ way / square, 0.0, 1.0)) if square > 0.0 else 0.0
    return float(np.linalg.norm(point - ends[0] - share * way))


def _thinned(nets: Array, path: Places, passing: Flags) -> Places:
    """Return a path without passing places, and without places too close to crossings and ends.

    A short run over a patch keeps all places, for they give its bend.
    """
    staying = _fixed(path) | ~passing
    run = np.cumsum(np.append(False, path.patches[1:] != path.patches[:-1]))
    path = path[staying | (np.bincount(run, staying)[run] < FEWEST)]
    fixed = _fixed(path)
    steps = np.linalg.norm(np.diff(points_at(nets, path), axis=0), axis=1)
    crowded = np.zeros(len(path), bool)
    before, after = np.append(np.inf, steps), np.append(steps, np.inf)
    crowded[1:] |= fixed[:-1] & (before[1:] < CROWDED * after[1:] + SAME)
    crowded[:-1] |= fixed[1:] & (after[:-1] < CROWDED * before[:-1] + SAME)
    return path[fixed | ~(crowded | (before <= SAME))]


def _fixed(path: Places) -> Flags:
    """Whether places are ends of a path or crossings, (n,)."""
    change = path.patches[1:] != path.patches[:-1]
    return np.asarray(np.append(True, change) | np.append(change, True))
