"""Active contour: a curve that gives way to the strokes drawn over it.

Kara & Shimada, book chapter, section 13.2, move the nodes of a curve by a restitution force,
a location force towards the strokes, and a force that grows with pen pressure. Taken
literally the forces are singular at their goal and do not settle. Here the displacement is
what is smoothed, so an untouched curve is a fixed point; every stroke pulls through one
closest point; and the pull acts along the normal, so nodes do not slide along the curve and
the lift back to space may go node by node.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.ink.checked_points import places_on_sheet
from bozzetto.ink.curves.resample import arc_length, distinct, points_along
from bozzetto.ink.oversketch.bending_energy import Bending
from bozzetto.ink.oversketch.stroke_forces import Pull, Trace, lengthened, pulls_of, trace_of

RESTITUTION_RANGE: Final = (1e-3, 1e3)
"""Least and greatest resistance as a share of the pull. Without any, nodes between the
strokes would not be told where to go; with more, the whole curve is a rod already, and the
numbers of the pull would drown."""

CLOSEST_NODES: Final = 0.5
"""Least spacing of the nodes that move by themselves, px; closer ones go along with them.
Where a curve is seen end-on its nodes crowd together, and their bending has no meaning."""

MOST_NODES: Final = 4000
"""Most nodes that move by themselves."""

NEARNESS: Final = 6.0
"""Length added to the distances, px, by which the location force weighs the strokes.
Without it the nearest of two strokes would take all once it has been reached."""

BLEND: Final = 40.0
"""Least length, px, beyond the end of a stroke over which the curve leads back to where it
was; it is at least twice the step that has to be led back. The rest does not move at all."""

LEASH: Final = 0.01
"""Pull back to the old place on that stretch, as a share of the strokes' pull."""

SETTLED: Final = 0.02
"""Longest step of a node across the curve, px, at which the iteration ends. What nodes
still creep along the curve does not change its shape."""

MOST_STEPS: Final = 20
"""Most iterations. Strokes of one hand take two to ten; of those that contradict each other
some creep on, by a tenth of a pixel a step, which is not worth waiting for."""

MOVED: Final = 1e-3
"""A node that moved less, px, is put back: nobody could tell."""


@dataclass(frozen=True)
class SnakeForces:
    """Weights of what pulls a curve and what resists; only their ratios count.

    The defaults are those of Kara & Shimada, book chapter, section 13.2.2.

    Parameters
    ----------
    restitution : float
        Resistance of the displacement to bending, not below 0.
    location : float
        Preference for the nearest of several strokes, not below 0.
    pressure : float
        Preference for the firmest of several strokes, not below 0.

    Raises
    ------
    UserError
        If a weight is not finite or below 0.
    """

    restitution: float = 0.30
    location: float = 0.40
    pressure: float = 0.30

    def __post_init__(self) -> None:
        weights = (self.restitution, self.location, self.pressure)
        if not np.isfinite(weights).all() or min(weights) < 0:
            raise UserError("The weights of a modification must be finite and not below 0.")


DEFAULT_FORCES: Final = SnakeForces()
"""The weights of the paper, by default."""


@dataclass(frozen=True, eq=False)
class Oversketched:
    """A curve after oversketching.

    Attributes
    ----------
    points : (n, 2) float
        One for each node given, px.
    moved : (n,) bool
        Which nodes are no longer where they were; the others are exactly there.
    steps : int
        Iterations taken.
    """

    points: Array
    moved: Flags
    steps: int


def oversketch_curve(
    curve: ArrayLike,
    strokes: Sequence[tuple[ArrayLike, ArrayLike]],
    *,
    closed: bool = False,
    forces: SnakeForces = DEFAULT_FORCES,
) -> Oversketched:
    """Bend a curve on the sheet towards the strokes drawn over it.

    Strokes over a part of the curve change that part and a short stretch beyond. A stroke
    that runs on beyond an end of an open curve takes the end along.

    Parameters
    ----------
    curve : (n, 2) array_like
        Nodes, px; ``n >= 1``. Their spacing is the finest detail that can come out. A closed
        curve may repeat its first node at the end or not.
    strokes : sequence of ((m, 2) array_like, (m,) array_like)
        Places in px and pressure 0 … 1 of each stroke; ``m >= 1``. They may run along the
        curve or against it.
    closed : bool
        Whether the last node is joined to the first.
    forces : SnakeForces
        What pulls and what resists. Without location and pressure nothing moves.

    Returns
    -------
    Oversketched

    Raises
    ------
    UserError
        If the curve or a stroke is empty or not on the sheet, or a pressure is not a number
        from 0 to 1.
    """
    nodes = places_on_sheet(curve, "curve")
    ink = [(places_on_sheet(at, "stroke"), _pressures(press)) for at, press in strokes]
    whole = forces.location + forces.pressure
    if not ink or whole == 0.0:
        return Oversketched(nodes, np.zeros(len(nodes), bool), 0)

    arc = arc_length(nodes)
    ring = _ring(nodes, arc) if closed else None
    kept = _spread(arc, arc[-1] if ring is None else ring, closed=ring is not None)
    start, along = nodes[kept], arc[kept]
    traces = [trace_of(at, press, start, along, ring) for at, press in ink]
    shape, stations = (start, along) if ring is not None else lengthened(start, along, traces)
    pulls = [pull for trace in traces for pull in pulls_of(trace, stations, ring)]
    free = _within_reach(start, along, traces, ring)
    stiffness, nearest = forces.restitution / whole, forces.location / whole
    settled, steps = _settled(shape, stations, pulls, free, stiffness, nearest, ring)

    shift = settled - start
    if ring is not None:
        along, shift = np.append(along, ring), np.vstack((shift, shift[:1]))
    shift = points_along(shift, along, arc)
    moved = np.linalg.norm(shift, axis=1) > MOVED
    return Oversketched(np.where(moved[:, None], nodes + shift, nodes), moved, steps)


def _pressures(values: ArrayLike) -> Array:
    press = np.array(values, float).ravel()
    if not ((press >= 0) & (press <= 1)).all():
        raise UserError("A stroke's pressure must be a number from 0 to 1.")
    return press


def _ring(nodes: Array, arc: Array) -> float | None:
    """Return the length of a closed curve; None if it has too few places to be one."""
    if len(distinct(nodes, closed=True)) < 3:
        return None
    return float(arc[-1] + np.linalg.norm(nodes[0] - nodes[-1]))


def _spread(arc: Array, length: float, *, closed: bool) -> Index:
    """Return nodes that are not too close to one another; an open curve keeps both ends."""
    step = max(CLOSEST_NODES, length / MOST_NODES)
    kept, last = [0], len(arc) - 1
    while (node := int(np.searchsorted(arc, arc[kept[-1]] + step))) <= last:
        kept.append(node)
    if closed:
        while len(kept) > 1 and length - arc[kept[-1]] < step:
            kept.pop()
    elif kept[-1] != last and arc[last] > arc[kept[-1]]:
        if len(kept) > 1:
            kept.pop()
        kept.append(last)
    return np.array(kept)


def _within_reach(nodes: Array, along: Array, traces: list[Trace], ring: float | None) -> Flags:
    """Return nodes beside a stroke, or on the stretch beyond where the curve leads back."""
    free = np.zeros(len(nodes), bool)
    for trace in traces:
        reach = []
        for end in (0, -1):
            station = trace.stations[end] % ring if ring else trace.stations[end]
            foot = points_along(nodes, along, station)
            reach.append(max(BLEND, 2.0 * float(np.linalg.norm(trace.places[end] - foot))))
        begin, end_ = trace.stations[0] - reach[0], trace.stations[-1] + reach[1]
        beyond = along - begin if ring is None else (along - begin) % ring
        free |= (beyond >= 0) & (beyond <= end_ - begin)
    return free


def _settled(
    shape: Array,
    along: Array,
    pulls: list[Pull],
    free: Flags,
    restitution: float,
    location: float,
    ring: float | None,
) -> tuple[Array, int]:
    """Return the places where the nodes come to rest, and the number of steps.

    Every step solves for the displacement with the closest points held; weights are shares
    of the pull, ``location + pressure = 1``.
    """
    gain = np.full(len(shape), LEASH)
    for pull in pulls:
        gain[pull.nodes] = 1.0
    stiffness = float(np.clip(restitution, *RESTITUTION_RANGE))
    bending = Bending(along, gain, free, stiffness, ring)
    beside = gain == 1.0
    places, steps, longest = shape, 0, np.inf
    while longest >= SETTLED and steps < MOST_STEPS:
        steps += 1
        force = _force(places, pulls, location)
        across = _normal_part(force, places, ring)
        if ring is None:
            across[[0, -1]] = force[[0, -1]]  # ends follow the ends of the strokes
        toward = np.where(beside[:, None], places - shape + across, 0.0)
        new = shape + bending.solve(toward)
        longest = float(np.linalg.norm(_normal_part(new - places, places, ring), axis=1).max())
        places = new
    return places, steps


def _force(places: Array, pulls: list[Pull], location: float) -> Array:
    """Return the force from each node to where the strokes want it; zero where there is none."""
    count = len(places)
    near, near_sum = np.zeros(count), np.zeros((count, 2))
    firm, firm_sum = np.zeros(count), np.zeros((count, 2))
    for pull in pulls:
        here = places[pull.nodes]
        foot, pressure = pull.closest(here)
        way = foot - here
        weight = 1.0 / (np.linalg.norm(way, axis=1) + NEARNESS)
        near[pull.nodes] += weight
        near_sum[pull.nodes] += weight[:, None] * way
        firm[pull.nodes] += pressure
        firm_sum[pull.nodes] += pressure[:, None] * way
    by_location = near_sum / np.where(near > 0, near, 1.0)[:, None]
    # Where no stroke was pressed at all, none is firmer than another.
    pressed = firm_sum / np.where(firm > 0, firm, 1.0)[:, None]
    by_pressure = np.where((firm > 0)[:, None], pressed, by_location)
    return np.asarray(location * by_location + (1.0 - location) * by_pressure)


def _normal_part(force: Array, places: Array, ring: float | None) -> Array:
    """Return the part of a force across the curve; all of it where the curve has no direction."""
    if ring is None:
        ahead, behind = np.vstack((places[1:], places[-1:])), np.vstack((places[:1], places[:-1]))
    else:
        ahead, behind = np.roll(places, -1, axis=0), np.roll(places, 1, axis=0)
    tangent = ahead - behind
    length = np.linalg.norm(tangent, axis=1)
    tangent /= np.where(length > 0, length, 1.0)[:, None]
    return np.asarray(force - np.einsum("nk,nk->n", force, tangent)[:, None] * tangent)
