"""Order by the longest stroke: the others are aligned with it from end to end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto.ink.curves.resample import arc_length
from bozzetto.ink.merge.resample_all import Ordering, ResampledInk

STRIDE: Final = 2
"""Spacings of the ink to a step of the alignment."""

TURNED: Final = 4.0
"""Distance, in steps, that costs as much as a right angle between the tangents: a crossing
line that is near loses against a parallel one that is not."""

BEYOND: Final = 4.0
"""Distance, in steps, from which ink is rather beyond the end of the guide than beside it."""

HASTE: Final = 0.5
"""Cost, in squared steps, of standing still or running ahead against the guide: keeps pace."""

PACES: Final = 4
"""Most steps of the guide for one of a stroke, and one more."""

SHORTEST: Final = 3
"""Points of the shortest piece that has a direction."""

FAR: Final = 8.0
"""`BEYOND` once nothing else is left: the strokes are set off widely."""

GAP: Final = 10.0
"""Widest gap, in steps, over which ink beside no other carries the guide on."""

LEAST_BESIDE: Final = 3
"""Points of a stroke that must run beside the guide to tell where it belongs."""

MOST_ROUNDS: Final = 24
"""Most times that strokes are aligned with the guide: it grows by one of them each time."""


@dataclass(frozen=True, eq=False)
class _Path:
    """Points one step apart, with their tangents and places along the curve."""

    points: Array
    tangents: Array
    along: Array


@dataclass(frozen=True, eq=False)
class _Alignment:
    """A stroke beside the guide.

    Attributes
    ----------
    cells : (m,) int
        Number of the guide's point for each point of the stroke in the sense of the guide;
        -1 before its start, n after its end.
    cost : float
        Mean over the points, squared steps.
    backwards : bool
        The stroke runs against the guide.
    """

    cells: Index
    cost: float
    backwards: bool


def order_by_longest(ink: ResampledInk) -> Ordering | None:
    """Let the longest stroke guide the others.

    Each stroke is aligned with the guide by dynamic programming (Sakoe & Chiba 1978, with
    free ends), in the sense that is cheaper: neighbours on a stroke stay in their order, so
    laps, loops and crossings that come near one another are told apart by what came before.
    Ink that runs past an end of the guide makes the guide longer. Right for letters,
    curls and spirals drawn over and over. Ink beside no other carries the guide on over a
    gap; what is too far away for that is left out.
    """
    pieces = [numbers for numbers in ink.pieces if len(numbers) >= SHORTEST]
    if not pieces:
        return None
    pieces.sort(key=len, reverse=True)
    lengths = [arc_length(ink.points[numbers]) for numbers in pieces]
    paths = [_path(ink, *both) for both in zip(pieces, lengths, strict=True)]
    step = STRIDE * ink.spacing
    guide, reach = paths[0], BEYOND
    stations = {0: guide.along}
    for _ in range(MOST_ROUNDS):
        waiting = [k for k in range(len(pieces)) if k not in stations]
        if not waiting:
            break
        found, longer = _beside(guide, [paths[k] for k in waiting], step, reach)
        if not found and reach < FAR:
            reach = FAR
            continue
        if not found:
            longer = _joined(guide, [paths[k] for k in waiting], GAP * step)
            if longer is None:
                break
            found = dict([longer])
        if longer is not None:
            at, places = longer
            guide = _longer(guide, paths[waiting[at]], places)
        stations |= {waiting[at]: places for at, places in found.items()}
        reach = BEYOND
    place = np.concatenate([
        np.interp(lengths[k], paths[k].along, places) for k, places in stations.items()
    ])  # fmt: skip
    numbers = np.concatenate([pieces[k] for k in stations])
    extent = float(np.ptp(place))
    if not extent > 0:
        return None
    return Ordering(numbers, (place - place.min()) / extent, closed=False)


def _path(ink: ResampledInk, numbers: Index, along: Array) -> _Path:
    """Return every n-th point of a piece, and its last."""
    kept = np.unique(np.append(np.arange(0, len(numbers), STRIDE), len(numbers) - 1))
    return _Path(ink.points[numbers[kept]], ink.tangents[numbers[kept]], along[kept])


def _beside(
    guide: _Path, strokes: list[_Path], step: float, reach: float
) -> tuple[dict[int, Array], tuple[int, Array] | None]:
    """Return the strokes that run beside the guide.

    Returns
    -------
    found : dict
        Places along the guide for the points of each stroke that runs beside it all the
        way, and of one that makes it longer.
    longer : (int, (m,) float) or None
        That one: the one that runs beside the guide most closely.
    """
    found: dict[int, Array] = {}
    longer: tuple[int, Array] | None = None
    least = np.inf
    for at, made in enumerate(_aligned(guide, strokes, step, reach)):
        if ((made.cells >= 0) & (made.cells < len(guide.points))).sum() < LEAST_BESIDE:
            continue
        places = _stations(guide, strokes[at], made)
        if places.min() >= guide.along[0] and places.max() <= guide.along[-1]:
            found[at] = places
        elif made.cost < least:
            least, longer = made.cost, (at, places)
    if longer is not None:
        found[longer[0]] = longer[1]
    return found, longer


def _aligned(guide: _Path, strokes: list[_Path], step: float, reach: float) -> list[_Alignment]:
    """Align all strokes with the guide in both senses, side by side."""
    sizes = [len(stroke.points) for stroke in strokes for _ in range(2)]
    count, longest, width = len(sizes), max(sizes), len(guide.points) + 2
    costs = np.zeros((longest, count, width))
    costs[:, :, [0, -1]] = reach**2
    for row, stroke in enumerate(strokes):
        squared = ((stroke.points[:, None] - guide.points) ** 2).sum(axis=2) / step**2
        turn = stroke.tangents @ guide.tangents.T
        m = len(stroke.points)
        costs[:m, 2 * row, 1:-1] = squared + TURNED**2 * (1.0 - turn)
        costs[:m, 2 * row + 1, 1:-1] = (squared + TURNED**2 * (1.0 + turn))[::-1]
    total = costs[0]
    ends = [total]
    paces = np.zeros((longest, count, width), np.int8)
    haste = HASTE * np.abs(np.arange(PACES) - 1.0)
    tried = np.full((PACES, count, width), np.inf)
    for at in range(1, longest):
        for pace in range(PACES):
            tried[pace, :, pace:] = total[:, : width - pace] + haste[pace]
        tried[0, :, [0, -1]] -= haste[0]  # beyond the guide there is no pace
        paces[at] = np.argmin(tried, axis=0)
        total = costs[at] + tried.min(axis=0)
        ends.append(total)
    made = []
    for row in range(len(strokes)):
        best = min((2 * row, 2 * row + 1), key=lambda one: float(ends[sizes[one] - 1][one].min()))
        size = sizes[best]
        last = ends[size - 1][best]
        cell = int(np.argmin(last))
        cells = np.empty(size, np.intp)
        for at in range(size - 1, -1, -1):
            cells[at] = cell
            cell -= int(paces[at, best, cell])
        made.append(_Alignment(cells - 1, float(last.min()) / size, bool(best % 2)))
    return made


def _stations(guide: _Path, stroke: _Path, made: _Alignment) -> Array:
    """Return places along the guide for the points of a stroke, in the stroke's own order."""
    last = len(guide.points) - 1
    own = stroke.along[-1] - stroke.along[::-1] if made.backwards else stroke.along
    cells = made.cells
    stations = guide.along[np.clip(cells, 0, last)].astype(float)
    before, after = np.flatnonzero(cells <= 0), np.flatnonzero(cells >= last)
    if len(before):
        stations[before] += own[before] - own[before[-1]]
    if len(after):
        stations[after] += own[after] - own[after[0]]
    return stations[::-1] if made.backwards else stations


def _joined(guide: _Path, strokes: list[_Path], gap: float) -> tuple[int, Array] | None:
    """Extend the guide by the stroke whose end is nearest to one of its own ends."""
    ends = np.array([[stroke.points[0], stroke.points[-1]] for stroke in strokes])
    tips = guide.points[[0, -1]]
    distance = np.linalg.norm(ends[:, :, None] - tips, axis=3)
    at, end, tip = (int(i) for i in np.unravel_index(np.argmin(distance), distance.shape))
    apart = float(distance[at, end, tip])
    if apart > gap:
        return None
    along = strokes[at].along
    outward = apart + (along - along[0] if end == 0 else along[-1] - along)
    return at, guide.along[-1] + outward if tip == 1 else guide.along[0] - outward


def _longer(guide: _Path, stroke: _Path, places: Array) -> _Path:
    """Return the guide with the parts of a stroke beyond its ends."""
    sense = 1.0 if places[-1] >= places[0] else -1.0
    outside = (places < guide.along[0]) | (places > guide.along[-1])
    along = np.concatenate((guide.along, places[outside]))
    order = np.argsort(along, kind="stable")
    return _Path(
        np.vstack((guide.points, stroke.points[outside]))[order],
        np.vstack((guide.tangents, sense * stroke.tangents[outside]))[order],
        along[order],
    )
