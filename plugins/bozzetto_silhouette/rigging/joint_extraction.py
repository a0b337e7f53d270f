"""Joints for animators from the skeleton of a part: few, and where limbs bend.

The skeleton that the surface is built around has a node wherever that takes one. Here it is
read as limbs between ends and junctions: limbs that hardly stick out of the body are dropped,
junctions within each other become one, and every limb gets a joint where it leaves the body
and then one about every one and a half radii (after "RigMesh", Borosan et al., 2012, which
places joints by the symmetry of the cross-section; the radius is known exactly here).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from bozzetto.arrays import Array, Index
from bozzetto_silhouette.outline.medial_axis import Skeleton, chains

STANDOFF = 0.5
"""A limb is one if it sticks out of the ball that it starts in by more than this share of that
ball's radius. The corners of a square (0.41) are none."""

SMALLEST = 0.04
"""A limb that sticks out by less than this share of the part's longest side is none, however
thin what it sits on."""

WITHIN = 0.75
"""Junctions nearer than this share of the larger one's radius are one."""

SPACING = 1.5
"""Distance of joints along a limb, in local radii."""

SHORTEST = 0.12
"""Least distance of joints along a limb, as a share of the part's longest side: a spider's leg
bends in a few places, not in forty."""

ALIKE = 0.95
"""Radii that are at least this share of the largest are as good: else the jitter of the hand
would choose among them."""

BOW = 0.75
"""How far the axis of a limb may lie beside the straight line between two joints, in local
radii: beyond, there is a joint in the bend, or the bone would leave the skin."""

SLACK = 0.01
"""The same as a share of the part's longest side, where that is more."""

SAME = 1e-4
"""Share by which the two halves of a symmetric shape may differ."""

SAMPLES = 64
"""Places along a limb at which its thickness is looked at."""


@dataclass(frozen=True, eq=False)
class Joints:
    """A connected graph of joints in the plane of a part.

    Attributes
    ----------
    nodes : (n, 3) float array
        x, y and radius of the ball around each joint, in the part's object frame.
    links : (m, 2) int array
        Pairs of neighbours, without doubles.
    thickness : (m,) float array
        The smallest radius along each link.
    paths : tuple of (k, 3) float arrays
        x, y and radius of the axis along each link, from its first joint to its second.
    """

    nodes: Array
    links: Index
    thickness: Array
    paths: tuple[Array, ...]


@dataclass(eq=False)
class _Limb:
    """A stretch of the skeleton between two ends or junctions; both the same for a ring.

    Attributes
    ----------
    path : (k, 3) float array
        x, y and radius along it, from `start` to `end`.
    """

    path: Array
    start: int
    end: int

    @property
    def length(self) -> float:
        return float(np.hypot(*np.diff(self.path[:, :2], axis=0).T).sum())

    def turned(self) -> _Limb:
        """Return the same limb from its other end."""
        return _Limb(self.path[::-1], self.end, self.start)

    def beyond(self, size: float) -> float:
        """Return how far its end sticks out of the ball at its start; above 1 it is a limb.

        Parameters
        ----------
        size : float
            Longest side of the part.
        """
        away = np.hypot(*(self.path[:, :2] - self.path[0, :2]).T) + self.path[:, 2]
        least = max(STANDOFF * self.path[0, 2], SMALLEST * size)
        return float((away.max() - self.path[0, 2]) / least)


def joints_of(skeleton: Skeleton) -> list[Joints]:
    """Find the joints of a part, one graph for each piece of its skeleton, the largest first.

    Parameters
    ----------
    skeleton : Skeleton
        With at least one node.
    """
    limbs = [_Limb(skeleton.nodes[path], path[0], path[-1]) for path in chains(skeleton)]
    low = (skeleton.nodes[:, :2] - skeleton.nodes[:, 2:]).min(axis=0)
    high = (skeleton.nodes[:, :2] + skeleton.nodes[:, 2:]).max(axis=0)
    size = float((high - low).max())
    pieces = [_graph(_parted(_joined(_proud(piece, size))), size) for piece in _pieces(limbs)]
    return sorted(pieces, key=lambda piece: -float(piece.nodes[:, 2].max()))


def _pieces(limbs: list[_Limb]) -> list[list[_Limb]]:
    """Group the limbs that are connected."""
    pieces: list[tuple[set[int], list[_Limb]]] = []
    for limb in limbs:
        ends, members = {limb.start, limb.end}, [limb]
        apart = []
        for others in pieces:
            if others[0] & ends:
                ends |= others[0]
                members += others[1]
            else:
                apart.append(others)
        pieces = [*apart, (ends, members)]
    return [members for _, members in pieces]


def _degrees(limbs: list[_Limb]) -> dict[int, int]:
    """Count the limbs that start at each end or junction; a ring counts twice."""
    found: dict[int, int] = {}
    for limb in limbs:
        for end in (limb.start, limb.end):
            found[end] = found.get(end, 0) + 1
    return found


def _proud(limbs: list[_Limb], size: float) -> list[_Limb]:
    """Remove the limbs that hardly stick out, the least of them first."""
    limbs = list(limbs)
    while True:
        degrees = _degrees(limbs)
        free = [
            (limb if degrees[limb.end] == 1 else limb.turned(), limb)
            for limb in limbs
            if (degrees[limb.start] == 1) != (degrees[limb.end] == 1)
        ]
        if not free:
            return limbs
        heights = [outwards.beyond(size) for outwards, _ in free]
        least = min(heights)
        if least > 1.0:
            return limbs
        # What is alike goes together, or a symmetric shape would lose one side.
        alike = [pair for pair, height in zip(free, heights, strict=True) if height - least < SAME]
        if len(alike) == len(limbs):
            alike = alike[:1]
        gone = [limb for _, limb in alike]
        limbs = [limb for limb in limbs if not any(limb is other for other in gone)]
        for start in dict.fromkeys(outwards.start for outwards, _ in alike):
            limbs = _through(limbs, start)


def _through(limbs: list[_Limb], node: int) -> list[_Limb]:
    """Join limbs where only two are left at a junction."""
    here = [limb for limb in limbs if node in (limb.start, limb.end)]
    if len(here) != 2 or any(limb.start == limb.end for limb in here):
        return limbs
    first, second = here
    first = first if first.end == node else first.turned()
    second = second if second.start == node else second.turned()
    one = _Limb(np.concatenate([first.path, second.path[1:]]), first.start, second.end)
    return [*(limb for limb in limbs if limb not in here), one]


def _joined(limbs: list[_Limb]) -> list[_Limb]:
    """Merge junctions that lie within one another, at the place of the larger.

    Of two that are equally large it is the middle between them.
    """
    limbs = list(limbs)
    while True:
        degrees = _degrees(limbs)
        between = [
            limb
            for limb in limbs
            if limb.start != limb.end and degrees[limb.start] > 2 < degrees[limb.end]
        ]
        near = min(between, key=_share, default=None)
        if near is None or _share(near) > WITHIN:
            return limbs
        inwards = near if near.path[0, 2] >= near.path[-1, 2] else near.turned()
        kept, gone, place = inwards.start, inwards.end, inwards.path[:1]
        others = [limb for limb in limbs if limb is not near]
        if abs(float(near.path[0, 2] - near.path[-1, 2])) < SAME * place[0, 2]:
            place = _middle(near)
            others = [_led(limb, kept, kept, place) for limb in others]
        limbs = [_led(limb, gone, kept, place) for limb in others]


def _middle(limb: _Limb) -> Array:
    """Return x, y and radius half-way along a limb, (1, 3)."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(limb.path[:, :2], axis=0).T))])
    return np.array([[np.interp(0.5 * along[-1], along, column) for column in limb.path.T]])


def _led(limb: _Limb, gone: int, kept: int, place: Array) -> _Limb:
    """Lead a limb on from a junction that goes to the one that stays."""
    path, start, end = limb.path, limb.start, limb.end
    if start == gone:
        path, start = np.concatenate([place, path]), kept
    if end == gone:
        path, end = np.concatenate([path, place]), kept
    return _Limb(path, start, end)


def _parted(limbs: list[_Limb]) -> list[_Limb]:
    """Split a limb that is alone where it is thickest, to have a root there."""
    (only,) = limbs if len(limbs) == 1 else (None,)
    if only is None or only.start == only.end:
        return limbs
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(only.path[:, :2], axis=0).T))])
    thickest = most_central(only.path[:, 2], np.abs(along - 0.5 * along[-1]))
    if thickest in (0, len(only.path) - 1):
        return limbs
    middle = max(only.start, only.end) + 1
    return [
        _Limb(only.path[: thickest + 1], only.start, middle),
        _Limb(only.path[thickest:], middle, only.end),
    ]


def most_central(radii: Array, away: Array) -> int:
    """Choose, among places nearly as thick as the thickest, the one nearest to the middle."""
    return int(np.where(radii >= ALIKE * radii.max(), away, np.inf).argmin())


def _share(limb: _Limb) -> float:
    """Return the length in radii of the larger end."""
    return limb.length / max(float(limb.path[[0, -1], 2].max()), 1e-300)


def _graph(limbs: list[_Limb], size: float) -> Joints:
    """Make joints at ends, junctions and in between, of a part with its longest side."""
    degrees = _degrees(limbs)
    number: dict[int, int] = {}
    nodes: list[Array] = []
    links: dict[tuple[int, int], tuple[float, Array]] = {}

    def node_of(end: int, place: Array) -> int:
        if end not in number:
            number[end] = len(nodes)
            nodes.append(place)
        return number[end]

    pairs = [frozenset((limb.start, limb.end)) for limb in limbs]
    for limb, pair in zip(limbs, pairs, strict=True):
        # Rings and limbs side by side need joints that tell them apart.
        least = 3 if len(pair) == 1 else 2 if pairs.count(pair) > 1 else 1
        inner, stretches = _between(limb, degrees, size, least)
        row = [node_of(limb.start, limb.path[0])]
        for place in inner:
            row.append(len(nodes))
            nodes.append(place)
        row.append(node_of(limb.end, limb.path[-1]))
        for a, b, stretch in zip(row[:-1], row[1:], stretches, strict=True):
            links[(a, b)] = stretch
    thickest = max(nodes, key=lambda node: float(node[2]))
    if (
        all(degrees[end] < 3 for end in degrees)
        and max(float(np.hypot(*(node - thickest)[:2])) for node in nodes) < 0.5 * thickest[2]
    ):
        # A ball, or nearly: nothing in it bends.
        return Joints(thickest[None], np.zeros((0, 2), np.intp), np.zeros(0), ())
    return Joints(
        np.array(nodes),
        np.array(list(links), np.intp).reshape(-1, 2),
        np.array([thin for thin, _ in links.values()]),
        tuple(path for _, path in links.values()),
    )


def _between(
    limb: _Limb, degrees: dict[int, int], size: float, least: int
) -> tuple[list[Array], list[tuple[float, Array]]]:
    """Return the joints within a limb, and the smallest radius and the axis of each stretch.

    A limb with one free end gets its first joint where it leaves the ball of its junction.
    The rest are evenly spread, a stretch being `SPACING` radii long; and one in each bend.
    """
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(limb.path[:, :2], axis=0).T))])
    length = float(along[-1])
    at = np.linspace(0.0, length, SAMPLES)
    places = np.column_stack([np.interp(at, along, column) for column in limb.path.T])
    first, last = 0.0, length
    hip = tail = False
    if degrees[limb.start] > 2 and degrees[limb.end] == 1:
        first, hip = min(float(places[0, 2]), 0.5 * length), True
    elif degrees[limb.end] > 2 and degrees[limb.start] == 1:
        last, tail = max(length - float(places[-1, 2]), 0.5 * length), True
    pace = 1.0 / np.maximum(SPACING * places[:, 2], SHORTEST * size)
    count = np.concatenate([[0.0], np.cumsum(0.5 * (pace[1:] + pace[:-1]) * np.diff(at))])
    begin, end = np.interp([first, last], at, count)
    pieces = max(round(float(end - begin)), 1 if hip or tail else least)
    stops = np.interp(np.linspace(begin, end, pieces + 1), count, at)
    inner = stops[0 if hip else 1 : len(stops) if tail else -1]
    cuts = _with_bends([0.0, *inner.tolist(), length], at, places, SLACK * size)
    ends = np.column_stack([np.interp(cuts, at, column) for column in places.T])
    ends[[0, -1]] = limb.path[[0, -1]]
    stretches = []
    for k, (a, b) in enumerate(itertools.pairwise(cuts)):
        thin = float(places[(at >= a) & (at <= b), 2].min(initial=np.inf))
        path = [ends[k : k + 1], limb.path[(along > a) & (along < b)], ends[k + 1 : k + 2]]
        stretches.append((thin, np.concatenate(path)))
    return list(ends[1:-1]), stretches


def _with_bends(cuts: list[float], at: Array, places: Array, slack: float) -> list[float]:
    """Add stops along a limb where its axis lies too far beside a bone.

    Parameters
    ----------
    cuts : list of float
        Ascending, as lengths along the limb.
    at : (n,) float array
        Samples of the axis, as lengths along the limb.
    places : (n, 3) float array
        x, y and radius of the axis there.
    slack : float
        How far it may always lie beside.
    """
    found = cuts[:1]
    waiting = cuts[:0:-1]
    while waiting:
        a, b = found[-1], waiting[-1]
        between = np.flatnonzero((at > a) & (at < b))
        here, there = (np.array([np.interp(s, at, c) for c in places.T[:2]]) for s in (a, b))
        chord = there - here
        off = places[between, :2] - here
        t = np.clip(off @ chord / max(float(chord @ chord), 1e-300), 0.0, 1.0)
        beside = np.hypot(*(off - t[:, None] * chord).T)
        excess = beside / np.maximum(BOW * places[between, 2], slack)
        if len(between) and excess.max() > 1.0:
            waiting.append(float(at[between[excess.argmax()]]))
        else:
            found.append(waiting.pop())
    return found
