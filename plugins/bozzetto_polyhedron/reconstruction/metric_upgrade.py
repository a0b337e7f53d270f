"""The numbers that affine facts leave open, found by regularity: three, and one for each change.

A class of affine slope s and direction u on the sheet rises as w = a s + b u_x + c u_y. Three
directions that are orthogonal in space determine (a, b, c) in closed form; further candidates come
from a grid. All are refined together. Where lines and faces leave a change of the depths open, such
as the height of a pyramid on a box, several multiples t of it are tried with each.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import combinations, product
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_polyhedron.reconstruction.ranking_weights import WEIGHTS
from bozzetto_polyhedron.reconstruction.regularity import (
    CHEAP,
    MEASURES,
    Relief,
    all_measures,
    cheap_measures,
)

HEAVIEST: Final = 9
"""Classes of which orthogonal triples are tried."""

STEEPEST: Final = 0.12
"""Least share of an axis that shows on the sheet: one that points at the eye has no direction."""

BEST_OF_GRID: Final = 10
"""Candidates that are taken from the grid."""

OF_EACH: Final = 3
"""Multiples of a change that are kept with each candidate."""

CHANGES: Final = np.linspace(-1.05, 1.05, 15)
"""Multiples of a change that are tried, diagonals at the corner that moves most."""

WIDE: Final = 0.1
"""Cosine at which an angle counts half as a right one while candidates are far from regular."""

WIDE_ROUNDS: Final = 10
"""Steps of the pattern search with wide tolerances."""

ROUNDS: Final = 10
"""Steps of the pattern search with those that the noise asks for."""

SEARCH_WEIGHTS: Final = np.array((2.1, 2.2, 2.4, 1.75, -2.0, -3.0, 1.5, 1.5))
"""Weights of the cheap measures while searching: right angles above all, so that it ends there."""

REGULARITY: Final = np.array([WEIGHTS[name] for name in MEASURES])
"""Weights of all measures, as readings are ranked."""

FRAME: Final = 0.75
"""Share of the lines along three axes from which on right angles tell the map: pyramids and frusta
have about a half."""

MOST_CORNERS: Final = 16
"""Corners of a part up to which maps are sought by all measures: mirror planes take long, and few
solids without right angles have more."""

MOST_SYMMETRIC: Final = 200
"""Maps of the grid, the most regular by the cheap measures, that are compared by all of them."""

BEST_SYMMETRIC: Final = 5
"""Different ones that are refined by all measures."""

SYMMETRIC_ROUNDS: Final = 12
"""Steps of their pattern search."""

HALVINGS: Final = 6
"""Steps by which the multiple of a change is refined."""

WORSE: Final = 0.3
"""Score that right angles may cost where a change of the depths makes them."""

SQUARING: Final = 8
"""Steps that make angles right together."""

LONGEST: Final = 0.1
"""Largest change of the map in one of these steps."""

INDEPENDENT: Final = 1e-3
"""Share of the largest singular value below which right angles say nothing."""

SAME: Final = 4.0
"""Mean angle between the lines of two readings, degrees, below which they are one."""


def orthogonal_rises(directions: Array) -> Array | None:
    """Return how much three orthogonal axes rise for each unit on the sheet.

    Parameters
    ----------
    directions : (3, 2) array
        Unit vectors of the axes on the sheet.

    Returns
    -------
    (3,) array or None
        Up to one common sign, the mirrored reading. None if no orthogonal axes look like this.

    Notes
    -----
    Orthogonality asks u_i . u_j + w_i w_j = 0 for each pair, so w_1^2 = -c_12 c_13 / c_23.
    """
    first, second, third = directions
    near, far, across = first @ second, first @ third, second @ third
    if near * far * across >= -1e-9:
        return None
    rise = np.sqrt(-near * far / across)
    return np.array([rise, -near / rise, -far / rise])


def metric_maps(relief: Relief, most: int) -> Array:
    """Find the most regular maps, (k, 3 + j), no two nearly alike.

    A map is Z = a z + b x + c y + t e, with a > 0 and a number t for each change e. Those that make
    three classes exactly orthogonal are kept beside those that were refined.

    Parameters
    ----------
    relief : Relief
        What is compared.
    most : int
        Number of refined maps, and of exact ones.
    """
    exact = _changed(relief, np.array(_from_triples(relief)).reshape(-1, 3))
    exact = _ordered(relief, exact, relief.right)
    grid = _grid(relief)
    maps = _changed(relief, _best_of(relief, grid))
    maps = _ordered(relief, np.vstack((exact, maps)), WIDE)
    maps = _distinct(relief, maps)[: most + 2]
    for right, rounds in ((WIDE, WIDE_ROUNDS), (relief.right, ROUNDS)):
        steps = (0.15 if right >= WIDE else 0.03) * np.maximum(0.3, np.abs(maps))
        maps = _refined(maps, steps, rounds, partial(_square, relief, right))
    maps = _distinct(relief, _ordered(relief, maps, relief.right))[:most]
    every = np.vstack((maps, _distinct(relief, exact)[:most]))
    if every.shape[1] > 3:
        return _settled(relief, every)
    if len(relief.used) > MOST_CORNERS or _has_frame(relief, every):
        return every
    return np.vstack((_symmetric(relief, grid), every))


def _has_frame(relief: Relief, maps: Array) -> bool:
    """Whether most lines of some map run along three axes, so that right angles tell the map."""
    coverage = all_measures(relief, maps)[:, MEASURES.index("frame coverage")]
    return bool(coverage.max(initial=0.0) >= FRAME)


def _symmetric(relief: Relief, grid: Array) -> Array:
    """Return the maps of a grid that all measures find most regular, refined by all of them.

    Pyramids and frusta have few right angles: equal angles, equal lengths and mirror planes tell
    their maps.
    """
    cheap = cheap_measures(relief, grid) @ REGULARITY[:CHEAP]
    maps = grid[np.argsort(-cheap, kind="stable")[:MOST_SYMMETRIC]]
    maps = maps[np.argsort(-_regularity(relief, maps), kind="stable")]
    maps = _distinct(relief, maps)[:BEST_SYMMETRIC]
    steps = 0.15 * np.maximum(0.3, np.abs(maps))
    return _refined(maps, steps, SYMMETRIC_ROUNDS, lambda each: _regularity(relief, each))


def _changed(relief: Relief, maps: Array) -> Array:
    """Return maps (k, 3) with the multiples of each change that are most regular, (k', 3 + j)."""
    for number in range(relief.depths.shape[1] - 1):
        if not len(maps):
            break
        rest = relief.depths.shape[1] - 2 - number
        tried = np.column_stack(
            (np.repeat(maps, len(CHANGES), axis=0), np.tile(CHANGES, len(maps)))
        )
        values = cheap_measures(relief, np.pad(tried, ((0, 0), (0, rest))), WIDE) @ SEARCH_WEIGHTS
        best = np.argsort(-values.reshape(len(maps), -1), axis=1, kind="stable")[:, :OF_EACH]
        rows = (np.arange(len(maps))[:, None] * len(CHANGES) + best).ravel()
        maps = tried[rows]
    return np.pad(maps, ((0, 0), (0, 2 + relief.depths.shape[1] - maps.shape[1])))


def _settled(relief: Relief, maps: Array) -> Array:
    """Return maps with the multiples of changes that all measures together find most regular."""
    kept: dict[bytes, Array] = {}
    for chosen in maps:
        kept.setdefault(chosen[:3].round(2).tobytes(), chosen)
    ways, origin = np.array(list(kept.values())), np.arange(len(kept))
    for number in range(3, maps.shape[1]):
        ways, of = _along(relief, ways, number)
        origin = origin[of]
    values = _regularity(relief, ways)
    found = []
    for each in range(len(kept)):
        own = np.flatnonzero(origin == each)
        found += ways[own[np.argsort(-values[own], kind="stable")[:OF_EACH]]].tolist()
    return np.array(found)


def _along(relief: Relief, ways: Array, number: int) -> tuple[Array, Index]:
    """Return maps with one number at its most regular values, and from which of `ways` each is."""
    tried = np.repeat(ways, len(CHANGES), axis=0)
    tried[:, number] = np.tile(CHANGES, len(ways))
    values = _regularity(relief, tried).reshape(len(ways), -1)
    around = np.pad(values, ((0, 0), (1, 1)), constant_values=-np.inf)
    peaks = (values >= around[:, :-2]) & (values >= around[:, 2:])
    order = np.argsort(np.where(peaks, -values, np.inf), axis=1, kind="stable")[:, :OF_EACH]
    of, place = np.nonzero(np.take_along_axis(peaks, order, axis=1))
    chosen = order[of, place]
    made, best, step = ways[of], values[of, chosen], CHANGES[1] - CHANGES[0]
    made[:, number] = CHANGES[chosen]
    for _ in range(HALVINGS):
        step *= 0.5
        sides = np.stack((made, made))
        sides[0, :, number] -= step
        sides[1, :, number] += step
        others = _regularity(relief, sides.reshape(-1, ways.shape[1])).reshape(2, -1)
        side = np.where(others[0] > best, 0, 1)
        rows = np.arange(len(made))
        better = others[side, rows] > best
        made = np.where(better[:, None], sides[side, rows], made)
        best = np.where(better, others[side, rows], best)
    return made, of


def _regularity(relief: Relief, maps: Array) -> Array:
    """Return the score of maps by all measures of regularity, (k,)."""
    return np.asarray(all_measures(relief, maps) @ REGULARITY)


def _ordered(relief: Relief, maps: Array, right: float) -> Array:
    """Return maps, the best first."""
    values = cheap_measures(relief, maps, right) @ SEARCH_WEIGHTS
    return maps[np.argsort(-values, kind="stable")]


def _from_triples(relief: Relief) -> list[Array]:
    """Return maps that make three classes orthogonal."""
    drawn = relief.points[relief.lines[:, 1]] - relief.points[relief.lines[:, 0]]
    along = np.abs(drawn @ relief.directions.T).max(1).mean()
    heaviest = np.argsort(-relief.counts * max(1e-9, float(along)), kind="stable")[:HEAVIEST]
    found = []
    for triple in combinations(heaviest.tolist(), 3):
        rises = orthogonal_rises(relief.directions[list(triple)])
        if rises is None or (1.0 / np.hypot(1.0, rises)).min() < STEEPEST:
            continue
        system = relief.slopes[list(triple), :3]
        if np.linalg.cond(system) > 1e4:
            continue
        chosen = np.linalg.solve(system, rises)
        if abs(chosen[0]) > 1e-3:
            found.append(chosen * np.sign(chosen[0]))
    return found


def _grid(relief: Relief) -> Array:
    """Return maps of all kinds, (k, 3)."""
    used = np.unique(relief.lines)
    scale = relief.points[used].std(0).mean() / max(1e-9, float(relief.depths[used, 0].std()))
    tilts = np.linspace(-1.8, 1.8, 10)
    return np.array(list(product(scale * np.array((0.35, 0.55, 0.8, 1.1, 1.6)), tilts, tilts)))


def _best_of(relief: Relief, grid: Array) -> Array:
    """Return the best maps of a grid, with a wide tolerance for right angles."""
    still = np.pad(grid, ((0, 0), (0, relief.depths.shape[1] - 1)))
    values = _square(relief, 0.3, still)
    return np.asarray(grid[np.argsort(-values, kind="stable")[:BEST_OF_GRID]])


def _square(relief: Relief, right: float, maps: Array) -> Array:
    """Return what the search by right angles looks for, (k,)."""
    return np.asarray(cheap_measures(relief, maps, right) @ SEARCH_WEIGHTS)


def _refined(maps: Array, steps: Array, rounds: int, value_of: Callable[[Array], Array]) -> Array:
    """Return maps after a pattern search from all of them at once."""
    count = maps.shape[1]
    ways = [s for s in product((-1, 0, 1), repeat=count) if 0 < np.abs(s).sum() < 3]
    around_one = np.array(ways, float)
    values = value_of(maps)
    number = np.arange(len(maps))
    for _ in range(rounds):
        around = maps[:, None] + steps[:, None] * around_one
        around[..., 0] = np.maximum(around[..., 0], 1e-3)
        found = value_of(around.reshape(-1, count)).reshape(len(maps), -1)
        best = found.argmax(1)
        better = found[number, best] > values + 1e-6
        maps = np.where(better[:, None], around[number, best], maps)
        values = np.where(better, found[number, best], values)
        steps = np.where(better[:, None], steps, 0.5 * steps)
    return maps


def squared(relief: Relief, chosen: Array) -> Array:
    """Return a map in which all angles that are nearly right in it are right, if there is one.

    A search ends near the most regular map, never on it. Gauss-Newton on the cosines between
    classes ends on it where the drawing agrees with itself: without noise the solid is exact. Where
    right angles leave something open, the shortest step leaves it as it is; where they contradict
    one another by more than the noise, the map stays, as it does where right angles would lead far
    away to a less regular one: opposite lines of a regular tetrahedron are square to one another,
    and so are those of many others. A change of the depths takes part only where
    that costs nothing else: of lines that no other is parallel to, some are square to others by
    chance.

    Parameters
    ----------
    relief : Relief
        What is compared.
    chosen : (3 + j,) float64
        The map.
    """
    if len(chosen) > 3:
        found = _squared(relief, chosen, len(chosen))
        if _as_regular(relief, found, chosen):
            return found
    found = _squared(relief, chosen, 3)
    far = len(_distinct(relief, np.stack((chosen, found)))) > 1
    return chosen if far and not _as_regular(relief, found, chosen) else found


def _as_regular(relief: Relief, found: Array, chosen: Array) -> bool:
    """Whether one map is about as regular as another one by all measures."""
    after, before = _regularity(relief, np.stack((found, chosen)))
    return bool(after > before - WORSE)


def _squared(relief: Relief, chosen: Array, count: int) -> Array:
    """Return a map of which the first numbers make angles right."""
    pairs = np.array(list(combinations(range(len(relief.counts)), 2)), np.intp).reshape(-1, 2)
    pairs = pairs[np.abs(_cosines(relief, chosen, pairs)[0]) < relief.right]
    if not len(pairs):
        return chosen
    counts = np.sqrt(relief.counts[pairs].min(1))
    found = chosen.copy()
    for _ in range(SQUARING):
        values, slopes = _cosines(relief, found, pairs)
        rows = counts[:, None] * slopes[:, :count]
        step = np.linalg.lstsq(rows, -counts * values, rcond=INDEPENDENT)[0]
        longest = float(np.abs(step).max(initial=0.0)) / LONGEST
        found[:count] += step / max(1.0, longest)
        if found[0] < 1e-3:
            return chosen
    agree = np.abs(_cosines(relief, found, pairs)[0]).max() < relief.noise
    return found if agree else chosen


def _cosines(relief: Relief, chosen: Array, pairs: Index) -> tuple[Array, Array]:
    """Return cosines between classes (p,), and how they change with the map, (p, 3 + j)."""
    rising = relief.slopes
    rises = rising @ chosen
    lengths = np.hypot(1.0, rises)
    flat = relief.directions
    first, second = pairs.T
    dots = (flat[first] * flat[second]).sum(1) + rises[first] * rises[second]
    values = dots / (lengths[first] * lengths[second])
    by_first = rises[second] / (lengths[first] * lengths[second])
    by_first -= values * rises[first] / lengths[first] ** 2
    by_second = rises[first] / (lengths[first] * lengths[second])
    by_second -= values * rises[second] / lengths[second] ** 2
    return values, by_first[:, None] * rising[first] + by_second[:, None] * rising[second]


def _distinct(relief: Relief, maps: Array) -> Array:
    """Return maps without those whose lines run like those of a better one."""
    directions = relief.unit_directions(maps)
    cosines = np.abs(np.einsum("icd,jcd->ijc", directions, directions))
    angles = np.degrees(np.arccos(np.clip(cosines, 0.0, 1.0))) @ relief.counts / relief.counts.sum()
    kept: list[int] = []
    for number in range(len(maps)):
        if (angles[number, kept] > SAME).all():
            kept.append(number)
    return maps[kept]
